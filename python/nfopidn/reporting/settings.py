"""Settings as rows of a table: name, value with unit, meaning."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from nfopidn._core import Scenario, SimulationResult, metric_fields
from nfopidn.reporting.numbers import readable
from nfopidn.reporting.words import CHOICES, METRICS, SCENARIO, Words

_DIGITS = 10  # of a setting, which is to be read as it was given
_LONGEST_LIST = 3


class Row(NamedTuple):
    """One line of a table."""

    label: str
    value: str
    meaning: str


def _flat(document: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in document.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def value_text(key: str, value: Any, unit: str) -> str:
    """Write a setting's value with its unit, a word with what it stands for."""
    name = key.rpartition(".")[2]
    plain = {None: "none", True: "yes", False: "no"}
    word = plain.get(value) if value is None or isinstance(value, bool) else None
    if word is None and isinstance(value, str | int | float):
        word = value if isinstance(value, str) else f"{value:.{_DIGITS}g}"
    if word is not None and (name, word) in CHOICES:
        return CHOICES[name, word]
    if isinstance(value, list):
        if len(value) > _LONGEST_LIST or not all(isinstance(one, int | float) for one in value):
            return f"{len(value)} values, one a sample"
        units = [*unit.split(","), *[""] * len(value)]
        return ", ".join(value_text("", one, units[i]) for i, one in enumerate(value))
    if word is None or isinstance(value, str) or value is None or isinstance(value, bool):
        return str(word)
    if unit == "samples" and value == 1:
        return "1 sample"
    return f"{readable(value, _DIGITS)} {unit}".rstrip()


def scenario_groups(scenario: Scenario) -> dict[str, list[Row]]:
    """Return every setting of a scenario, by group; one without words keeps its key."""
    values = dict(_flat(json.loads(scenario.to_json())))
    for key in ("format", "version"):
        values.pop(key, None)
    if values["trajectory.name"] != "ranunculoid":
        values.pop("trajectory.cusps", None)
    groups = {
        group: [setting_row(key, values.pop(key), words[key]) for key in words if key in values]
        for group, words in SCENARIO.items()
    }
    groups["Run"] += [setting_row(key, value, Words(key, "", "")) for key, value in values.items()]
    return groups


def setting_row(key: str, value: Any, words: Words) -> Row:
    """Return the line of one setting."""
    return Row(words.label, value_text(key, value, words.unit), words.meaning)


def metric_rows(run: SimulationResult) -> list[Row]:
    """Return every metric of a run; one without words keeps its key."""
    rows = []
    fields = metric_fields()
    for key, value in run.metrics.items():
        label, meaning = METRICS.get(key, (key, ""))
        is_share = key == "share_at_limit"
        unit = "%" if is_share else fields[key][0].replace("^2", "²")
        text = f"{readable(100 * value if is_share else value)} {unit}".rstrip()
        rows.append(Row(label, text, meaning))
    return rows


def differences(scenario: Scenario, first: Scenario) -> str:
    """Return the settings of a scenario that are not the first one's, in words."""
    before = {row.label: row.value for rows in scenario_groups(first).values() for row in rows}
    return ", ".join(
        f"{row.label.lower()} {row.value}"
        for rows in scenario_groups(scenario).values()
        for row in rows
        if before.get(row.label) != row.value
    )
