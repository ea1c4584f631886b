"""How a base moves: the motion that a command leads to within the robot's limits, and what an obstacle leaves of it.

Rates of motion change linearly within a step of length h, so that way and turn are those of the mean rates; at a
constant turn rate the path is an arc, whose chord is distance * sin(turn / 2) / (turn / 2). Limits are physics, not
errors: a command beyond them is followed as far as they allow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from crowdcosim.messages import Twist
from crowdcosim.robots import RobotModel

ALONG = 1e-6
"""sine of the angle between the way and a surface from which on a robot drives at it, and not along it"""


class Motion(NamedTuple):
    """What a drive would do in one step if nothing were in its way, and its rates at the end."""

    dx: float
    """displacement along the map's x [m]"""
    dy: float
    """displacement along the map's y [m]"""
    turn: float
    """change of heading [rad]"""
    speed: float
    """ahead [m/s]"""
    lateral_speed: float
    """to the left [m/s]"""
    turn_rate: float
    """counter-clockwise [rad/s]"""
    steering: float = 0.0
    """angle of the front wheels, where there are such [rad]"""


class Bound(NamedTuple):
    """An obstacle as a plane: how far the robot may go towards it in one step."""

    nx: float
    """unit vector towards the obstacle"""
    ny: float
    most: float
    """along that vector, zero or more [m]"""
    share: float
    """of the planned motion after which the two meet, above 1 if they do not"""


@dataclass(slots=True, kw_only=True)
class Drive:
    """Pose and rates of a base; subclasses know how its wheels let it move."""

    model: RobotModel
    x: float
    """[m]"""
    y: float
    """[m]"""
    heading: float
    """counter-clockwise from the map's x [rad]"""
    speed: float = 0.0
    """ahead [m/s]"""
    lateral_speed: float = 0.0
    """to the left [m/s]"""
    turn_rate: float = 0.0
    """counter-clockwise [rad/s]"""
    steering: float = 0.0
    """angle of the front wheels, where they steer, counter-clockwise [rad]"""

    @property
    def velocity(self) -> tuple[float, float]:
        """Of the centre, in the map [m/s]."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return self.speed * cos - self.lateral_speed * sin, self.speed * sin + self.lateral_speed * cos

    @property
    def top_speed(self) -> float:
        """What the centre cannot exceed [m/s]."""
        return max(self.model.max_speed, -self.model.min_speed)

    def plan(self, command: Twist, h: float) -> Motion:
        """The motion of the next `h` [s] towards `command`, in the robot's frame."""
        raise NotImplementedError

    def stops_after(self, motion: Motion, bounds: Sequence[Bound]) -> float:
        """The share of `motion` after which `bounds` stop the base, 1 if they do not."""
        return free_share(motion, bounds)

    def left_of(self, motion: Motion, bounds: Sequence[Bound], h: float) -> Motion:
        """What is left of `motion`, which takes `h` [s], within `bounds`: the base is stopped, or deflected."""
        raise NotImplementedError

    def move(self, motion: Motion) -> None:
        """Carry out `motion`."""
        self.x += motion.dx
        self.y += motion.dy
        self.heading = math.remainder(self.heading + motion.turn, 2.0 * math.pi)
        self.speed = motion.speed
        self.lateral_speed = motion.lateral_speed
        self.turn_rate = motion.turn_rate
        self.steering = motion.steering


def free_share(motion: Motion, bounds: Sequence[Bound]) -> float:
    """How much of a motion that keeps its direction is free, 1 if nothing is met."""
    return min((b.share for b in bounds if drives_at(motion, b)), default=1.0)


def drives_at(motion: Motion, bound: Bound) -> bool:
    """True if a motion leads at an obstacle, and not along it or away."""
    return bound.nx * motion.dx + bound.ny * motion.dy > ALONG * math.hypot(motion.dx, motion.dy)


def chord(heading: float, distance: float, turn: float) -> tuple[float, float]:
    """Displacement (x, y) [m] along an arc of `distance` [m] that starts at `heading` and turns by `turn` [rad]."""
    half = 0.5 * turn
    length = distance * (math.sin(half) / half) if half else distance
    return length * math.cos(heading + half), length * math.sin(heading + half)


def limited(value: float, least: float, most: float) -> float:
    """The value between two limits that is nearest to `value`."""
    return min(max(value, least), most)


def towards(value: float, wanted: float, most: float) -> float:
    """`wanted`, or as near to it as a change of at most `most` allows."""
    return min(max(wanted, value - most), value + most)
