"""Encoders on the two driven wheels, and the odometry that their counts add up to.

Over a step with the way s and the turn phi, as far as the wheels roll them, the left wheel rolls s - phi b / 2 and the
right one s + phi b / 2, b being the track. Wheels slip: the way and the turn that they roll differ from the true ones
by the errors of `components.sensors.dead_reckoning`. Each encoder counts the whole ticks of its wheel's angle, down.
Odometry knows the counts only. A motion to the side is not seen. The covariance has the slip and, per step, the
variance of a count, 1/6 tick^2 per wheel (two roundings).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.sensors.dead_reckoning import (
    DeadReckoning,
    Motion,
    MotionNoise,
    arc_to_chord,
    motion_between,
    odometry_message,
)
from components.sensors.timing import Delivery, TimingKind, require_rate
from crowdcosim.component import Sensor
from crowdcosim.messages import EncoderTicks, Header, Odometry, RobotState
from crowdcosim.setup import Setup, nanoseconds_of


@dataclass(frozen=True, kw_only=True)
class Config(MotionNoise):
    """Options of `WheelEncoders`; the wheels are those of the robot's `base`."""

    ticks_per_turn: float
    """counts in one turn of a wheel"""
    rate: float | None = None
    """messages per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[TimingKind, ...] = ()
    """what is wrong with the messages' timing"""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_rate(self)
        if not self.ticks_per_turn > 0.0:
            raise ValueError(f"ticks_per_turn is {self.ticks_per_turn}, expected a positive number")


class EncodersOutput(NamedTuple):
    """The counts, and the pose that they add up to."""

    ticks: EncoderTicks
    odometry: Odometry


class WheelEncoders(Sensor):
    """Counts the turns of a differential drive's two wheels."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def reset(self, setup: Setup) -> None:
        base = setup.own_robot.model.base
        if base.kind != "differential" or base.wheel_radius is None or base.track is None:
            raise ValueError(
                f"the base of robot '{setup.robot}' is {base}, expected a differential one with wheel_radius and track"
            )
        self._setup = setup
        self._track = base.track
        self._tick = 2.0 * math.pi * base.wheel_radius / self.config.ticks_per_turn
        self._rng = setup.rng()
        self._delivery = Delivery[EncodersOutput](self.config.imperfections, self.config.rate, setup)
        self._last: RobotState | None = None
        self._rolled = np.zeros(2)
        self._ticks = np.zeros(2, np.int64)
        self._twist = np.zeros(3)
        self._twist_covariance = np.zeros((3, 3))

    def step(self, robot: RobotState) -> EncodersOutput:
        if self._last is None:
            self._estimate = DeadReckoning(robot)
        elif self._last.header.stamp != robot.header.stamp:
            self._roll(self._last, robot)
        self._last = robot
        return self._delivery.step(nanoseconds_of(robot.header.stamp), lambda: self._message(robot))

    def _roll(self, last: RobotState, robot: RobotState) -> None:
        """Turn the wheels as far as the robot has moved since `last`, and move the estimate on by the counts."""
        true = motion_between(last, robot, self._setup.world)
        motion = Motion(true.ahead, 0.0, true.turn)
        slip = self.config.deviations(motion)
        e_way, _, e_turn = slip * self._rng.standard_normal(3)
        way, half_turn = motion.ahead / arc_to_chord(motion.turn) + e_way, 0.5 * (motion.turn + e_turn) * self._track
        self._rolled += (way - half_turn, way + half_turn)
        before, self._ticks = self._ticks, np.floor(self._rolled / self._tick).astype(np.int64)
        measured = self._motion(self._ticks - before)
        deviations = np.sqrt(slip**2 + self._counting_variances(measured))
        self._estimate.move(measured, deviations)
        rate = 1e9 / (nanoseconds_of(robot.header.stamp) - nanoseconds_of(last.header.stamp))
        self._twist = np.array([measured.way * math.copysign(1.0, measured.ahead), 0.0, measured.turn]) * rate
        self._twist_covariance = np.diag((deviations * rate) ** 2)

    def _motion(self, counts: NDArray[np.int64]) -> Motion:
        """What the robot has done if its wheels have turned by these counts and rolled."""
        left, right = (self._tick * counts).tolist()
        turn = (right - left) / self._track
        return Motion(0.5 * (left + right) * arc_to_chord(turn), 0.0, turn)

    def _counting_variances(self, motion: Motion) -> NDArray[np.float64]:
        """(3,) of a motion ahead, left and turn, if each wheel's way has the variance of a rounded count's change."""
        wheel = self._tick**2 / 6.0
        of_turn = 2.0 * wheel / self._track**2
        return np.array([0.5 * wheel, motion.way**2 * of_turn / 12.0, of_turn])

    def _message(self, robot: RobotState) -> EncodersOutput:
        return EncodersOutput(
            ticks=EncoderTicks(
                header=Header(stamp=robot.header.stamp, frame_id=f"{robot.name}/base_link"),
                wheel=("left", "right"),
                ticks=self._ticks,
                ticks_per_turn=np.full(2, self.config.ticks_per_turn),
            ),
            odometry=odometry_message(robot, self._estimate, self._twist, self._twist_covariance),
        )
