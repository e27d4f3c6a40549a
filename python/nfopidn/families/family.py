"""A family: scenarios with names, and what each changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import overload

from nfopidn._core import Scenario


@dataclass(frozen=True)
class Family(Sequence[Scenario]):
    """Scenarios with names, as a sequence; prints as a table.

    Attributes
    ----------
    names
        one a scenario, no two alike
    scenarios
        as many
    changes
        for each, in words with units, what it changes of the first; "" of one that changes nothing
    """

    names: tuple[str, ...]
    scenarios: tuple[Scenario, ...]
    changes: tuple[str, ...]

    def __post_init__(self) -> None:
        """Refuse what is no family.

        Raises
        ------
        ValueError
            No scenario, a name that stands twice, or lists of different lengths.
        """
        if not self.scenarios:
            raise ValueError("the family is empty; must have at least one scenario")
        if not len(self.names) == len(self.scenarios) == len(self.changes):
            raise ValueError(
                f"the family has {len(self.names)} names, {len(self.scenarios)} scenarios and "
                f"{len(self.changes)} changes; must have as many of each"
            )
        for name in self.names:
            if self.names.count(name) > 1:
                raise ValueError(f"the family has two scenarios named {name!r}; must have one")
        for name, one in zip(self.names, self.scenarios, strict=True):
            if not isinstance(one, Scenario):
                raise ValueError(f"the family's {name!r} is {one!r}; must be a Scenario")

    @classmethod
    def of(cls, members: Iterable[tuple[str, Scenario, str]]) -> Family:
        """Make one of names, scenarios and changes."""
        rows = list(members)
        return cls(
            tuple(name for name, _, _ in rows),
            tuple(scenario for _, scenario, _ in rows),
            tuple(change for _, _, change in rows),
        )

    def __len__(self) -> int:
        """Give the number of scenarios."""
        return len(self.scenarios)

    def __iter__(self) -> Iterator[Scenario]:
        """Give the scenarios in order."""
        return iter(self.scenarios)

    @overload
    def __getitem__(self, place: int | str) -> Scenario: ...
    @overload
    def __getitem__(self, place: slice) -> Family: ...
    def __getitem__(self, place: int | str | slice) -> Scenario | Family:
        """Give a scenario by place or by name, or the family of a slice."""
        if isinstance(place, slice):
            return Family(self.names[place], self.scenarios[place], self.changes[place])
        if isinstance(place, str):
            if place not in self.names:
                raise KeyError(f"no scenario is named {place!r}; known: {', '.join(self.names)}")
            return self.scenarios[self.names.index(place)]
        return self.scenarios[place]

    def __add__(self, other: Family) -> Family:
        """Give the scenarios of both, whose names must differ."""
        if not isinstance(other, Family):
            return NotImplemented
        return Family(
            self.names + other.names,
            self.scenarios + other.scenarios,
            self.changes + other.changes,
        )

    def renamed(self, prefix: str) -> Family:
        """Give the same with `prefix/` before each name."""
        return Family(
            tuple(f"{prefix}/{name}" for name in self.names), self.scenarios, self.changes
        )

    def items(self) -> Iterator[tuple[str, Scenario]]:
        """Give names and scenarios in pairs."""
        return zip(self.names, self.scenarios, strict=True)

    def __str__(self) -> str:
        rows = list(zip(self.names, self.changes, strict=True))
        width = max(len(name) for name in self.names)
        return "\n".join(f"{name:{width}}  {change}".rstrip() for name, change in rows)
