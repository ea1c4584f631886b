"""Journeys: where people start, stop on the way, wait, arrive, and what they do then."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from components.crowd.areas import Area
from components.crowd.distributions import Distribution, bounds, draw
from components.crowd.floor_field import Ways
from crowdcosim.world import World

Array = NDArray[np.float64]

FOR_EVER = np.iinfo(np.int64).max
"""[ns]"""
ARRIVED = 0.5
"""[s]; people slow down so that they would need this long to their place in an area where they wait"""


@dataclass(frozen=True, kw_only=True)
class Stop:
    """An area on the way."""

    area: str
    """its name"""
    wait: Distribution = 0.0
    """how long people stay there, from when they enter it [s]"""

    def __post_init__(self) -> None:
        low, high = bounds(self.wait) if self.wait != () else (-1.0, -1.0)
        if isinstance(self.wait, tuple) or not (low >= 0 and math.isfinite(high)):
            raise ValueError(f"wait is {self.wait}, expected zero, a positive number, or how to draw one")


@dataclass(frozen=True, kw_only=True)
class Journey:
    """The way of some people through areas, and how many of them there are."""

    start: str
    """area in which they appear, at random places"""
    goal: str
    """area at which they arrive"""
    via: tuple[Stop, ...] = ()
    """areas that they enter before, in this order"""
    then: Literal["leave", "stay", "again"] = "leave"
    """at the goal they vanish, stand, or go back to the start and do it all again"""
    count: int = 0
    """people who are there at t = 0"""
    rate: float | tuple[tuple[float, float], ...] = 0.0
    """people who come per second; a list of [time, rate] sets it from each time on [s, 1/s]"""
    arrivals: Literal["poisson", "regular"] = "poisson"
    """they come at random times, or at equal intervals"""

    def __post_init__(self) -> None:
        if self.count < 0:
            raise ValueError(f"count is {self.count}, expected zero or more")
        times = [time for time, _ in self.rates]
        if times != sorted(set(times)) or min(times, default=0.0) < 0 or not all(math.isfinite(t) for t in times):
            raise ValueError(f"rate has the times {times}, expected numbers in ascending order, zero or more")
        for _, rate in self.rates:
            if not (rate >= 0 and math.isfinite(rate)):
                raise ValueError(f"rate is {rate}, expected zero or a positive number")
        if self.count == 0 and not any(rate > 0 for _, rate in self.rates):
            raise ValueError("count and rate are zero, expected one of them at least to be positive")

    @property
    def rates(self) -> tuple[tuple[float, float], ...]:
        """(time, rate) from each time on [s, 1/s]."""
        return self.rate if isinstance(self.rate, tuple) else ((0.0, self.rate),)

    def expected(self, time: float) -> float:
        """How many people come until `time` [s], on average."""
        ends = [*(begin for begin, _ in self.rates[1:]), math.inf]
        return sum(rate * max(min(end, time) - begin, 0.0) for (begin, rate), end in zip(self.rates, ends, strict=True))

    @property
    def stops(self) -> tuple[Stop, ...]:
        """Where they go in turn."""
        back = (Stop(area=self.start),) if self.then == "again" else ()
        return (*self.via, Stop(area=self.goal), *back)


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far N people are."""

    journey: NDArray[np.int64]
    """(N,) index of the journey"""
    stop: NDArray[np.int64]
    """(N,) index of the stop that they walk to, or wait at"""
    until: NDArray[np.int64]
    """(N,) when they go on; -1 while they walk [ns]"""
    place: Array
    """(N, 2) where in an area they like to stand, as shares of its extent"""


class Itineraries:
    """Where people on journeys want to go, from the areas of a world."""

    def __init__(self, journeys: Sequence[Journey], areas: Mapping[str, Area], world: World, radius: float) -> None:
        """Ways for bodies of up to `radius` [m].

        Raises:
            ValueError: if an area cannot be reached.
        """
        self._journeys = journeys
        self._period = world.period
        names = sorted({stop.area for journey in journeys for stop in journey.stops})
        self._bounds = np.array([areas[name].bounds for name in names]).reshape(-1, 2, 2)
        self._ways = Ways(world, self._bounds, radius)
        longest = max((len(journey.stops) for journey in journeys), default=0)
        self._area = np.zeros((len(journeys), longest), np.int64)
        self._count = np.array([len(journey.stops) for journey in journeys], np.int64)
        for j, journey in enumerate(journeys):
            last = journey.start
            for s, stop in enumerate(journey.stops):
                self._area[j, s] = names.index(stop.area)
                if not self._ways.reachable(areas[last].bounds, int(self._area[j, s])):
                    raise ValueError(
                        f"journeys[{j}]: there is no way from '{last}' to '{stop.area}' for people of radius "
                        f"{radius:g} m, expected a passage of more than {2 * radius:g} m; a cell of the search is "
                        f"{self._ways.cell:.2g} m wide"
                    )
                last = stop.area

    def begin(self, journey: NDArray[np.int64], rng: np.random.Generator) -> Progress:
        """The progress of people (N,) who have just appeared."""
        count = len(journey)
        return Progress(
            journey=journey,
            stop=np.zeros(count, np.int64),
            until=np.full(count, -1, np.int64),
            place=rng.random((count, 2)),
        )

    def preferred(self, progress: Progress, position: Array, speed: Array) -> Array:
        """(N, 2) velocities that people would walk at if they were alone; `speed` (N,) is their free one [m/s]."""
        area = self._area[progress.journey, progress.stop]
        wanted = speed[:, None] * self._ways.directions(position, area)
        waiting = np.flatnonzero(progress.until >= 0)
        if len(waiting):
            low, high = self._bounds[area[waiting], 0], self._bounds[area[waiting], 1]
            way = low + progress.place[waiting] * (high - low) - position[waiting]
            for axis in range(2):
                way[:, axis] -= (
                    np.rint(way[:, axis] / self._period[axis]) * self._period[axis] if self._period[axis] else 0
                )
            length = np.hypot(way[:, 0], way[:, 1])
            pace = np.minimum(speed[waiting], length / ARRIVED)
            wanted[waiting] = way / np.maximum(length, 1e-9)[:, None] * pace[:, None]
        return wanted

    def advance(
        self, progress: Progress, position: Array, time: int, rng: np.random.Generator
    ) -> tuple[Progress, NDArray[np.bool_]]:
        """The progress of people who are at `position` (N, 2) [m] at `time` [ns], and (N,) True for who leaves."""
        journey, stop, until = progress.journey, progress.stop.copy(), progress.until.copy()
        leaves = np.zeros(len(stop), np.bool_)
        left, bottom, right, top = self._bounds.reshape(-1, 4).T[:, self._area[journey, stop]]
        x, y = position.T
        inside = (left <= x) & (x <= right) & (bottom <= y) & (y <= top)
        changing = np.flatnonzero(np.where(until >= 0, until <= time, inside))
        # In the order of the list: who draws which waiting time depends on nothing else.
        for i in changing:
            j = self._journeys[journey[i]]
            if until[i] < 0 and stop[i] < len(j.via):
                wait = draw(j.via[stop[i]].wait, rng, 1, np.zeros(1, np.int64))[0]
                if wait > 0:
                    until[i] = time + round(wait * 1e9)
                    continue
            if stop[i] == len(j.via) and j.then == "stay":
                until[i] = FOR_EVER
            elif stop[i] == len(j.via) and j.then == "leave":
                leaves[i] = True
            else:
                stop[i], until[i] = (stop[i] + 1) % self._count[journey[i]], -1
        return Progress(journey=journey, stop=stop, until=until, place=progress.place), leaves
