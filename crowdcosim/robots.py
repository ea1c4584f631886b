"""What a robot model is, and one robot of a scenario."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Field


@dataclass(frozen=True, kw_only=True)
class Mount:
    """A place on a robot's body where a sensor can sit, in the frame of its base (x ahead, y left, z up: REP 103)."""

    position: tuple[float, float, float]
    """ahead and to the left of the base's centre, and above the ground [m]"""
    yaw: float = 0.0
    """direction that the sensor faces, counter-clockwise from ahead [rad]"""
    pitch: float = 0.0
    """then about the sensor's own left: positive looks down [rad]"""

    def __post_init__(self) -> None:
        if not self.position[2] >= 0.0:
            raise ValueError(f"position is {self.position}, expected a height, the third number, of zero or more")
        if not abs(self.pitch) <= 0.5 * math.pi:
            raise ValueError(f"pitch is {self.pitch}, expected from -pi/2 (straight up) to pi/2 (straight down)")


@dataclass(frozen=True, kw_only=True)
class Differential:
    """A base that turns by driving its two wheels at different speeds, and cannot move sideways."""

    kind: Literal["differential"] = "differential"
    """two driven wheels on one axis through the base's centre"""
    wheel_radius: float | None = None
    """of the driven wheels; needed by drives that turn them [m]"""
    track: float | None = None
    """distance between the two wheels; needed by drives that turn them [m]"""

    def __post_init__(self) -> None:
        for name in ("wheel_radius", "track"):
            _check_positive(self, name)


@dataclass(frozen=True, kw_only=True)
class Holonomic:
    """A base that moves in any direction, and turns meanwhile."""

    kind: Literal["holonomic"] = "holonomic"
    """omnidirectional wheels"""
    max_lateral_speed: float
    """limit of the speed to the left and to the right [m/s]"""

    def __post_init__(self) -> None:
        _check_positive(self, "max_lateral_speed")


@dataclass(frozen=True, kw_only=True)
class Car:
    """A base with steered front wheels, which turns only while it drives; its centre is midway between the axles."""

    kind: Literal["car"] = "car"
    """driven wheels behind, steered wheels in front"""
    wheelbase: float
    """distance from the rear axle to the front axle [m]"""
    max_steering_angle: float
    """of the middle of the front axle, either way [rad]"""
    max_steering_rate: float
    """limit of the steering angle's change [rad/s]"""

    def __post_init__(self) -> None:
        for name in ("wheelbase", "max_steering_rate"):
            _check_positive(self, name)
        if not 0.0 < self.max_steering_angle < 0.5 * math.pi:
            raise ValueError(
                f"max_steering_angle is {self.max_steering_angle}, expected more than 0 and less than pi/2"
            )


Base = Annotated[Differential | Holonomic | Car, Field(discriminator="kind")]
"""How a robot's wheels let it move."""


def _check_positive(part: object, name: str) -> None:
    value = getattr(part, name)
    if value is not None and not value > 0.0:
        raise ValueError(f"{name} is {value}, expected a positive number")


@dataclass(frozen=True, kw_only=True)
class RobotModel:
    """A robot's body and limits. The files are data: `scenarios/robots/*.yaml`."""

    radius: float
    """radius of the base's disc [m]"""
    height: float
    """height of the body [m]"""
    mass: float
    """mass that counts in a collision [kg]"""
    max_speed: float
    """forward speed limit [m/s]"""
    min_speed: float = 0.0
    """backward speed limit, zero or negative [m/s]"""
    max_acceleration: float
    """limit of the forward acceleration, also when braking [m/s2]"""
    max_angular_velocity: float
    """turn rate limit, either way [rad/s]"""
    max_angular_acceleration: float
    """limit of the turn rate's change [rad/s2]"""
    base: Base = Differential()
    """how its wheels let it move: differential, holonomic or car"""
    mounts: Mapping[str, Mount] = field(default_factory=dict)
    """name -> where a sensor of that mount sits"""

    def __post_init__(self) -> None:
        for name in ("radius", "height", "mass", "max_speed", "max_acceleration"):
            _check_positive(self, name)
        for name in ("max_angular_velocity", "max_angular_acceleration"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected zero or more")
        if not self.min_speed <= 0:
            raise ValueError(f"min_speed is {self.min_speed}, expected zero or a negative number")

    def mount(self, where: str | Mount) -> Mount:
        """The mount of that name, or the place itself.

        Raises:
            ValueError: if there is no mount of that name.
        """
        if isinstance(where, Mount):
            return where
        if where not in self.mounts:
            names = ", ".join(self.mounts) or "none"
            raise ValueError(f"mount is '{where}', expected one of the robot's ({names}) or {{position: [x, y, z]}}")
        return self.mounts[where]


@dataclass(frozen=True, kw_only=True)
class Pose:
    """A place on the plane and a direction, in the frame `map`."""

    x: float
    """along the world's first axis [m]"""
    y: float
    """along its second axis, to the left of x [m]"""
    heading: float = 0.0
    """counter-clockwise from x [rad]"""


@dataclass(frozen=True, kw_only=True)
class Target:
    """What a robot is asked to reach; becomes the message `Goal`."""

    x: float
    """of the point aimed at [m]"""
    y: float
    """of the point aimed at [m]"""
    direction: tuple[float, float] = (0.0, 0.0)
    """unit vector: done when the line through the point, normal to this, is crossed; (0, 0): done within `tolerance`"""
    tolerance: float = 0.3
    """radius of the disc to enter, when there is no direction [m]"""


@dataclass(frozen=True, kw_only=True)
class Robot:
    """One robot of a scenario."""

    name: str
    """in the scenario"""
    number: int
    """from 1, in the scenario's order; the robot's number in `Contacts` and `BeamAgents`"""
    model: RobotModel
    """body and limits"""
    start: Pose
    """where it stands at t = 0"""
    goal: Target
    """what it is asked to reach"""
