"""Who takes part in a comparison, by name, and their tuning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Event
from typing import Any

from nfopidn._core import Controller, Rival, Scenario, StopIf
from nfopidn.arguments import names_in, suggestion, whole_number
from nfopidn.console import progress as progress_bar
from nfopidn.search.interrupts import wish_to_stop
from nfopidn.tuning.parameters import controller_structure
from nfopidn.tuning.tuner import tune

AnyController = Controller | Rival

_SETTINGS, _PARAMETERS = controller_structure("extended")
_EXTENDED = {**_SETTINGS, "parameters": _PARAMETERS}
_INCREMENTAL = controller_structure("incremental")[0]
_WHOLE = {"alpha": 1.0, "sigma": 1.0}
_WHOLE_EACH = {f"{order}_{name}": 1.0 for order in _WHOLE for name in ("x", "y", "theta")}


@dataclass(frozen=True)
class Contender:
    """What tune() is given for it; without a structure it stays as `fixed` is."""

    structure: Mapping[str, Any] | str | None = None
    frozen: Mapping[str, float] | None = None
    fixed: AnyController | None = None


def _rival(law: str, speeds: str) -> Contender:
    return Contender({"law": law, "speeds": speeds})


#: Everyone by name.
CONTENDERS: dict[str, Contender] = {
    "published": Contender(fixed=Controller.published()),
    "paper": Contender("paper"),
    "decoupled": Contender("decoupled"),
    "incremental": Contender("incremental"),
    "extended": Contender("extended"),
    "free taps": Contender("taps"),
    "extended, linear": Contender({**_EXTENDED, "activation": "linear"}),
    "extended, whole orders": Contender(_EXTENDED, _WHOLE_EACH),
    "extended, memory 1": Contender({**_EXTENDED, "memory": 1}),
    "extended, memory 10": Contender({**_EXTENDED, "memory": 10}),
    "extended, paper allocation": Contender({**_EXTENDED, "allocation": "paper"}),
    "extended, plain lateral": Contender({**_EXTENDED, "lateral": "direction"}),
    "extended, shared orders": Contender({**_EXTENDED, "parameters": "shared-orders"}),
    "FOPID": Contender({**_INCREMENTAL, "activation": "linear"}),
    "NPID neural": Contender({**_INCREMENTAL, "generator": "gl"}, _WHOLE),
    "PID": Contender({**_INCREMENTAL, "generator": "gl", "activation": "linear"}, _WHOLE),
    **{law: _rival(law, "measured") for law in Rival.laws()},
    **{f"{law}, pose only": _rival(law, "differenced") for law in Rival.laws()},
}

#: Names that stand for several.
GROUPS: dict[str, list[str]] = {
    "all": [
        *("published", "paper", "decoupled", "incremental", "extended", "free taps"),
        *("FOPID", "NPID neural", "PID"),
        *Rival.laws(),
    ],
    "pose-only": ["extended", *(f"{law}, pose only" for law in Rival.laws())],
    "ablation": ["extended", *(name for name in CONTENDERS if name.startswith("extended, "))],
}


def contender_names(names: Sequence[str]) -> list[str]:
    """Put the members in the place of groups; every name once.

    Raises
    ------
    ValueError
        A name that is not known.
    """
    chosen: list[str] = []
    for name in names_in("controllers", names):
        members = GROUPS.get(name, [name])
        for member in members:
            if member not in CONTENDERS:
                known = [*GROUPS, *CONTENDERS]
                hint = suggestion(member, known)
                listed = ", ".join(map(repr, known))
                raise ValueError(f"controller {member!r} is not known{hint}; known: {listed}")
            if member not in chosen:
                chosen.append(member)
    return chosen


def tune_contenders(
    names: Sequence[str],
    scenario: Scenario,
    *,
    seeds: int = 10,
    maxfev: int = 10_000,
    workers: int = 1,
    progress: bool = False,
) -> dict[str, list[AnyController]]:
    """Tune contenders alike: by bfoa+, with the same budget and the same seeds 0, 1, 2, ...

    Parameters
    ----------
    names
        Of CONTENDERS or GROUPS.
    scenario
        On which they are tuned.
    seeds
        Searches of each.
    maxfev
        Evaluations of each search.
    workers
        Searches at a time. The results do not depend on it.
    progress
        Whether to show a bar.

    Returns
    -------
    dict
        A list of `seeds` controllers for each name; of one that is not tuned, itself. Ctrl-C ends
        the searches, and only those names are there whose searches were all complete.

    Raises
    ------
    ValueError
        A name that is not known; seeds, maxfev or workers below 1.
    """
    whole_number("seeds", seeds, 1)
    whole_number("maxfev", maxfev, 1)
    whole_number("workers", workers, 1)
    chosen = contender_names(names)
    jobs = [(name, seed) for name in chosen if not CONTENDERS[name].fixed for seed in range(seeds)]

    stopped: set[str] = set()

    def search(job: tuple[str, int]) -> AnyController | None:
        name, seed = job
        if stop.is_set():
            return None
        contender = CONTENDERS[name]
        try:
            with StopIf(stop.is_set):
                result = tune(
                    scenario,
                    robustness=None,
                    structure=contender.structure,
                    frozen=contender.frozen,
                    rng=seed,
                    maxfev=maxfev,
                    callback=_ends_with(stop),
                )
        except KeyboardInterrupt:  # before the search knew a first cost
            return None
        controller: AnyController = result.controller
        return None if stop.is_set() else controller

    found: dict[str, list[AnyController]] = {
        name: [fixed] for name in chosen if (fixed := CONTENDERS[name].fixed)
    }
    with (
        wish_to_stop() as stop,
        progress_bar("tuning", len(jobs), progress) as report,
        ThreadPoolExecutor(workers) as pool,
    ):
        for done, (job, controller) in enumerate(zip(jobs, pool.map(search, jobs), strict=True)):
            if controller is None:
                stopped.add(job[0])
            else:
                found.setdefault(job[0], []).append(controller)
            report(done + 1, job[0])
    return {name: found[name] for name in chosen if name not in stopped}


def _ends_with(stop: Event) -> Callable[[Any], None]:
    """Give a callback that ends a search once the event is set."""

    def callback(_: Any) -> None:
        if stop.is_set():
            raise StopIteration

    return callback
