"""A planar laser scanner among walking people, other robots, who are upright cylinders, and walls.

It sees of a person what is at its own height: low down, two legs. Ranges follow REP 117: infinite where nothing is
within `range_max`, minus infinity where something is nearer than `range_min`. A beam that is too near to measure still
says who is there; one that noise carries beyond `range_max` says nobody. All beams are taken at the time of the state.
Noise is drawn anew for every scan, from the seed and the time. The robot that carries the scanner does not see itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from components.sensors.scan import Beams, Cylinders, People, Pose, Walls, scan
from crowdcosim.component import Sensor
from crowdcosim.messages import BeamAgents, Crowd, Header, LaserScan, RobotState
from crowdcosim.setup import Setup, nanoseconds_of

# A full circle may be written as 6.283.
_ROUNDED = 1e-3


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of a `Lidar`."""

    beams: int = 720
    """number of beams"""
    field_of_view: float = 2.0 * math.pi
    """angle from the first beam to the last, centred ahead; 2 pi: all around, no direction twice [rad]"""
    range_min: float = 0.1
    """nearest range that is measured [m]"""
    range_max: float = 10.0
    """farthest range that is measured [m]"""
    position: tuple[float, float, float] = (0.0, 0.0, 0.3)
    """mount: ahead and to the left of the base's centre, and above the ground; it looks over whoever is lower [m]"""
    yaw: float = 0.0
    """direction of the scanner, counter-clockwise from the robot's [rad]"""
    noise: float = 0.0
    """standard deviation of the ranges [m]"""

    def __post_init__(self) -> None:
        if self.beams < 2:
            raise ValueError(f"beams is {self.beams}, expected at least 2")
        if not 0.0 < self.field_of_view < 2.0 * math.pi + _ROUNDED:
            raise ValueError(f"field_of_view is {self.field_of_view}, expected more than 0 and at most 2 pi")
        if not 0.0 <= self.range_min < self.range_max:
            raise ValueError(f"range_min is {self.range_min}, expected from 0 to below range_max ({self.range_max})")
        if not self.position[2] >= 0.0:
            raise ValueError(f"position is {self.position}, expected a height, the third number, of zero or more")
        if not self.noise >= 0.0:
            raise ValueError(f"noise is {self.noise}, expected zero or more")

    @property
    def increment(self) -> float:
        """Angle from one beam to the next [rad]."""
        if self.field_of_view > 2.0 * math.pi - _ROUNDED:
            return 2.0 * math.pi / self.beams
        return self.field_of_view / (self.beams - 1)

    @property
    def angle_min(self) -> float:
        """Angle of the first beam [rad]."""
        return -math.pi if self.field_of_view > 2.0 * math.pi - _ROUNDED else -0.5 * self.field_of_view


class LidarOutput(NamedTuple):
    """One scan, and the truth about who was seen."""

    scan: LaserScan
    agents: BeamAgents


class Lidar(Sensor):
    """A planar laser scanner, fixed to the robot."""

    def __init__(self, config: Config) -> None:
        self.config = config
        angles = config.angle_min + config.increment * np.arange(config.beams)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        self._beams = Beams(config.angle_min, config.increment, directions, config.range_max)

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        seen = setup.world.segment_heights >= self.config.position[2]
        self._walls = Walls(setup.world.segment_numbers[seen], setup.world.segments[seen])
        self._period = setup.world.period
        self._height_of = {robot.name: robot.model.height for robot in setup.robots}
        self._number_of = {robot.name: robot.number for robot in setup.robots}
        self.step(RobotState(), Crowd(), ())  # Compile now, not in the first step.

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> LidarOutput:
        config = self.config
        people = People(crowd.id, crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)
        distance, kind, agent, body_part = scan(
            self._beams, self._pose(robot), self._period, self._walls, people, self._cylinders(others)
        )
        if config.noise > 0.0:
            nanoseconds = nanoseconds_of(robot.header.stamp)
            distance += config.noise * self._setup.rng(nanoseconds).standard_normal(config.beams)
            lost = distance > config.range_max
            distance[lost], kind[lost], agent[lost] = np.inf, BeamAgents.NOTHING, 0
            body_part[lost] = BeamAgents.NO_PART
        distance[distance < config.range_min] = -np.inf
        header = Header(stamp=robot.header.stamp, frame_id=self._setup.component)
        return LidarOutput(
            scan=LaserScan(
                header=header,
                angle_min=config.angle_min,
                angle_max=config.angle_min + config.increment * (config.beams - 1),
                angle_increment=config.increment,
                scan_time=self._setup.dt,
                range_min=config.range_min,
                range_max=config.range_max,
                ranges=_read_only(distance.astype(np.float32)),
            ),
            agents=BeamAgents(
                header=header, kind=_read_only(kind), agent=_read_only(agent), body_part=_read_only(body_part)
            ),
        )

    def _pose(self, robot: RobotState) -> Pose:
        ahead, left, up = self.config.position
        cos, sin = math.cos(robot.heading), math.sin(robot.heading)
        x, y = robot.position.tolist()
        heading = robot.heading + self.config.yaw
        return Pose(
            x + cos * ahead - sin * left, y + sin * ahead + cos * left, up, math.cos(heading), math.sin(heading)
        )

    def _cylinders(self, robots: tuple[RobotState, ...]) -> Cylinders:
        """The robots as the kernel takes them: arrays that are read-only, as those of a message are."""
        return Cylinders(
            _read_only(np.array([self._number_of[robot.name] for robot in robots], np.uint32)),
            _read_only(np.array([robot.position for robot in robots], np.float64).reshape(-1, 2)),
            _read_only(np.array([robot.radius for robot in robots], np.float64)),
            _read_only(np.array([self._height_of[robot.name] for robot in robots], np.float64)),
        )


def _read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array
