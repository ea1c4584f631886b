"""People who come during the episode: when, and where there is room for them.

The number of people who are to come until t is that of the rate's integral L(t): one each time that L has grown by 1
(regular), or by a random length of mean 1, drawn from the exponential distribution (a Poisson process, also
where the rate changes). Whoever finds no room in the area waits outside, first come first served, and is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.areas import Area
from components.crowd.journeys import Journey
from components.crowd.people import People, Traits, draw_people
from components.crowd.placement import is_free, solid_edges
from components.crowd.rows import select
from components.crowd.walls import WallGrid, Walls
from crowdcosim.setup import Setup

Array = NDArray[np.float64]

ATTEMPTS = 30
"""so many random places without room, and people wait for the next step"""
BATCH = 32
"""people are drawn in batches, in which shares of populations are kept"""
COMING = 1000
"""streams of chance from here on are those of people on journeys"""


def stream_of(setup: Setup, journey: int, batch: int) -> Callable[[int], np.random.Generator]:
    """Streams of chance of the people of a journey, one batch after another; batch 0 is there at t = 0."""
    return lambda stream: setup.rng(COMING + stream, 1 + journey, 1 + batch)


class Sources:
    """The people who come, in a queue for each journey."""

    def __init__(
        self,
        setup: Setup,
        journeys: Sequence[Journey],
        areas: Mapping[str, Area],
        populations: Sequence[tuple[str, float, Traits]],
    ) -> None:
        world = setup.world
        self._setup, self._journeys = setup, journeys
        # Whoever comes later comes alone.
        self._populations = [(name, share, replace(traits, groups=(1.0,))) for name, share, traits in populations]
        self._rng = setup.rng(COMING, 1)
        self._bounds = [areas[journey.start].bounds for journey in journeys]
        self._walls, self._solid, self._period = Walls.of(world), solid_edges(world), world.period
        self._extent = np.asarray(world.size, np.float64)
        self.outside = [0] * len(journeys)
        """people of each journey who have come and not found room yet"""
        self._after = [self._interval(journey) for journey in journeys]
        self._drawn = [0] * len(journeys)
        self._batch = [self._draw(j) if self._comes(j) else None for j in range(len(journeys))]
        # Compiles or loads the kernel.
        _first_free(np.empty((0, 2)), 0.3, np.empty((0, 3)), self._walls.within(0.3), self._solid, self._period)

    def enter(self, time: int, position: Array, radius: Array, robots: Array) -> Iterator[tuple[int, People, Array]]:
        """Those who come in at `time` [ns], one by one: index of the journey, what they are like, place (1, 2) [m].

        Args:
            time: [ns]
            position: (N, 2) of those who are there [m]
            radius: (N,) of those who are there [m]
            robots: (M, 3) x, y and radius of robots [m]
        """
        entered = np.empty((0, 3))
        for j, journey in enumerate(self._journeys):
            while self._after[j] <= journey.expected(time * 1e-9):
                self.outside[j] += 1
                self._after[j] += self._interval(journey)
            if not self.outside[j]:
                continue
            near = self._near(j, position, 2.0 * radius.max(initial=0.0) + 1.0)
            occupied = np.vstack([robots, np.column_stack([position[near], radius[near]]), entered])
            while self.outside[j]:
                someone = self._first_in_line(j)
                place = self._room(j, float(someone.radius[0]), occupied)
                if place is None:
                    break
                self.outside[j] -= 1
                self._drawn[j] += 1
                row = np.array([[*place, someone.radius[0]]])
                entered, occupied = np.vstack([entered, row]), np.vstack([occupied, row])
                yield j, someone, place[None]

    def _comes(self, j: int) -> bool:
        return any(rate > 0 for _, rate in self._journeys[j].rates)

    def _draw(self, j: int) -> People:
        return draw_people(stream_of(self._setup, j, 1 + self._drawn[j] // BATCH), BATCH, self._populations)

    def _first_in_line(self, j: int) -> People:
        """The one person who waits longest for journey j."""
        k = self._drawn[j] % BATCH
        batch = self._batch[j]
        if batch is None or (k == 0 and self._drawn[j]):
            batch = self._batch[j] = self._draw(j)
        return select(batch, np.arange(k, k + 1))

    def _room(self, j: int, radius: float, occupied: Array) -> Array | None:
        """A free place (2,) in the start area of journey j, None if none was found [m]."""
        margin = np.where(self._period > 0, 0.0, radius)
        low, high = np.clip(self._bounds[j], margin, np.maximum(self._extent - margin, margin))
        candidates = low + self._rng.random((ATTEMPTS, 2)) * (high - low)
        candidates = np.where((self._period > 0) & (candidates >= self._period), 0.0, candidates)
        k = _first_free(candidates, radius, occupied, self._walls.within(radius), self._solid, self._period)
        return candidates[k] if k >= 0 else None

    def _near(self, j: int, position: Array, reach: float) -> NDArray[np.int64]:
        """Indices of the `position` (N, 2) that are within `reach` of the start area of journey j [m]."""
        low, high = self._bounds[j]
        half = 0.5 * (high - low)
        off = position - (low + half)
        off -= np.rint(off / np.where(self._period > 0, self._period, np.inf)) * self._period
        return np.flatnonzero((np.abs(off) <= half + reach).all(axis=1))

    def _interval(self, journey: Journey) -> float:
        return float(self._rng.standard_exponential()) if journey.arrivals == "poisson" else 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _first_free(candidates: Array, radius: float, occupied: Array, walls: WallGrid, solid: Array, period: Array) -> int:
    """Index of the first of the candidates (K, 2) where a disc touches nothing, -1 if none."""
    for k in range(len(candidates)):
        if is_free(candidates[k, 0], candidates[k, 1], radius, occupied, walls, solid, period):
            return k
    return -1
