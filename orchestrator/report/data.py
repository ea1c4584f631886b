"""What the report of an episode shows, as plain arrays, and how it is read from a log."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from crowdcosim.cdr import decode
from crowdcosim.goal import reached
from crowdcosim.message import Message
from crowdcosim.messages import Contacts, Crowd, Goal, Metrics, RobotState
from crowdcosim.robots import Robot, Target
from crowdcosim.world import World
from orchestrator.episode import Metric, rows_of
from orchestrator.log.reader import Log
from orchestrator.scenario.scenario import Scenario, from_resolved

Floats = NDArray[np.float64]
M = TypeVar("M", bound=Message)
Timed: TypeAlias = list[tuple[float, M]]
"""(time [s], message) in the order of time"""

SNAPSHOTS = 4
"""Instants at which the report shows the people, evenly spread from start to end."""


@dataclass(frozen=True, kw_only=True)
class Touch:
    """One contact of a robot, from its first step to its last."""

    kind: int
    """`Contacts.WALL`, `PERSON` or `ROBOT`"""
    agent: int
    """a person's id, a robot's or a wall's number"""
    body_part: int
    """`Contacts.FEET` and so on, `NO_PART` if it is not a person"""
    begin: float
    """start of the first step in contact [s]"""
    end: float
    """end of the last one [s]"""
    position: tuple[float, float]
    """where it began [m]"""
    approach_speed: float
    """[m/s]"""
    energy: float
    """[J]"""


@dataclass(frozen=True, kw_only=True)
class RobotTrack:
    """One robot over the episode's K states."""

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
    speed: Floats
    """(K,) forward, negative when driving backward [m/s]"""
    angular_velocity: Floats
    """(K,) [rad/s]"""
    nearest: Floats
    """(K,) distance to the nearest person, centre to centre, infinite where there is nobody [m]"""
    touches: tuple[Touch, ...] = ()
    """in the order in which they began"""
    arrival: float | None = None
    """when it had reached its goal [s]"""


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """The N people at one instant."""

    time: float
    """[s]"""
    position: Floats
    """(N, 2) [m]"""
    heading: Floats
    """(N,) [rad]"""
    radius: Floats
    """(N,) [m]"""


@dataclass(frozen=True, kw_only=True)
class EpisodeData:
    """All that the report shows."""

    scenario: str
    description: str
    seed: str
    outcome: str
    """in words"""
    data_hash: str
    complete: bool
    """False: the log was cut off"""
    versions: Mapping[str, str]
    """what ran: packages, Python, platform, commit"""
    world: World
    duration: float
    """simulated time [s]"""
    robots: tuple[RobotTrack, ...]
    snapshots: tuple[Snapshot, ...]
    """people, in the order of time"""
    metrics: tuple[Metric, ...]


def read_episode(log: Log) -> EpisodeData:
    """What the report shows of a log, also of one that was cut off.

    Raises:
        InputError: if the log is not that of a run.
    """
    scenario = from_resolved(log.scenario())
    crowd = list(_messages(log, Crowd))
    states = list(_messages(log, RobotState))
    reports = list(_messages(log, Contacts))
    verdicts = [message for _, message in _messages(log, Metrics)]
    run, outcome = dict(log.metadata.get("run", {})), log.metadata.get("outcome", {})
    for known in ("scenario", "seed"):
        run.pop(known, None)
    return EpisodeData(
        scenario=scenario.name,
        description=scenario.description,
        seed=str(scenario.seed),
        outcome=_outcome(outcome),
        data_hash=outcome.get("data_hash") or log.data_hash(),
        complete=log.complete,
        versions=run,
        world=scenario.world,
        duration=max((time for time, _ in states), default=0.0),
        robots=tuple(
            _track(
                robot,
                states=[(time, state) for time, state in states if state.name == robot.name],
                reports=[(time, report) for time, report in reports if report.robot == robot.name],
                crowd=crowd,
                scenario=scenario,
            )
            for robot in scenario.robots
        ),
        snapshots=_snapshots(crowd),
        metrics=rows_of(verdicts[-1]) if verdicts else (),
    )


def _messages(log: Log, kind: type[M]) -> Iterator[tuple[float, M]]:
    """(time [s], message) of all messages of one type."""
    for record in log.records:
        if log.types[record.topic] == kind.TYPE:
            yield record.time / 1e9, decode(record.payload, kind.TYPE)


def _outcome(outcome: Mapping[str, str]) -> str:
    words = {
        "goal": "reached the goal",
        "time_limit": "hit the time limit",
        "collision": "ended by a collision",
        "stopped": "stopped by who ran it",
        "failed": "failed",
    }
    reason = outcome.get("reason", "")
    error = f": {outcome['error']}" if "error" in outcome else ""
    return words.get(reason, reason or "cut off") + error


def _track(
    robot: Robot,
    *,
    states: Timed[RobotState],
    reports: Timed[Contacts],
    crowd: Timed[Crowd],
    scenario: Scenario,
) -> RobotTrack:
    position = np.array([s.position for _, s in states]).reshape(-1, 2)
    velocity = np.array([s.velocity for _, s in states]).reshape(-1, 2)
    heading = np.array([s.heading for _, s in states])
    return RobotTrack(
        name=robot.name,
        radius=robot.model.radius,
        goal=robot.goal,
        time=np.array([time for time, _ in states]),
        position=position,
        heading=heading,
        speed=velocity[:, 0] * np.cos(heading) + velocity[:, 1] * np.sin(heading),
        angular_velocity=np.array([s.angular_velocity for _, s in states]),
        nearest=_nearest(states, crowd, scenario.world),
        touches=touches(reports, scenario.period * 1e-9),
        arrival=_arrival(robot, states),
    )


def _nearest(states: Timed[RobotState], crowd: Timed[Crowd], world: World) -> Floats:
    """(K,) distance from each state to the nearest person of the crowd of that time, or the last one before it [m]."""
    times = [time for time, _ in crowd]
    nearest = np.full(len(states), np.inf)
    for k, (time, state) in enumerate(states):
        i = bisect_right(times, time) - 1
        if i >= 0 and len(crowd[i][1].id):
            d = world.displacement(state.position, crowd[i][1].position)
            nearest[k] = np.hypot(d[:, 0], d[:, 1]).min()
    return nearest


def touches(reports: Timed[Contacts], dt: float) -> tuple[Touch, ...]:
    """The contacts that a robot's reports tell of; `dt` is the length of the step that each report ends [s]."""
    found: list[Touch] = []
    latest: dict[tuple[int, int], int] = {}
    for time, report in reports:
        for i in range(len(report.kind)):
            key = (int(report.kind[i]), int(report.agent[i]))
            if report.duration[i] > 0 and key in latest:
                found[latest[key]] = replace(found[latest[key]], end=time)
                continue
            latest[key] = len(found)
            found.append(
                Touch(
                    kind=key[0],
                    agent=key[1],
                    body_part=int(report.body_part[i]),
                    begin=time - dt,
                    end=time,
                    position=(float(report.position[i, 0]), float(report.position[i, 1])),
                    approach_speed=float(report.approach_speed[i]),
                    energy=float(report.energy[i]),
                )
            )
    return tuple(found)


def _arrival(robot: Robot, states: Timed[RobotState]) -> float | None:
    goal = Goal(
        robot=robot.name,
        position=np.array([robot.goal.x, robot.goal.y]),
        direction=np.array(robot.goal.direction),
        tolerance=robot.goal.tolerance,
    )
    return next((time for time, state in states if reached(goal, state.position)), None)


def _snapshots(crowd: Timed[Crowd]) -> tuple[Snapshot, ...]:
    if not crowd:
        return ()
    chosen = np.unique(np.linspace(0, len(crowd) - 1, SNAPSHOTS).round().astype(int))
    return tuple(
        Snapshot(time=time, position=people.position, heading=people.heading, radius=people.radius)
        for time, people in (crowd[i] for i in chosen.tolist())
    )
