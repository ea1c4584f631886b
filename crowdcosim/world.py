"""The ground plane: its extent, its walls, and where it wraps around."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A straight wall of no thickness, seen by every sensor."""

    start: tuple[float, float]
    """one end (x, y) [m]"""
    end: tuple[float, float]
    """other end (x, y) [m]"""
    stops_people: bool = True
    """False: people walk through it, robots do not (the paper's corridor)"""


@dataclass(frozen=True, kw_only=True)
class World:
    """A rectangle from (0, 0) to `size`, in the frame `map` (x forward, y left, right-handed: REP 103)."""

    size: tuple[float, float]
    """extent in x and y [m]"""
    periodic: tuple[bool, bool] = (False, False)
    """axes along which people who leave re-enter at the opposite side, and are felt and seen across the seam"""
    walls: tuple[Wall, ...] = ()
    """all walls, numbered from 1 in this order"""

    @cached_property
    def period(self) -> NDArray[np.float64]:
        """(2,) period of each axis [m], 0 where the world does not wrap around."""
        return np.where(self.periodic, np.asarray(self.size, np.float64), 0.0)

    @cached_property
    def segments(self) -> NDArray[np.float64]:
        """(W, 2, 2) both ends of every wall [m]."""
        return np.array([(w.start, w.end) for w in self.walls], np.float64).reshape(-1, 2, 2)

    @cached_property
    def segments_for_people(self) -> NDArray[np.float64]:
        """(W', 2, 2) both ends of the walls that stop people [m]."""
        return self.segments[[w.stops_people for w in self.walls]].reshape(-1, 2, 2)

    @cached_property
    def _divisor(self) -> NDArray[np.float64]:
        """The period, infinite where there is none: then nothing is ever a whole period away."""
        return np.where(self.period > 0, self.period, np.inf)

    def wrap(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) points moved by whole periods into [0, size) along the periodic axes [m]."""
        period = np.where(self.period > 0, self.period, 1.0)
        wrapped = np.where(self.period > 0, np.mod(position, period), position)
        # A tiny negative coordinate rounds to the period itself, which is the other name of 0.
        return np.where((self.period > 0) & (wrapped >= period), 0.0, wrapped)

    def displacement(self, origin: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) shortest vectors from `origin` to `target`, across the seam where that is shorter [m]."""
        d = np.subtract(target, origin, dtype=np.float64)
        return np.asarray(d - np.rint(d / self._divisor) * self.period)
