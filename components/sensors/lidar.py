"""A planar laser scanner among walking people, other robots, who are upright cylinders, walls and obstacles.

It sees of a person what is at its own height: low down, two legs. Ranges follow REP 117: infinite where nothing is
within `range_max`, minus infinity where something is nearer than `range_min`. All beams are taken at the time of the
state. The robot that carries the scanner does not see itself.

Who a beam has hit is who is on its own line of sight, whatever the range that is told: a beam that is too near to
measure, has a spike or is mixed with its neighbour still says who is there. One that is dropped, or that errors carry
beyond `range_max`, says nobody.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from components.sensors.imperfections import (
    Chain,
    Signal,
)
from components.sensors.scan import Beams, Hits, scan, tell
from components.sensors.surroundings import Surroundings, people_of, pose_of
from components.sensors.timing import BeamKind, Delivery, require_rate
from crowdcosim.component import Sensor
from crowdcosim.messages import BeamAgents, Crowd, Header, LaserScan, RobotState
from crowdcosim.robots import Mount, RobotModel
from crowdcosim.setup import Setup, nanoseconds_of

# A full circle may be written as 6.283.
_ROUNDED = 1e-3
_DEFAULT_MOUNT = Mount(position=(0.0, 0.0, 0.3))


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of a `Lidar`."""

    mount: str | Mount = _DEFAULT_MOUNT
    """a mount of the robot's by name, or a place; level; the scanner looks over whoever is lower"""
    beams: int = 720
    """number of beams"""
    field_of_view: float = 2.0 * math.pi
    """angle from the first beam to the last, centred ahead; 2 pi: all around, no direction twice [rad]"""
    clockwise: bool = False
    """the first beam is the leftmost, as in a scanner that turns to the right"""
    range_min: float = 0.1
    """nearest range that is measured [m]"""
    range_max: float = 10.0
    """farthest range that is measured [m]"""
    no_hit: Literal["infinite", "range_max"] = "infinite"
    """what a beam tells that meets nothing; range_max is what the simulator of "Crowd against the machine" told"""
    rate: float | None = None
    """scans per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[BeamKind, ...] = ()
    """what is wrong with the scans, in this order"""

    def __post_init__(self) -> None:
        if self.beams < 2:
            raise ValueError(f"beams is {self.beams}, expected at least 2")
        if not 0.0 < self.field_of_view < 2.0 * math.pi + _ROUNDED:
            raise ValueError(f"field_of_view is {self.field_of_view}, expected more than 0 and at most 2 pi")
        if not 0.0 <= self.range_min < self.range_max:
            raise ValueError(f"range_min is {self.range_min}, expected from 0 to below range_max ({self.range_max})")
        if isinstance(self.mount, Mount) and self.mount.pitch:
            raise ValueError(f"mount has a pitch of {self.mount.pitch}, expected 0: the scan is level")
        require_rate(self)

    @property
    def all_around(self) -> bool:
        """True if the last beam is beside the first."""
        return self.field_of_view > 2.0 * math.pi - _ROUNDED

    @property
    def increment(self) -> float:
        """Angle from one beam to the next, negative if they go clockwise [rad]."""
        between = 2.0 * math.pi / self.beams if self.all_around else self.field_of_view / (self.beams - 1)
        return -between if self.clockwise else between

    @property
    def angle_min(self) -> float:
        """Angle of the first beam [rad]."""
        first = -math.pi if self.all_around else -0.5 * self.field_of_view
        return -first if self.clockwise else first

    @property
    def angle_max(self) -> float:
        """Angle of the last beam [rad]."""
        return self.angle_min + self.increment * (self.beams - 1)

    def frames(self, model: RobotModel) -> Mapping[str, Mount]:
        """The one frame of the scans, which is called as the sensor is.

        Raises:
            ValueError: if the robot has no such mount, or it is not level.
        """
        mount = model.mount(self.mount)
        if mount.pitch:
            raise ValueError(f"mount '{self.mount}' has a pitch of {mount.pitch}, expected 0: the scan is level")
        return {"": mount}


class LidarOutput(NamedTuple):
    """One scan, and the truth about who was seen."""

    scan: LaserScan
    agents: BeamAgents


class Lidar(Sensor):
    """A planar laser scanner, fixed to the robot."""

    def __init__(self, config: Config) -> None:
        self.config = config
        # The kernel counts beams counter-clockwise; a scan that goes clockwise is turned over at the end.
        first = min(config.angle_min, config.angle_max)
        angles = first + abs(config.increment) * np.arange(config.beams)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        self._beams = Beams(first, abs(config.increment), directions, config.range_max)

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        self._mount = self.config.frames(setup.own_robot.model)[""]
        self._around = Surroundings(setup, self._mount.position[2])
        self._begin()
        self.step(RobotState(), Crowd(), ())  # Compile now, not in the first step.
        self._begin()

    def _begin(self) -> None:
        config, setup = self.config, self._setup
        self._delivery = Delivery[LidarOutput](config.imperfections, config.rate, setup)
        signal = Signal(closed=config.all_around, period=self._delivery.period)
        self._chain = Chain(config.imperfections, signal, setup.seed)

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> LidarOutput:
        time = nanoseconds_of(robot.header.stamp)
        return self._delivery.step(time, lambda: self._take(time, robot, crowd, others))

    def _take(self, time: int, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> LidarOutput:
        config, around = self.config, self._around
        pose = pose_of(robot, self._mount)
        hits = scan(self._beams, pose, around.period, around.walls, people_of(crowd), around.robots(others))
        if config.clockwise:
            hits = Hits(*(np.ascontiguousarray(field[::-1]) for field in hits))
        self._chain.apply(hits.distance.reshape(1, -1), time)
        tell(hits, config.range_min, config.range_max)
        if config.no_hit == "range_max":
            hits.distance[hits.distance == np.inf] = config.range_max
        header = Header(stamp=robot.header.stamp, frame_id=self._setup.component)
        return LidarOutput(
            scan=LaserScan(
                header=header,
                angle_min=config.angle_min,
                angle_max=config.angle_max,
                angle_increment=config.increment,
                scan_time=self._delivery.period,
                range_min=config.range_min,
                range_max=config.range_max,
                ranges=hits.distance.astype(np.float32),
            ),
            agents=BeamAgents(header=header, kind=hits.kind, agent=hits.agent, body_part=hits.body_part),
        )
