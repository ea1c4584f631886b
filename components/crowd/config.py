"""What a scenario may say about its crowd."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from components.crowd.areas import Area
from components.crowd.flows import Flow
from components.crowd.journeys import Journey
from components.crowd.people import Population, Traits


@dataclass(frozen=True, kw_only=True)
class Config(Traits):
    """Who is in the crowd, where they go, and how they react: `count`, `positions` or `journeys` must be given."""

    reactive: bool = True
    """False: everybody walks through robots, whatever their `reaction`"""
    flow: Flow = "1d+"
    """where people go: 1d+ along x, 1d- against x, 1dx half and half, 2d along y, 2dx half and half in y"""
    count: int | None = None
    """number of people, placed at random without overlap"""
    positions: tuple[tuple[float, float], ...] | None = None
    """initial centres, [x, y] of everybody [m]"""
    goals: tuple[tuple[float, float], ...] | None = None
    """where those at `positions` walk to, one after the other, instead of with a flow: [x, y] of everybody [m]"""
    areas: Mapping[str, Area] = field(default_factory=dict)
    """places with a name, for `journeys`"""
    journeys: tuple[Journey, ...] = ()
    """people who walk through areas, who come and go"""
    populations: tuple[Population, ...] = ()
    """parts of the crowd that differ from the rest of this config"""

    def __post_init__(self) -> None:
        super().__post_init__()
        given = [name for name in ("count", "positions", "journeys") if getattr(self, name) not in (None, ())]
        if len(given) != 1:
            found = " and ".join(given) if given else "none of count, positions and journeys"
            raise ValueError(f"{found} given, expected one of count, positions and journeys")
        for i, journey in enumerate(self.journeys):
            for name in (journey.start, *(stop.area for stop in journey.stops)):
                if name not in self.areas:
                    known = ", ".join(self.areas) or "none"
                    raise ValueError(f"journeys[{i}]: there is no area '{name}', expected one of `areas` ({known})")
        if self.goals is not None and len(self.goals) != len(self.positions or ()):
            raise ValueError(
                f"goals has {len(self.goals)} entries, expected one for each of {len(self.positions or ())} positions"
            )
        if self.count is not None and self.count < 0:
            raise ValueError(f"count is {self.count}, expected zero or more")
        for name in ("positions", "goals"):
            for i, centre in enumerate(getattr(self, name) or ()):
                if not all(math.isfinite(c) for c in centre):
                    raise ValueError(f"{name}[{i}] is {list(centre)}, expected two finite numbers")
        names = [part.name for part in self.populations]
        for i, name in enumerate(names):
            if name in names[:i]:
                raise ValueError(f"populations[{i}].name: '{name}' is there twice, expected names of their own")
        for i, (_, _, traits) in enumerate(self.parts):
            if self.positions is not None and any(share > 0 for share in traits.groups[1:]):
                name = f"populations[{i}].groups" if self.populations else "groups"
                raise ValueError(
                    f"{name} is {list(traits.groups)}, expected [1]: whoever has a place in `positions` walks alone"
                )

    @property
    def parts(self) -> list[tuple[str, float, Traits]]:
        """Name, share and traits of each population, of the whole crowd if it has none."""
        if not self.populations:
            return [("", 1.0, self)]
        return [(part.name, part.share, part.traits(self)) for part in self.populations]
