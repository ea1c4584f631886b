"""A differential drive as its controller knows it: its limits, how it moves, how it follows a wished velocity."""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from crowdcosim.robots import RobotModel

STANDING = 1e-6
"""speed below which a velocity has no direction [m/s]"""


class Limits(NamedTuple):
    """What the robot can do."""

    min_speed: float
    max_speed: float
    max_acceleration: float
    max_turn_rate: float
    max_angular_acceleration: float


class Motion(NamedTuple):
    """Pose and rates in a plan, relative to the robot's position when it was made."""

    x: float
    """[m]"""
    y: float
    """[m]"""
    heading: float
    """[rad]"""
    speed: float
    """[m/s]"""
    turn_rate: float
    """[rad/s]"""


def limits_of(model: RobotModel) -> Limits:
    """The limits of a robot."""
    return Limits(
        model.min_speed,
        model.max_speed,
        model.max_acceleration,
        model.max_angular_velocity,
        model.max_angular_acceleration,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def advance(motion: Motion, speed: float, turn_rate: float, dt: float, limits: Limits) -> Motion:
    """Where the robot is after dt [s] if told to drive at `speed` [m/s] and `turn_rate` [rad/s]: one straight chord."""
    speed = min(limits.max_speed, max(limits.min_speed, speed))
    turn_rate = min(limits.max_turn_rate, max(-limits.max_turn_rate, turn_rate))
    dv, domega = limits.max_acceleration * dt, limits.max_angular_acceleration * dt
    v = min(motion.speed + dv, max(motion.speed - dv, speed))
    omega = min(motion.turn_rate + domega, max(motion.turn_rate - domega, turn_rate))
    way, turned = 0.5 * (motion.speed + v) * dt, 0.5 * (motion.turn_rate + omega) * dt
    middle = motion.heading + 0.5 * turned
    return Motion(
        motion.x + way * math.cos(middle), motion.y + way * math.sin(middle), motion.heading + turned, v, omega
    )


@njit(cache=True, nogil=True, error_model="numpy")
def without_retreat(x: float, y: float, bearing: float) -> tuple[float, float]:
    """The velocity (x, y) [m/s] without its part against the direction `bearing` [rad]."""
    ahead_x, ahead_y = math.cos(bearing), math.sin(bearing)
    back = min(0.0, x * ahead_x + y * ahead_y)
    return x - back * ahead_x, y - back * ahead_y


@njit(cache=True, nogil=True, error_model="numpy")
def drive(x: float, y: float, heading: float) -> tuple[float, float]:
    """How fast to drive along the `heading` [m/s], and the direction to turn to [rad], for the velocity (x, y) [m/s].

    v = max(0, |V| cos e), e from the heading to V.
    """
    if math.hypot(x, y) < STANDING:
        return 0.0, heading
    return max(0.0, x * math.cos(heading) + y * math.sin(heading)), math.atan2(y, x)
