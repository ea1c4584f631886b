"""Where everybody was at which time: what pictures and films of a log are drawn from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from crowdcosim.cdr import decode
from crowdcosim.message import Message
from crowdcosim.messages import Crowd, RobotState
from crowdcosim.robots import Target
from crowdcosim.world import World
from orchestrator.errors import InputError
from orchestrator.log.reader import Log
from orchestrator.scenario.scenario import from_resolved

M = TypeVar("M", bound=Message)
Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RobotPath:
    """One robot over K instants."""

    name: str
    radius: float
    """[m]"""
    goal: Target
    time: Floats
    """(K,) [s]"""
    position: Floats
    """(K, 2) [m]"""
    heading: Floats
    """(K,) [rad]"""


@dataclass(frozen=True, kw_only=True)
class Trajectories:
    """A run, seen from above."""

    scenario: str
    description: str
    world: World
    time: Floats
    """(T,) instants of `crowd` [s]"""
    crowd: tuple[Crowd, ...]
    """the people at each"""
    robots: tuple[RobotPath, ...]

    def within(self, begin: float | None, end: float | None) -> Trajectories:
        """What happened from `begin` to `end` [s]; None: from the start, to the end.

        Raises:
            InputError: if that is nothing.
        """
        first = self.time[0] if begin is None else begin
        last = self.time[-1] if end is None else end
        chosen = np.flatnonzero((self.time >= first - 1e-9) & (self.time <= last + 1e-9))
        if not len(chosen):
            whole = f"{self.time[0]:g} to {self.time[-1]:g} s"
            raise InputError(f"there is nothing from {first:g} to {last:g} s: the run lasts from {whole}")
        robots = []
        for robot in self.robots:
            some = (robot.time >= first - 1e-9) & (robot.time <= last + 1e-9)
            robots.append(
                RobotPath(
                    name=robot.name,
                    radius=robot.radius,
                    goal=robot.goal,
                    time=robot.time[some],
                    position=robot.position[some],
                    heading=robot.heading[some],
                )
            )
        return Trajectories(
            scenario=self.scenario,
            description=self.description,
            world=self.world,
            time=self.time[chosen],
            crowd=tuple(self.crowd[k] for k in chosen),
            robots=tuple(robots),
        )

    def ways(self) -> Iterator[tuple[int, Floats, Floats]]:
        """Id, times (K,) and places (K, 2) of everybody, by id."""
        who = np.concatenate([crowd.id for crowd in self.crowd])
        place = np.concatenate([crowd.position for crowd in self.crowd])
        when = np.repeat(self.time, [len(crowd.id) for crowd in self.crowd])
        order = np.argsort(who, kind="stable")
        ids, first = np.unique(who[order], return_index=True)
        for number, part in zip(ids, np.split(order, first[1:]), strict=False):
            yield int(number), when[part], place[part]


def read_trajectories(log: Log) -> Trajectories:
    """The people and robots of a log, also of one that was cut off.

    Raises:
        InputError: if it is not the log of a run, or there is neither in it.
    """
    scenario = from_resolved(log.scenario())
    crowd = list(_messages(log, Crowd))
    states = list(_messages(log, RobotState))
    if not crowd and not states:
        raise InputError(f"{log.path} holds neither people nor robots")
    if not crowd:
        crowd = [(time, Crowd()) for time in sorted({time for time, _ in states})]
    robots = []
    for robot in scenario.robots:
        own = [(time, state) for time, state in states if state.name == robot.name]
        robots.append(
            RobotPath(
                name=robot.name,
                radius=robot.model.radius,
                goal=robot.goal,
                time=np.array([time for time, _ in own]),
                position=np.array([state.position for _, state in own]).reshape(-1, 2),
                heading=np.array([state.heading for _, state in own]),
            )
        )
    return Trajectories(
        scenario=scenario.name,
        description=scenario.description,
        world=scenario.world,
        time=np.array([time for time, _ in crowd]),
        crowd=tuple(people for _, people in crowd),
        robots=tuple(robots),
    )


def _messages(log: Log, kind: type[M]) -> Iterator[tuple[float, M]]:
    for record in log.records:
        if log.types[record.topic] == kind.TYPE:
            yield record.time / 1e9, decode(record.payload, kind.TYPE)
