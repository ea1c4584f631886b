"""A people tracker: whom it sees, roughly where, and under which number it follows them.

A person can be detected within `range_max` and the field of view, if a level scanner at the mount would see at least
the share `least_visible` of them past others, robots and walls (`components.sensors.visibility`); each reading misses
them with probability `miss`. Positions and velocities have errors of which each coordinate e is, at the distance d,
    e ~ N(0, (deviation + deviation_per_metre d)^2),     correlation over a time t: exp(-t / correlation_time)
(Gauss-Markov, so that their statistics do not depend on the rate). False alarms: a number ~ Poisson(false_alarms) per
reading, uniform over the area of the field of view, standing still, each with a track of its own that ends at once.
A person keeps a track as long as they are detected again within `memory`; after that they get a new number.
Not modelled: tracks that change places, people who merge, false alarms that last, and doubt about how many there are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from components.sensors.scan import Beams
from components.sensors.surroundings import Surroundings, people_of, pose_of
from components.sensors.timing import Delivery, TimingKind, require_rate
from components.sensors.visibility import visibility
from crowdcosim.component import Sensor
from crowdcosim.messages import Crowd, Detections, Header, RobotState
from crowdcosim.robots import Mount, RobotModel
from crowdcosim.setup import Setup, nanoseconds_of

_BEAMS_PER_RADIAN = 720 / (2.0 * math.pi)
"""of the scan that decides who is seen: half a degree apart"""
_RADIUS = 0.3
"""of somebody who is not there [m]"""
_DEFAULT_MOUNT = Mount(position=(0.0, 0.0, 0.3))


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of a `PeopleTracker`; all left out: everybody in sight, exactly."""

    mount: str | Mount = _DEFAULT_MOUNT
    """a mount of the robot's by name, or a place; level; from here people are seen or hidden"""
    field_of_view: float = 2.0 * math.pi
    """angle centred ahead; 2 pi: all around [rad]"""
    range_max: float = 10.0
    """farthest person that is detected [m]"""
    least_visible: float = 0.3
    """share of a person's width, at the height of the mount, that must be seen"""
    miss: float = 0.0
    """probability that somebody in sight is not detected, per reading"""
    false_alarms: float = 0.0
    """mean number of people detected who are not there, per reading"""
    position_deviation: float = 0.0
    """standard deviation of each coordinate of a position, nearby [m]"""
    position_deviation_per_metre: float = 0.0
    """growth of that with the distance [m/m]"""
    velocity_deviation: float = 0.0
    """standard deviation of each coordinate of a velocity, nearby [m/s]"""
    velocity_deviation_per_metre: float = 0.0
    """growth of that with the distance [(m/s)/m]"""
    correlation_time: float = 0.0
    """after which errors are forgotten; 0: each reading has its own [s]"""
    memory: float = 1.0
    """longest time that somebody may be undetected and keep their track [s]"""
    rate: float | None = None
    """readings per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[TimingKind, ...] = ()
    """what is wrong with the messages' timing"""

    def __post_init__(self) -> None:
        if not 0.0 < self.field_of_view < 2.0 * math.pi + 1e-3:
            raise ValueError(f"field_of_view is {self.field_of_view}, expected more than 0 and at most 2 pi")
        if not self.range_max > 0.0:
            raise ValueError(f"range_max is {self.range_max}, expected a positive number")
        for name in ("least_visible", "miss"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected from 0 to 1")
        for name in (
            "false_alarms",
            "position_deviation",
            "position_deviation_per_metre",
            "velocity_deviation",
            "velocity_deviation_per_metre",
            "correlation_time",
            "memory",
        ):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected zero or more")
        require_rate(self)

    def frames(self, model: RobotModel) -> Mapping[str, Mount]:
        """The frame of the scanner, which is called as the sensor is; detections are in the robot's own.

        Raises:
            ValueError: if the robot has no such mount, or it is not level.
        """
        mount = model.mount(self.mount)
        if mount.pitch:
            raise ValueError(f"mount has a pitch of {mount.pitch}, expected 0: the scan is level")
        return {"": mount}


@dataclass(kw_only=True)
class _Track:
    """What is remembered of one person."""

    number: int
    detected: int
    """when last [ns]"""
    errors: NDArray[np.float64]
    """(4,) of position and velocity, in standard deviations"""


class PeopleTracker(Sensor):
    """Detects people and follows them."""

    def __init__(self, config: Config) -> None:
        self.config = config
        count = max(round(_BEAMS_PER_RADIAN * config.field_of_view), 2)
        increment = config.field_of_view / count
        first = -0.5 * config.field_of_view + 0.5 * increment
        angles = first + increment * np.arange(count)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        self._beams = Beams(first, increment, directions, config.range_max)

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        self._mount = self.config.frames(setup.own_robot.model)[""]
        self._around = Surroundings(setup, self._mount.position[2])
        self._begin()
        self.step(RobotState(), Crowd(), ())  # Compile now, not in the first step.
        self._begin()

    def _begin(self) -> None:
        self._delivery = Delivery[Detections](self.config.imperfections, self.config.rate, self._setup)
        self._rng = self._setup.rng()
        self._tracks: dict[int, _Track] = {}
        self._numbers = 0

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> Detections:
        time = nanoseconds_of(robot.header.stamp)
        return self._delivery.step(time, lambda: self._take(time, robot, crowd, others))

    def _take(self, time: int, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> Detections:
        config = self.config
        found = self._found(robot, crowd, others)
        tracks = [self._follow(time, number) for number in crowd.id[found].tolist()]
        to_robot = _rotation(-robot.heading)
        position = self._setup.world.displacement(robot.position, crowd.position[found]) @ to_robot.T
        velocity = crowd.velocity[found] @ to_robot.T
        distance = np.linalg.norm(position, axis=1)
        errors = np.array([track.errors for track in tracks]).reshape(-1, 4)
        position_deviation = config.position_deviation + config.position_deviation_per_metre * distance
        velocity_deviation = config.velocity_deviation + config.velocity_deviation_per_metre * distance
        false = self._false_alarms()
        away = np.linalg.norm(false, axis=1)
        radius = crowd.radius[found]
        return Detections(
            header=Header(stamp=robot.header.stamp, frame_id=f"{robot.name}/base_link"),
            track=[*(track.number for track in tracks), *(self._new_number() for _ in false)],
            position=np.concatenate([position + position_deviation[:, None] * errors[:, :2], false]),
            velocity=np.concatenate([velocity + velocity_deviation[:, None] * errors[:, 2:], np.zeros_like(false)]),
            radius=np.concatenate([radius, np.full(len(false), _RADIUS)]),
            position_deviation=np.concatenate(
                [position_deviation, config.position_deviation + config.position_deviation_per_metre * away]
            ),
            velocity_deviation=np.concatenate(
                [velocity_deviation, config.velocity_deviation + config.velocity_deviation_per_metre * away]
            ),
        )

    def _found(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> NDArray[np.intp]:
        """Who is detected now, in the crowd's order."""
        around, config = self._around, self.config
        pose = pose_of(robot, self._mount)
        seen = visibility(self._beams, pose, around.period, around.walls, people_of(crowd), around.robots(others))
        in_sight = (seen.share > 0.0) & (seen.share >= config.least_visible) & (seen.distance <= config.range_max)
        candidates = np.flatnonzero(in_sight)
        return candidates[self._rng.random(len(candidates)) >= config.miss]

    def _follow(self, time: int, person: int) -> _Track:
        """The track of somebody who is detected now, with errors of now."""
        track = self._tracks.get(person)
        if track is None or time - track.detected > self.config.memory * 1e9:
            track = _Track(number=self._new_number(), detected=time, errors=self._rng.standard_normal(4))
            self._tracks[person] = track
        elif self.config.correlation_time > 0.0:
            kept = math.exp(-(time - track.detected) * 1e-9 / self.config.correlation_time)
            track.errors = kept * track.errors + math.sqrt(1.0 - kept * kept) * self._rng.standard_normal(4)
        else:
            track.errors = self._rng.standard_normal(4)
        track.detected = time
        return track

    def _new_number(self) -> int:
        self._numbers += 1
        return self._numbers

    def _false_alarms(self) -> NDArray[np.float64]:
        """(F, 2) places where nobody is, seen from the robot [m]."""
        count = self._rng.poisson(self.config.false_alarms)
        away = self.config.range_max * np.sqrt(self._rng.random(count))
        angle = self._mount.yaw + self.config.field_of_view * (self._rng.random(count) - 0.5)
        return np.column_stack([away * np.cos(angle), away * np.sin(angle)]) + self._mount.position[:2]


def _rotation(angle: float) -> NDArray[np.float64]:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])
