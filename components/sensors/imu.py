"""An inertial measurement unit: a gyroscope and an accelerometer of three axes each.

Since the last reading, over the time T and the steps k in it, with the velocity v, the turn phi of a step of length dt,
the turn rate w and the unit at r from the base's centre:
    gyroscope      sum phi_k / T;
    accelerometer  (sum R_k (v_k+1 - v_k) + (w_k+1 - w_k) x r - phi_k^2 / dt r) / T, and g upwards,
where R_k turns the map's axes to those of the base midway (the specific force: at rest it is g, upwards). These are
means over T, as a unit gives that integrates between its readings, so that `white` noise of a data sheet's density is
right whatever the step. The first reading is that of a base without acceleration.
REP 145: frame of the unit, x ahead; it estimates no orientation, which `orientation_covariance[0] = -1` says. The
other covariances hold what `gaussian` and `white` errors add per reading; 0: not known, or exact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from components.sensors.imperfections import Bias, Chain, Drift, Gaussian, Quantisation, Signal, Spikes, White
from components.sensors.timing import Delivery, TimingKind, require_rate
from crowdcosim.component import Sensor
from crowdcosim.messages import Header, Imu, RobotState, Vector3
from crowdcosim.robots import Mount, RobotModel
from crowdcosim.setup import Setup, nanoseconds_of

GRAVITY = 9.80665
"""standard gravity [m/s2]"""

_AT_THE_CENTRE = Mount(position=(0.0, 0.0, 0.0))

AxisError = Annotated[Gaussian | White | Bias | Drift | Spikes | Quantisation, Field(discriminator="kind")]


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of an `InertialUnit`."""

    mount: str | Mount = _AT_THE_CENTRE
    """a mount of the robot's by name, or a place; level"""
    gyroscope: tuple[AxisError, ...] = ()
    """what is wrong with the turn rates, in this order [rad/s]"""
    accelerometer: tuple[AxisError, ...] = ()
    """what is wrong with the accelerations, in this order [m/s2]"""
    rate: float | None = None
    """messages per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[TimingKind, ...] = ()
    """what is wrong with the messages' timing"""

    def __post_init__(self) -> None:
        require_rate(self)

    def frames(self, model: RobotModel) -> Mapping[str, Mount]:
        """The one frame of the messages, which is called as the sensor is.

        Raises:
            ValueError: if the robot has no such mount, or it is not level.
        """
        mount = model.mount(self.mount)
        if mount.pitch:
            raise ValueError(f"mount has a pitch of {mount.pitch}, expected 0: the unit is level")
        return {"": mount}


class InertialUnit(Sensor):
    """Measures turn rate and acceleration of its own robot."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        self._mount = self.config.frames(setup.own_robot.model)[""]
        self._begin()
        self.step(RobotState())  # Compile now, not in the first step.
        self._begin()

    def _begin(self) -> None:
        config, setup = self.config, self._setup
        self._delivery = Delivery[Imu](config.imperfections, config.rate, setup)
        signal = Signal(instruments=3, period=self._delivery.period)
        self._gyroscope = Chain(config.gyroscope, signal, setup.seed, 0)
        self._accelerometer = Chain(config.accelerometer, signal, setup.seed, 1)
        self._last: RobotState | None = None
        self._turn, self._push = np.zeros((3, 1)), np.zeros((3, 1))
        self._elapsed = 0.0

    def step(self, robot: RobotState) -> Imu:
        last, self._last = self._last, robot
        if last is not None and last.header.stamp != robot.header.stamp:
            self._integrate(last, robot)
        time = nanoseconds_of(robot.header.stamp)
        return self._delivery.step(time, lambda: self._take(time, robot))

    def _integrate(self, last: RobotState, robot: RobotState) -> None:
        """Add what happens from one state to the next to the turn and the change of velocity since the last reading."""
        seconds = (nanoseconds_of(robot.header.stamp) - nanoseconds_of(last.header.stamp)) * 1e-9
        turn = math.remainder(robot.heading - last.heading, 2.0 * math.pi)
        middle = last.heading + 0.5 * turn
        vx, vy = (robot.velocity - last.velocity).tolist()
        ahead, left, _ = self._mount.position
        spin_up, centripetal = robot.angular_velocity - last.angular_velocity, turn * turn / seconds
        x = vx * math.cos(middle) + vy * math.sin(middle) - spin_up * left - centripetal * ahead
        y = vy * math.cos(middle) - vx * math.sin(middle) + spin_up * ahead - centripetal * left
        cos, sin = math.cos(self._mount.yaw), math.sin(self._mount.yaw)
        self._turn[2] += turn
        self._push += [[cos * x + sin * y], [cos * y - sin * x], [GRAVITY * seconds]]
        self._elapsed += seconds

    def _take(self, time: int, robot: RobotState) -> Imu:
        elapsed = self._elapsed or self._delivery.period
        if self._elapsed:
            rates, forces = self._turn / elapsed, self._push / elapsed
        else:
            rates, forces = np.array([[0.0], [0.0], [robot.angular_velocity]]), np.array([[0.0], [0.0], [GRAVITY]])
        self._turn, self._push, self._elapsed = np.zeros((3, 1)), np.zeros((3, 1)), 0.0
        self._gyroscope.apply(rates, time)
        self._accelerometer.apply(forces, time)
        no_orientation = np.zeros(9)
        no_orientation[0] = -1.0
        return Imu(
            header=Header(stamp=robot.header.stamp, frame_id=self._setup.component),
            orientation_covariance=no_orientation,
            angular_velocity=_vector(rates),
            angular_velocity_covariance=_covariance(self.config.gyroscope, elapsed),
            linear_acceleration=_vector(forces),
            linear_acceleration_covariance=_covariance(self.config.accelerometer, elapsed),
        )


def _vector(axes: NDArray[np.float64]) -> Vector3:
    x, y, z = axes.ravel().tolist()
    return Vector3(x=x, y=y, z=z)


def _covariance(errors: tuple[AxisError, ...], elapsed: float) -> NDArray[np.float64]:
    """(9,) of the errors that are drawn anew for every reading."""
    variance = sum(error.deviation**2 for error in errors if isinstance(error, Gaussian))
    variance += sum(error.deviation(elapsed) ** 2 for error in errors if isinstance(error, White))
    return variance * np.eye(3).ravel()
