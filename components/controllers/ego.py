"""The robot as its controller knows it: pose and speeds from odometry, the way to the goal, the command to send."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crowdcosim.goal import reached
from crowdcosim.messages import Goal, Odometry, Twist, Vector3

TURN_GAIN = 2.0
"""turn rate per radian of heading error [1/s]"""


class Ego(NamedTuple):
    """Where the robot believes it is and how it moves. The frame `odom` is taken to lie on the frame `map`."""

    x: float
    """[m]"""
    y: float
    """[m]"""
    heading: float
    """counter-clockwise from x [rad]"""
    speed: float
    """forward [m/s]"""
    turn_rate: float
    """counter-clockwise [rad/s]"""


class Way(NamedTuple):
    """From the robot to its goal, in homogeneous coordinates along the axes of the frame `map`."""

    x: float
    """displacement if `weight` is 1 [m], unit vector if it is 0"""
    y: float
    weight: float
    """1: a point at (x, y) from the robot; 0: infinitely far in the direction (x, y)"""

    @property
    def bearing(self) -> float:
        """Direction of the goal, counter-clockwise from x [rad]."""
        return math.atan2(self.y, self.x)


def ego_of(odometry: Odometry) -> Ego:
    """Pose and speeds on the plane."""
    position, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    heading = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
    twist = odometry.twist.twist
    return Ego(float(position.x), float(position.y), heading, float(twist.linear.x), float(twist.angular.z))


def way_to(goal: Goal, ego: Ego) -> Way | None:
    """The way to the goal, or None for a robot that believes itself within the goal's disc.

    A line is approached along its normal, as if it were infinitely far, and also beyond it: whether it has been
    crossed is judged from the true pose, so that a robot whose odometry runs ahead must not stop or turn back.
    """
    direction_x, direction_y = goal.direction.tolist()
    if direction_x or direction_y:
        return Way(direction_x, direction_y, 0.0)
    if reached(goal, np.array([ego.x, ego.y])):
        return None
    x, y = goal.position.tolist()
    return Way(x - ego.x, y - ego.y, 1.0)


def heading_error(bearing: float, heading: float) -> float:
    """How far to turn from `heading` to `bearing`, in [-pi, pi] [rad]."""
    return math.remainder(bearing - heading, math.tau)


def turn(error: float, limit: float) -> float:
    """Turn rate that closes a heading error [rad], at most `limit` either way [rad/s]."""
    return max(-limit, min(limit, TURN_GAIN * error))


def command(speed: float, turn_rate: float) -> Twist:
    """A velocity command in the robot's frame: forward [m/s], counter-clockwise [rad/s]."""
    return Twist(linear=Vector3(x=speed), angular=Vector3(z=turn_rate))
