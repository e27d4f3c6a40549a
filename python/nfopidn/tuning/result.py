"""What tune() finds, and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Controller, Rival, Robot, Scenario
from nfopidn.families.family import Family
from nfopidn.files import replace_file
from nfopidn.robustness.judgement import verdict
from nfopidn.robustness.verdict import COLOURS, Verdict
from nfopidn.search.optimise import HISTORY, Array, OptimizeResult
from nfopidn.tuning.parameters import ROBOT_FIELDS

TUNING_FORMAT = "nfopidn-tuning"
TUNING_VERSION = 1

#: What a document must have, besides those that from_json() reads one by one.
_FIELDS = (
    *("fun", "nfev", "nit", "parameters", "seed", "message", "success", "status", "elapsed"),
    *("structure", "options", "method"),
)


class TuneResult(OptimizeResult):
    """The result of tune(): also controller, scenario, structure, parameters, method, options.

    x holds the free parameters, which `parameters` names; controller has them all. `constraints`,
    of a search within some, has for each its `value`, `low`, `high`, `unit` and `met`.
    `verdict` says whether the controller may be trusted; it is found when it is first asked for.
    """

    @property
    def verdict(self) -> Verdict:
        """Judge the controller on the scenario, or on each of several: the worst is the answer.

        Of a Family the first scenario is judged, and its members are the variations.

        Raises
        ------
        ValueError
            A reference never moves.
        """
        known: Verdict | None = self.__dict__.get("_verdict")
        if known is None:
            known = _judge(self)
            self.__dict__["_verdict"] = known
        return known

    def to_json(self, path: str | PathLike[str]) -> None:
        """Write the result; `controller` in it is a controller document of its own."""
        fields = {
            key: value.tolist() if isinstance(value, np.ndarray) else value
            for key, value in self.items()
        }
        fields["history"] = [list(row) for row in fields["history"]]
        fields["controller"] = json.loads(self["controller"].to_json())
        fields["scenario"] = [
            json.loads(scenario.to_json()) for scenario in scenario_list(self.scenario)
        ]
        if "family" in fields:
            fields["family"] = family_rows(self["family"])
        document = {"format": TUNING_FORMAT, "version": TUNING_VERSION, **plain(fields)}
        replace_file(path, json.dumps(document, indent=1, allow_nan=False) + "\n")

    @classmethod
    def from_json(cls, path: str | PathLike[str]) -> TuneResult:
        """Read what to_json() has written.

        Raises
        ------
        ValueError
            Names the file, and what in it is not as it must be.
        """
        try:
            fields = json.loads(_core.read_text(path))
            if fields.pop("format") != TUNING_FORMAT or fields.pop("version") != TUNING_VERSION:
                raise ValueError(
                    f"must be a document {TUNING_FORMAT!r} of version {TUNING_VERSION}"
                )
            for key in _FIELDS:
                fields[key]
            fields["fun"] = _number_in(fields, "fun")
            fields["nfev"] = int(_number_in(fields, "nfev"))
            for key in ("x", "population", "population_energies"):
                fields[key] = np.array(fields[key], dtype=float)
            check_names(fields["parameters"], fields["x"])
            if "active_mask" in fields:
                fields["active_mask"] = _mask_in(fields)
            shape = (len(fields["population_energies"]), len(fields["x"]))
            fields["population"] = fields["population"].reshape(shape)
            history = [tuple(row) for row in fields["history"]]
            fields["history"] = np.array(history, dtype=[(name, float) for name in HISTORY])
            kind = Rival if fields["controller"].get("format") == "nfopidn-rival" else Controller
            fields["controller"] = kind.from_json(json.dumps(fields["controller"]))
            scenarios = scenarios_in(fields["scenario"])
            if "family" in fields:
                fields["family"] = family_in(fields["family"])
            structure = fields["structure"]
            if isinstance(structure, dict) and isinstance(structure.get("robot"), dict):
                structure["robot"] = Robot(**structure["robot"])
        except (
            *(ValueError, TypeError, LookupError, AttributeError, ArithmeticError),
            RecursionError,
        ) as error:
            raise ValueError(f"{path}: not a tuning result: {error}") from None
        fields["scenario"] = scenarios[0] if len(scenarios) == 1 else scenarios
        return cls(fields)


def _judge(result: TuneResult) -> Verdict:
    bound = [f"{name} at its {side} bound" for name, side in result.at_bounds().items()]
    family: Family | None = result.get("family")
    if family is not None and list(family) == scenario_list(result.scenario):  # it was given
        return verdict(result.controller, family.scenarios[0], family=family, at_bound=bound)
    scenarios = scenario_list(result.scenario)
    found = [verdict(result.controller, scenario, at_bound=bound) for scenario in scenarios]
    worst = max(found, key=lambda one: COLOURS.index(one.colour))
    if len(found) == 1:
        return worst
    reasons = [f"scenario {i + 1}: {why}" for i, one in enumerate(found) for why in one.reasons]
    return replace(worst, reasons=tuple(reasons))


def check_names(names: Any, x: Array) -> None:
    """Refuse parameters that are no names, or more or fewer than there are numbers."""
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError("parameters must be a list of names")
    if np.shape(x) != (len(names),):
        raise ValueError(f"x must have {len(names)} numbers, one for each parameter")


def scenarios_in(documents: Sequence[Any]) -> list[Scenario]:
    """Give the scenarios of a file, at least one."""
    scenarios = [Scenario.from_json(json.dumps(one)) for one in documents]
    if not scenarios:
        raise ValueError("scenario is empty")
    return scenarios


def family_rows(family: Family) -> list[dict[str, Any]]:
    """Give what a file holds of a family."""
    rows = zip(family.names, family.scenarios, family.changes, strict=True)
    return [
        {"name": name, "scenario": json.loads(scenario.to_json()), "change": change}
        for name, scenario, change in rows
    ]


def family_in(rows: Sequence[Mapping[str, Any]]) -> Family:
    """Give the family of a file."""
    return Family.of(
        (str(row["name"]), Scenario.from_json(json.dumps(row["scenario"])), str(row["change"]))
        for row in rows
    )


def _mask_in(fields: Mapping[str, Any]) -> Array:
    mask = np.array(fields["active_mask"], dtype=float)
    if mask.shape != np.shape(fields["x"]) or not np.isin(mask, (-1, 0, 1)).all():
        raise ValueError("active_mask must have -1, 0 or 1 for each number of x")
    return mask.astype(np.int64)


def _number_in(fields: Mapping[str, Any], key: str) -> float:
    try:
        return float(fields[key])
    except (TypeError, ValueError):
        raise ValueError(f"{key} must be a number") from None


def plain(value: Any) -> Any:
    """Give what JSON can hold: of NumPy's making plain numbers, of what is not finite its name."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, Robot):
        return {name: getattr(value, name) for name in ROBOT_FIELDS}
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    if value is None or isinstance(value, str | bool | int | float):
        return value
    raise TypeError(f"{type(value).__name__} has no place in a file")


def scenario_list(scenario: Scenario | Sequence[Scenario]) -> list[Scenario]:
    """Give a list of the scenarios, of which there may be one without a list."""
    return [scenario] if isinstance(scenario, Scenario) else list(scenario)
