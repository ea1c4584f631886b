"""A pose from measured motions: each moves the estimate on, and errors add up.

Over a step with the way s (along the arc) and the turn phi, what is measured differs from the truth by
    e_phi ~ N(0, alpha_1 |phi| + alpha_2 |s|) in the turn,    e_s ~ N(0, alpha_3 |s| + alpha_4 |phi|) in the way.
After the odometry motion model of Thrun, Burgard and Fox, Probabilistic Robotics, 2005, section 5.4, table 5.6.
Differs from the book: variances grow with way and turn and not with their squares, so that ten short steps are as
uncertain as a long one; the two rotations of a step are one, as the robot drives an arc. For the same reason the way's
direction gets the part of the heading's random walk within a step that its end does not show (variance / 12).

Frames after REP 105: `odom` coincides with `map` (the transform from map to odom is the identity) and the robot starts
where it truly is, so that drift is the difference between this pose and the true one. Pose and its covariance are in
`odom`, the twist and its covariance in `<robot>/base_link`, as nav_msgs/Odometry has it; a covariance of 0 is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
from crowdcosim.world import World

# x, y and yaw among the six of a ROS covariance.
_PLANAR = np.ix_([0, 1, 5], [0, 1, 5])


class Motion(NamedTuple):
    """What a robot does in a step, or what is measured of it."""

    ahead: float
    """chord of the arc, along the heading midway [m]"""
    left: float
    """the same to its left [m]"""
    turn: float
    """counter-clockwise [rad]"""

    @property
    def way(self) -> float:
        """Length of the arc [m]."""
        return math.hypot(self.ahead, self.left) / arc_to_chord(self.turn)


def motion_between(last: RobotState, robot: RobotState, world: World) -> Motion:
    """The true motion from one state to the next."""
    turn = math.remainder(robot.heading - last.heading, 2.0 * math.pi)
    x, y = world.displacement(last.position, robot.position).tolist()
    middle = last.heading + 0.5 * turn
    cos, sin = math.cos(middle), math.sin(middle)
    return Motion(x * cos + y * sin, y * cos - x * sin, turn)


def arc_to_chord(turn: float) -> float:
    """A chord's length over that of its arc, which turns by so much [rad]."""
    return float(np.sinc(0.5 * turn / math.pi))


@dataclass(frozen=True, kw_only=True)
class MotionNoise:
    """How uncertain measured motions are; all zero: exact."""

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

    def deviations(self, motion: Motion) -> NDArray[np.float64]:
        """(3,) standard deviations of the measured motion's errors: ahead, left [m] and turn [rad]."""
        way, turn = motion.way, abs(motion.turn)
        variance_of_turn = self.turn_by_turn * turn + self.turn_by_way * way
        variance_of_way = self.way_by_way * way + self.way_by_turn * turn
        return np.sqrt([variance_of_way, way**2 * variance_of_turn / 12.0, variance_of_turn])


class DeadReckoning:
    """The pose that measured motions add up to, and its covariance."""

    def __init__(self, start: RobotState) -> None:
        self.pose = np.array([*start.position, start.heading])
        """x, y [m] and heading [rad] in `odom`"""
        self.covariance = np.zeros((3, 3))
        """of the pose"""

    def move(self, measured: Motion, deviations: NDArray[np.float64]) -> None:
        """Move on by a motion with errors of these deviations, (3,) ahead, left and turn."""
        middle = self.pose[2] + 0.5 * measured.turn
        cos, sin = math.cos(middle), math.sin(middle)
        step = np.array([[cos, -sin], [sin, cos]]) @ (measured.ahead, measured.left)
        self.pose += (*step, measured.turn)
        from_pose = np.array([[1.0, 0.0, -step[1]], [0.0, 1.0, step[0]], [0.0, 0.0, 1.0]])
        from_errors = np.array([[cos, -sin, -0.5 * step[1]], [sin, cos, 0.5 * step[0]], [0.0, 0.0, 1.0]])
        spread = from_errors * deviations
        self.covariance = from_pose @ self.covariance @ from_pose.T + spread @ spread.T


def odometry_message(
    robot: RobotState, estimate: DeadReckoning, twist: NDArray[np.float64], twist_covariance: NDArray[np.float64]
) -> Odometry:
    """The message of a robot's time; `twist` (3,): ahead, left [m/s] and turn rate [rad/s], and its covariance."""
    x, y, heading = estimate.pose.tolist()
    ahead, left, turn = twist.tolist()
    return Odometry(
        header=Header(stamp=robot.header.stamp, frame_id="odom"),
        child_frame_id=f"{robot.name}/base_link",
        pose=PoseWithCovariance(
            pose=Pose(
                position=Point(x=x, y=y), orientation=Quaternion(z=math.sin(0.5 * heading), w=math.cos(0.5 * heading))
            ),
            covariance=_six(estimate.covariance),
        ),
        twist=TwistWithCovariance(
            twist=Twist(linear=Vector3(x=ahead, y=left), angular=Vector3(z=turn)), covariance=_six(twist_covariance)
        ),
    )


def _six(planar: NDArray[np.float64]) -> NDArray[np.float64]:
    """(36,) covariance of (x, y, z, roll, pitch, yaw) from that of (x, y, yaw), (3, 3)."""
    covariance = np.zeros((6, 6))
    covariance[_PLANAR] = planar
    return covariance.reshape(36)
