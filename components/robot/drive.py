"""A differential drive: speed and turn rate follow a command within the robot's limits, and the base moves on arcs.

Within a step of length h both rates change linearly to the nearest reachable value, so that distance and turn are those
of the mean rates; at a constant turn rate the path is an arc, whose chord is distance * sin(turn / 2) / (turn / 2).
Limits are physics, not errors: a command beyond them is followed as far as they allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from crowdcosim.robots import RobotModel


class Motion(NamedTuple):
    """What a drive would do in one step if nothing were in its way."""

    dx: float
    """displacement along the map's x [m]"""
    dy: float
    """displacement along the map's y [m]"""
    turn: float
    """change of heading [rad]"""
    speed: float
    """forward speed at the end [m/s]"""
    turn_rate: float
    """turn rate at the end [rad/s]"""


@dataclass(slots=True, kw_only=True)
class DifferentialDrive:
    """Pose and rates of a base with two driven wheels, which never moves sideways."""

    model: RobotModel
    x: float
    """[m]"""
    y: float
    """[m]"""
    heading: float
    """counter-clockwise from the map's x [rad]"""
    speed: float = 0.0
    """forward speed [m/s]"""
    turn_rate: float = 0.0
    """counter-clockwise [rad/s]"""

    def plan(self, speed: float, turn_rate: float, h: float) -> Motion:
        """The motion of the next `h` [s] towards the commanded `speed` [m/s] and `turn_rate` [rad/s]."""
        model = self.model
        return self.approach(
            min(max(speed, model.min_speed), model.max_speed),
            min(max(turn_rate, -model.max_angular_velocity), model.max_angular_velocity),
            model.max_acceleration,
            model.max_angular_acceleration,
            h,
        )

    def approach(
        self, speed: float, turn_rate: float, acceleration: float, angular_acceleration: float, h: float
    ) -> Motion:
        """The motion of the next `h` [s], in which the rates come as near to these as the accelerations allow.

        `speed` [m/s], `turn_rate` [rad/s], `acceleration` [m/s2] and `angular_acceleration` [rad/s2], the latter two
        either way.
        """
        next_speed = _towards(self.speed, speed, acceleration * h)
        next_rate = _towards(self.turn_rate, turn_rate, angular_acceleration * h)
        turn = 0.5 * (self.turn_rate + next_rate) * h
        dx, dy = chord(self.heading, 0.5 * (self.speed + next_speed) * h, turn)
        return Motion(dx, dy, turn, next_speed, next_rate)

    def move(self, motion: Motion, share: float) -> None:
        """Carry out `motion`, of whose way only `share` (0 to 1) is free: below 1 the base stops, but still turns."""
        self.x += share * motion.dx
        self.y += share * motion.dy
        self.heading = math.remainder(self.heading + motion.turn, 2.0 * math.pi)
        self.speed = motion.speed if share >= 1.0 else 0.0
        self.turn_rate = motion.turn_rate


def chord(heading: float, distance: float, turn: float) -> tuple[float, float]:
    """Displacement (x, y) [m] along an arc of `distance` [m] that starts at `heading` and turns by `turn` [rad]."""
    half = 0.5 * turn
    length = distance * (math.sin(half) / half) if half else distance
    return length * math.cos(heading + half), length * math.sin(heading + half)


def _towards(value: float, wanted: float, most: float) -> float:
    return min(max(wanted, value - most), value + most)
