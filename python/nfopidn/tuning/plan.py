"""The stages of a tuning, as the core runs them, and their checkpoints."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn.engines import Engine, processors
from nfopidn.search.optimise import (
    METHODS,
    Callback,
    Settings,
    finish,
    nothing_found,
    problem_in,
    run,
)
from nfopidn.tuning.engine_costs import CandidateCosts, on_engine
from nfopidn.tuning.parameters import ControllerSearch, Mean, RivalSearch, Search, Structure
from nfopidn.tuning.result import TuneResult


@dataclass
class Plan:
    """What a tuning searches, stage by stage.

    The search of a controller's free taps without a start has a stage for gains and orders before
    it; one that may also choose what the lateral channel is fed has an alternative a choice. The
    core shares evaluations and time out to the stages (nfopidn/tuning/tune.hpp).
    """

    scenarios: list[Scenario]
    search: Search
    structure: Structure
    start: Controller | Rival | None
    gains: dict[str, Search]  # at most one, by its name
    alternatives: dict[str, Search]  # by their names; the last one has none
    mean: Mean = (1.0, [])
    workers: int | Engine = 1
    #: The alternative that run() has found the best.
    chosen: Search | None = None

    @classmethod
    def of(
        cls,
        search: Search,
        structure: Structure,
        start: Controller | Rival | None,
        scenarios: list[Scenario],
    ) -> Plan:
        """Make the plan of a search."""
        gains: dict[str, Search] = {}
        alternatives: dict[str, Search] = {"": search}
        if isinstance(search, ControllerSearch):
            either = isinstance(structure, str) and structure == "taps"
            first, own = search.stages(either, start is not None)
            gains, alternatives = {**first}, {**own}
        return cls(scenarios, search, structure, start, gains, alternatives)

    def suffixes(self) -> list[str]:
        """Give the suffixes of the stages' checkpoints."""
        return [_suffix(name) for name in (*self.alternatives, *self.gains)]

    def check_start(self) -> None:
        """Refuse a start that the structure cannot have, or that lies beyond the bounds."""
        search, start = self.search, self.start
        if start is None:
            return
        first = search.start(start)
        if isinstance(search, ControllerSearch) and search.parameters == "shared-orders":
            for name in ("alpha", "sigma"):
                if np.ptp(getattr(start, name)) > 0:
                    raise ValueError(f"start has a {name} for each channel; the structure has one")
        for name, value, low, high in zip(
            search.names, first, search.low, search.high, strict=True
        ):
            slack = 1e-9 * (high - low)
            if not low - slack <= value <= high + slack:
                raise ValueError(f"start has {name} {value:.6g}; must be in [{low:g}, {high:g}]")

    def check_checkpoints(self, settings: Settings) -> None:
        """Refuse checkpoints of other searches before the first stage begins.

        What a stage starts from, and the evaluations left for it, are known only then.
        """
        stages = self.gains | self.alternatives
        if len(stages) == 1 or not settings.checkpoint:
            return
        for name in stages:
            path = settings.checkpoint + _suffix(name)
            if not Path(path).exists():
                continue
            found = problem_in(path)
            known = json.loads(self._problem(name, settings))
            del known["maxfev"], known["start"]
            if found is None or any(key not in found or found[key] != known[key] for key in known):
                which = (
                    "damaged, or no checkpoint"
                    if found is None
                    else "the checkpoint of another search"
                )
                raise ValueError(f"checkpoint: {path}: is {which}; give another path, or remove it")

    def run(self, settings: Settings, callback: Callback | None) -> TuneResult:
        """Search, in the core."""
        search = self.search
        request = settings.request(search.low, search.high, {})
        with ExitStack() as stack:
            if isinstance(self.workers, Engine):
                engine = stack.enter_context(self.workers)
                request["engine"] = on_engine(engine, self._costs, stack)
                request["engine_workers"] = engine.count()
            search_with = partial(self._run_core, settings)
            reply, raised = run(search_with, request, settings, callback, "tune")
        if reply["nfev"] == 0 or len(reply["x"]) == 0:  # there is no best so far
            raise raised or nothing_found(reply)
        stage = list(self.alternatives.values())[reply.pop("alternative")]
        self.chosen = stage
        result = TuneResult(
            seed=settings.seed,
            structure="paper" if self.structure is None else self.structure,
            options=settings.options,
            method=settings.method,
            parameters=search.names,
            scenario=self.scenarios[0] if len(self.scenarios) == 1 else self.scenarios,
            controller=stage.controller(reply["x"]),
        )
        finish(result, reply, raised, (search.low, search.high))
        return result

    @property
    def threads(self) -> int:
        """Of this process: gradients are computed here, whoever gives the costs."""
        return self.workers if isinstance(self.workers, int) else processors()

    def _costs(self, name: str) -> CandidateCosts:
        """Give the costs of a stage as an engine's workers are given them."""
        search = self.search
        if isinstance(search, ControllerSearch):
            search = (self.gains | self.alternatives)[name]
        return CandidateCosts(self.scenarios, search, self.mean)

    def _run_core(self, settings: Settings, request: dict[str, Any]) -> dict[str, Any]:
        search = self.search
        start = None if self.start is None else search.start(self.start)
        if isinstance(search, RivalSearch):
            request.update(problem=self._problem("", settings), start=start)
            reply = _core.search_rival(
                *(self.scenarios, search.base, search.source, search.fixed),
                *(*self.mean, self.threads, request),
            )
            return reply | {"alternative": 0}
        described = {
            name: (name, stage.space, self._problem(name, settings))
            for name, stage in (self.gains | self.alternatives).items()
            if isinstance(stage, ControllerSearch)
        }
        return _core.run_plan(
            self.scenarios,
            next((described[name] for name in self.gains), None),
            [described[name] for name in self.alternatives],
            np.zeros(0) if start is None else start,
            *self.mean,
            self.threads,
            request,
        )

    def _problem(self, name: str, settings: Settings) -> str:
        """Describe a stage for its checkpoint; the core adds start and evaluations."""
        stage = self.gains[name] if name in self.gains else self.alternatives[name]
        if name in self.gains:  # by the default method, whatever follows
            settings = replace(settings, method=METHODS[0], options={})
        worst_share, caps = self.mean
        problem = {
            "kind": "tune",
            "scenario": [json.loads(one.to_json()) for one in self.scenarios],
            **stage.problem(),
            "source": stage.source,
            "fixed": stage.fixed,
            "worst_share": worst_share,
            "start": None,
            # A checkpoint from before costs had caps is still the same.
            **({"caps": caps} if caps else {}),
        }
        return str(settings.request(stage.low, stage.high, problem)["problem"])


def _suffix(name: str) -> str:
    return f".{name}" if name else ""
