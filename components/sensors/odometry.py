"""Odometry: the pose as the wheels tell it, exact or adrift.

Over a step with the way s (along the arc) and the turn phi, what the wheels tell differs from the truth by
    e_phi ~ N(0, alpha_1 |phi| + alpha_2 |s|) in the turn,    e_s ~ N(0, alpha_3 |s| + alpha_4 |phi|) in the way,
and the estimated pose moves on by what they tell: errors add up. After the odometry motion model of Thrun, Burgard and
Fox, Probabilistic Robotics, 2005, section 5.4, table 5.6.
Differs from the book: variances grow with way and turn and not with their squares, so that ten short steps are as
uncertain as a long one; the two rotations of a step are one, as the robot drives an arc. For the same reason the way's
direction gets the part of the heading's random walk within a step that its end does not show (variance / 12).

Frames after REP 105: `odom` coincides with `map` (the transform from map to odom is the identity) and the robot starts
where it truly is, so that drift is the difference between this pose and the true one. Pose and its covariance are in
`odom`, the twist and its covariance in `<robot>/base_link`, as nav_msgs/Odometry has it; a covariance of 0 is exact.
The twist is true but for the same errors, over the time of the step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdcosim.component import Sensor
from crowdcosim.messages import (
    Header,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    RobotState,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from crowdcosim.setup import Setup, nanoseconds_of

# x, y and yaw among the six of a ROS covariance.
_PLANAR = np.ix_([0, 1, 5], [0, 1, 5])


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of an `Odometer`; all zero: exact."""

    turn_by_turn: float = 0.0
    """alpha_1, variance of the heading per angle turned [rad2/rad]"""
    turn_by_way: float = 0.0
    """alpha_2, variance of the heading per way driven [rad2/m]"""
    way_by_way: float = 0.0
    """alpha_3, variance of the way per way driven [m2/m]"""
    way_by_turn: float = 0.0
    """alpha_4, variance of the way per angle turned [m2/rad]"""

    def __post_init__(self) -> None:
        for name in ("turn_by_turn", "turn_by_way", "way_by_way", "way_by_turn"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected zero or more")

    @property
    def exact(self) -> bool:
        """True if there is no noise."""
        return not (self.turn_by_turn or self.turn_by_way or self.way_by_way or self.way_by_turn)


class Odometer(Sensor):
    """Counts the way and the turn of its own robot."""

    def __init__(self, config: Config) -> None:
        self.config = config

    def reset(self, setup: Setup) -> None:
        self._setup = setup
        self._rng = setup.rng()
        self._last: RobotState | None = None
        self._pose = np.zeros(3)
        self._pose_covariance = np.zeros((3, 3))
        self._twist_error = np.zeros(3)
        self._twist_covariance = np.zeros((3, 3))

    def step(self, robot: RobotState) -> Odometry:
        if self._last is None or self.config.exact:
            self._pose = np.array([*robot.position, robot.heading])
        else:
            self._drift(self._last, robot)
        self._last = robot
        return self._message(robot)

    def _drift(self, last: RobotState, robot: RobotState) -> None:
        """Move the estimate on by the true motion since `last` and what the wheels get wrong of it."""
        config = self.config
        turn = math.remainder(robot.heading - last.heading, 2.0 * math.pi)
        moved = self._setup.world.displacement(last.position, robot.position)
        middle = last.heading + 0.5 * turn
        ahead = moved[0] * math.cos(middle) + moved[1] * math.sin(middle)
        left = moved[1] * math.cos(middle) - moved[0] * math.sin(middle)
        way = math.hypot(ahead, left) / np.sinc(0.5 * turn / math.pi)

        variance_of_turn = config.turn_by_turn * abs(turn) + config.turn_by_way * way
        variance_of_way = config.way_by_way * way + config.way_by_turn * abs(turn)
        deviations = np.sqrt([variance_of_way, way**2 * variance_of_turn / 12.0, variance_of_turn])
        e_ahead, e_left, e_turn = errors = deviations * self._rng.standard_normal(3)

        middle = self._pose[2] + 0.5 * (turn + e_turn)
        cos, sin = math.cos(middle), math.sin(middle)
        axes = np.array([[cos, -sin], [sin, cos]])
        step = axes @ (ahead + e_ahead, left + e_left)
        self._pose += (*step, turn + e_turn)

        from_pose = np.array([[1.0, 0.0, -step[1]], [0.0, 1.0, step[0]], [0.0, 0.0, 1.0]])
        from_errors = np.array([[cos, -sin, -0.5 * step[1]], [sin, cos, 0.5 * step[0]], [0.0, 0.0, 1.0]])
        spread = from_errors * deviations
        self._pose_covariance = from_pose @ self._pose_covariance @ from_pose.T + spread @ spread.T

        rate = 1e9 / (nanoseconds_of(robot.header.stamp) - nanoseconds_of(last.header.stamp))
        self._twist_error = errors * rate
        self._twist_covariance = np.diag((deviations * rate) ** 2)

    def _message(self, robot: RobotState) -> Odometry:
        x, y, heading = self._pose.tolist()
        cos, sin = math.cos(robot.heading), math.sin(robot.heading)
        vx, vy = robot.velocity.tolist()
        e_ahead, e_left, e_turn = self._twist_error.tolist()
        return Odometry(
            header=Header(stamp=robot.header.stamp, frame_id="odom"),
            child_frame_id=f"{robot.name}/base_link",
            pose=PoseWithCovariance(
                pose=Pose(
                    position=Point(x=x, y=y),
                    orientation=Quaternion(z=math.sin(0.5 * heading), w=math.cos(0.5 * heading)),
                ),
                covariance=_six(self._pose_covariance),
            ),
            twist=TwistWithCovariance(
                twist=Twist(
                    linear=Vector3(x=cos * vx + sin * vy + e_ahead, y=cos * vy - sin * vx + e_left),
                    angular=Vector3(z=robot.angular_velocity + e_turn),
                ),
                covariance=_six(self._twist_covariance),
            ),
        )


def _six(planar: NDArray[np.float64]) -> NDArray[np.float64]:
    """(36,) covariance of (x, y, z, roll, pitch, yaw) from that of (x, y, yaw), (3, 3)."""
    covariance = np.zeros((6, 6))
    covariance[_PLANAR] = planar
    return covariance.reshape(36)
