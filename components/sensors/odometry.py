"""Odometry: the pose as dead reckoning tells it, exact or adrift.

What the wheels tell of a step has the errors of `components.sensors.dead_reckoning`. The twist is true but for the same
errors, over the time of the step. `components.sensors.encoders` counts the wheels' turns besides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from components.sensors.dead_reckoning import DeadReckoning, Motion, MotionNoise, motion_between, odometry_message
from components.sensors.timing import Delivery, TimingKind, require_rate
from crowdcosim.component import Sensor
from crowdcosim.messages import Odometry, RobotState
from crowdcosim.setup import Setup, nanoseconds_of


@dataclass(frozen=True, kw_only=True)
class Config(MotionNoise):
    """Options of an `Odometer`; all left out: exact and at once."""

    rate: float | None = None
    """messages per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[TimingKind, ...] = ()
    """what is wrong with the messages' timing"""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_rate(self)


class Odometer(Sensor):
    """Counts the way and the turn of its own robot."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        self._rng = setup.rng()
        self._delivery = Delivery[Odometry](self.config.imperfections, self.config.rate, setup)
        self._last: RobotState | None = None
        self._twist_error = np.zeros(3)
        self._twist_covariance = np.zeros((3, 3))

    def step(self, robot: RobotState) -> Odometry:
        if self._last is None or self.config.exact:
            self._estimate = DeadReckoning(robot)
        elif self._last.header.stamp != robot.header.stamp:
            self._drift(self._last, robot)
        self._last = robot
        return self._delivery.step(nanoseconds_of(robot.header.stamp), lambda: self._message(robot))

    def _drift(self, last: RobotState, robot: RobotState) -> None:
        """Move the estimate on by the true motion since `last` and what is wrong with its measurement."""
        motion = motion_between(last, robot, self._setup.world)
        deviations = self.config.deviations(motion)
        errors = deviations * self._rng.standard_normal(3)
        self._estimate.move(Motion(*(np.array(motion) + errors).tolist()), deviations)
        rate = 1e9 / (nanoseconds_of(robot.header.stamp) - nanoseconds_of(last.header.stamp))
        self._twist_error = errors * rate
        self._twist_covariance = np.diag((deviations * rate) ** 2)

    def _message(self, robot: RobotState) -> Odometry:
        cos, sin = math.cos(robot.heading), math.sin(robot.heading)
        vx, vy = robot.velocity.tolist()
        true = np.array([cos * vx + sin * vy, cos * vy - sin * vx, robot.angular_velocity])
        return odometry_message(robot, self._estimate, true + self._twist_error, self._twist_covariance)
