"""Ultrasonic range finders: each tells the nearest thing in its cone, and nothing about its direction.

The cone is a level fan of rays, the outermost two along its sides, at the height of the mount; the reading is the
shortest of them. Ranges follow REP 117: infinite where nothing is within `range_max`, minus infinity where something is
nearer than `range_min`.
Not modelled: the cone's height, surfaces so oblique that no echo returns, and echoes of other range finders.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from components.sensors.imperfections import (
    Bias,
    Chain,
    Drift,
    Dropout,
    Gaussian,
    Quantisation,
    RangeDependent,
    Signal,
    Spikes,
)
from components.sensors.scan import Beams, Cylinders, Hits, People, Pose, Walls, near, nothing_hit, scan, tell
from components.sensors.surroundings import Surroundings, people_of, pose_of
from components.sensors.timing import Delivery, Latency, MessageLoss, RateJitter, require_rate
from crowdcosim.component import Sensor
from crowdcosim.messages import BeamAgents, Crowd, Header, Range, Ranges, RobotState
from crowdcosim.robots import Mount, RobotModel
from crowdcosim.setup import Setup, nanoseconds_of

_RAYS = 45
"""per cone: 0.3 degrees apart at 15 degrees, 35 mm at 4 m"""

Imperfection = Annotated[
    Gaussian | RangeDependent | Bias | Drift | Spikes | Quantisation | Dropout | Latency | RateJitter | MessageLoss,
    Field(discriminator="kind"),
]


@dataclass(frozen=True, kw_only=True)
class Ring:
    """Range finders around a robot, the first one ahead, on with the left."""

    count: int
    """spread evenly"""
    height: float
    """above the ground [m]"""
    radius: float | None = None
    """distance from the base's centre; null: the robot's radius [m]"""

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ValueError(f"count is {self.count}, expected at least 1")
        if not self.height >= 0.0:
            raise ValueError(f"height is {self.height}, expected zero or more")
        if self.radius is not None and not self.radius >= 0.0:
            raise ValueError(f"radius is {self.radius}, expected zero or more")

    def mounts(self, model: RobotModel) -> tuple[Mount, ...]:
        """Where each is on a robot."""
        radius = model.radius if self.radius is None else self.radius
        angles = [2.0 * math.pi * i / self.count for i in range(self.count)]
        return tuple(
            Mount(position=(radius * math.cos(angle), radius * math.sin(angle), self.height), yaw=angle)
            for angle in angles
        )


_TURTLEBOT2 = Ring(count=12, height=0.15)


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of an `Ultrasound`."""

    mounts: Ring | tuple[str | Mount, ...] = _TURTLEBOT2
    """a ring, or each range finder's mount by name or place; level"""
    field_of_view: float = math.radians(15.0)
    """full angle of the cone [rad]"""
    range_min: float = 0.02
    """nearest range that is measured [m]"""
    range_max: float = 4.0
    """farthest range that is measured [m]"""
    rate: float | None = None
    """readings per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[Imperfection, ...] = ()
    """what is wrong with the readings, in this order"""

    def __post_init__(self) -> None:
        if not 0.0 < self.field_of_view < math.pi:
            raise ValueError(f"field_of_view is {self.field_of_view}, expected more than 0 and less than pi")
        if not 0.0 <= self.range_min < self.range_max:
            raise ValueError(f"range_min is {self.range_min}, expected from 0 to below range_max ({self.range_max})")
        if not isinstance(self.mounts, Ring) and not self.mounts:
            raise ValueError("mounts is empty, expected at least one")
        require_rate(self)

    def frames(self, model: RobotModel) -> Mapping[str, Mount]:
        """Of each range finder, by its number.

        Raises:
            ValueError: if the robot has no such mount, or if they are not level or of several heights.
        """
        ring = self.mounts.mounts(model) if isinstance(self.mounts, Ring) else map(model.mount, self.mounts)
        mounts = {str(i): mount for i, mount in enumerate(ring)}
        if any(mount.pitch for mount in mounts.values()):
            raise ValueError("mounts have a pitch, expected 0: the cones are level")
        if len({mount.position[2] for mount in mounts.values()}) > 1:
            raise ValueError("mounts have several heights, expected one; use one sensor per height")
        return mounts


class UltrasoundOutput(NamedTuple):
    """One reading of all range finders, and the truth about who was nearest."""

    ranges: Ranges
    agents: BeamAgents


class Ultrasound(Sensor):
    """A ring, or any other set, of ultrasonic range finders."""

    def __init__(self, config: Config) -> None:
        self.config = config
        first, increment = -0.5 * config.field_of_view, config.field_of_view / (_RAYS - 1)
        angles = first + increment * np.arange(_RAYS)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        self._beams = Beams(first, increment, directions, config.range_max)

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        self._mounts = self.config.frames(setup.own_robot.model)
        self._around = Surroundings(setup, self._mounts["0"].position[2])
        self._begin()
        self.step(RobotState(), Crowd(), ())  # Compile now, not in the first step.
        self._begin()

    def _begin(self) -> None:
        config, setup = self.config, self._setup
        self._delivery = Delivery[UltrasoundOutput](config.imperfections, config.rate, setup)
        signal = Signal(instruments=len(self._mounts), period=self._delivery.period)
        self._chain = Chain(config.imperfections, signal, setup.seed)

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> UltrasoundOutput:
        time = nanoseconds_of(robot.header.stamp)
        return self._delivery.step(time, lambda: self._take(time, robot, crowd, others))

    def _take(self, time: int, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> UltrasoundOutput:
        around, config = self._around, self.config
        poses = np.array([pose_of(robot, mount) for mount in self._mounts.values()])
        nearest = _nearest(self._beams, poses, around.period, around.walls, people_of(crowd), around.robots(others))
        self._chain.apply(nearest.distance.reshape(-1, 1), time)
        tell(nearest, config.range_min, config.range_max)
        stamp, component = robot.header.stamp, self._setup.component
        ranges = tuple(
            Range(
                header=Header(stamp=stamp, frame_id=f"{component}/{name}"),
                radiation_type=Range.ULTRASOUND,
                field_of_view=config.field_of_view,
                min_range=config.range_min,
                max_range=config.range_max,
                range=r,
            )
            for name, r in zip(self._mounts, nearest.distance.tolist(), strict=True)
        )
        header = Header(stamp=stamp, frame_id=f"{robot.name}/base_link")
        return UltrasoundOutput(
            ranges=Ranges(header=header, ranges=ranges),
            agents=BeamAgents(header=header, kind=nearest.kind, agent=nearest.agent, body_part=nearest.body_part),
        )


@njit(cache=True, nogil=True)
def _nearest(
    beams: Beams,
    poses: NDArray[np.float64],
    period: NDArray[np.float64],
    walls: Walls,
    people: People,
    robots: Cylinders,
) -> Hits:
    """What each of R range finders at `poses`, (R, 5) as in `Pose`, has nearest among its `beams`."""
    count = len(poses)
    nearest = nothing_hit(count)
    x, y = poses[:, 0].mean(), poses[:, 1].mean()
    apart = np.sqrt(((poses[:, 0] - x) ** 2 + (poses[:, 1] - y) ** 2).max())
    people = near(people, x, y, beams.limit + apart, period)
    for i in range(count):
        pose = Pose(poses[i, 0], poses[i, 1], poses[i, 2], poses[i, 3], poses[i, 4])
        hits = scan(beams, pose, period, walls, people, robots)
        k = np.argmin(hits.distance)
        nearest.distance[i], nearest.kind[i] = hits.distance[k], hits.kind[k]
        nearest.agent[i], nearest.body_part[i] = hits.agent[k], hits.body_part[k]
    return nearest
