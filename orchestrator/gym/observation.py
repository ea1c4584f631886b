"""Observations as arrays in known bounds: one part per output of the robot's sensors, and the way to its goal.

Values beyond the bounds, which only noise can make, are clipped to them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from crowdcosim.goal import target
from crowdcosim.message import Message
from crowdcosim.messages import Detections, Goal, Image, LaserScan, Odometry, Range, Ranges, RobotState
from crowdcosim.robots import Holonomic, Robot
from crowdcosim.world import World
from orchestrator.view import RobotView, View

PERSON_SPEED = 10.0
"""nobody is faster [m/s]"""
_PIXELS: dict[str, tuple[type[np.unsignedinteger[Any]], int]] = {
    "rgb8": (np.uint8, 3),
    "bgr8": (np.uint8, 3),
    "mono8": (np.uint8, 1),
    "8UC1": (np.uint8, 1),
    "mono16": (np.uint16, 1),
    "16UC1": (np.uint16, 1),
}
"""image encoding -> type and number of channels"""


class Part(NamedTuple):
    """One part of an observation."""

    space: Box
    array: Callable[[Any], NDArray[Any]]
    """makes it of the sensor's message"""


def sensed(message: Message, robot: Robot, world: World, time_limit: float, people: int) -> Part | None:
    """How a sensor's output is observed, `message` being the first one; None if it has no array in known bounds.

    Args:
        time_limit: of the episode [s]; with the robot's speed it bounds where the robot can be.
        people: how many of `Detections` are kept, nearest first.
    """
    match message:
        case LaserScan():
            return _scan(message)
        case Odometry():
            return _odometry(robot, time_limit)
        case Range() | Ranges():
            return _ranges(message)
        case Detections():
            return _Nearest(people, world).part(lambda found: (found.position, found.velocity, found.radius))
        case Image() if message.encoding in _PIXELS:
            return _image(message)
    return None


class WayToGoal:
    """Distance [m], and cosine and sine of the direction as seen from the robot; by its odometry where it has any."""

    def __init__(self, goal: Goal, robot: Robot, time_limit: float) -> None:
        start = np.array([robot.start.x, robot.start.y])
        farthest = float(np.hypot(*(target(goal, start) - start))) + _reach(robot, time_limit)
        self.space = Box(np.array([0, -1, -1], np.float32), np.array([farthest, 1, 1], np.float32))
        self._goal = goal

    def array(self, view: RobotView) -> NDArray[np.float32]:
        position, heading = _pose(view)
        x, y = (target(self._goal, position) - position).tolist()
        distance, angle = math.hypot(x, y), math.atan2(y, x) - heading
        return _within(self.space, np.array([distance, math.cos(angle), math.sin(angle)], np.float32))


class People:
    """The nearest people as they truly are, seen from the robot: x, y [m], velocity [m/s], radius [m]; 0 for nobody."""

    def __init__(self, count: int, robot: str, world: World) -> None:
        nearest = _Nearest(count, world)
        self._robot, self._world = robot, world
        self.space, self._array = nearest.part(self._seen)

    def array(self, view: View) -> NDArray[np.float32]:
        array: NDArray[np.float32] = self._array(view)
        return array

    def _seen(self, view: View) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        crowd, robot = view.crowd, view.robots[self._robot].state
        if crowd is None:
            return np.empty((0, 2)), np.empty((0, 2)), np.empty(0)
        cos, sin = math.cos(robot.heading), math.sin(robot.heading)
        to_robot = np.array([[cos, -sin], [sin, cos]])
        away = self._world.displacement(robot.position, crowd.position)
        return away @ to_robot, crowd.velocity @ to_robot, crowd.radius


class _Nearest:
    def __init__(self, count: int, world: World) -> None:
        self._count = count
        size = math.hypot(*world.size)
        high = np.array([size, size, PERSON_SPEED, PERSON_SPEED, 2.0], np.float32)
        low = np.array([-size, -size, -PERSON_SPEED, -PERSON_SPEED, 0.0], np.float32)
        self._space = Box(np.tile(low, (count, 1)), np.tile(high, (count, 1)))

    def part(self, read: Callable[[Any], tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]) -> Part:
        def array(source: Any) -> NDArray[np.float32]:
            position, velocity, radius = read(source)
            order = np.argsort(np.hypot(position[:, 0], position[:, 1]), kind="stable")[: self._count]
            table = np.zeros((self._count, 5), np.float32)
            table[: len(order), :2] = position[order]
            table[: len(order), 2:4] = velocity[order]
            table[: len(order), 4] = radius[order]
            return _within(self._space, table)

        return Part(self._space, array)


def _scan(first: LaserScan) -> Part:
    """Ranges [m]: `range_max` where nothing is, 0 where something is too near to be measured."""
    limit = first.range_max
    space = Box(0.0, limit, first.ranges.shape, np.float32)
    return Part(space, lambda scan: np.clip(scan.ranges, 0.0, limit, dtype=np.float32))


def _ranges(first: Range | Ranges) -> Part:
    """One range per finder [m], as in a scan."""
    high = np.array([one.max_range for one in _finders(first)], np.float32)
    space = Box(np.zeros_like(high), high)
    return Part(space, lambda ring: _within(space, np.array([one.range for one in _finders(ring)], np.float32)))


def _finders(message: Range | Ranges) -> tuple[Range, ...]:
    return message.ranges if isinstance(message, Ranges) else (message,)


def _odometry(robot: Robot, time_limit: float) -> Part:
    """x, y [m], heading [rad], speed ahead and to the left [m/s], turn rate [rad/s]."""
    model, reach = robot.model, _reach(robot, time_limit)
    speed, turn_rate = 2 * _top_speed(robot), 2 * model.max_angular_velocity  # twice: noise
    high = np.array([robot.start.x + reach, robot.start.y + reach, math.pi, speed, speed, turn_rate], np.float32)
    low = np.array([robot.start.x - reach, robot.start.y - reach, -math.pi, -speed, -speed, -turn_rate], np.float32)
    space = Box(low, high)

    def array(odometry: Odometry) -> NDArray[np.float32]:
        position, heading = _pose_of(odometry)
        twist = odometry.twist.twist
        values = (*position, math.remainder(heading, math.tau), twist.linear.x, twist.linear.y, twist.angular.z)
        return _within(space, np.array(values, np.float32))

    return Part(space, array)


def _image(first: Image) -> Part:
    """(height, width, channels), as the camera gives it."""
    pixel, channels = _PIXELS[first.encoding]
    shape = (first.height, first.width, channels)
    dtype = np.dtype(pixel).newbyteorder(">" if first.is_bigendian else "<")
    space = Box(0, np.iinfo(pixel).max, shape, pixel)
    return Part(space, lambda image: image.data.view(dtype).reshape(shape).astype(pixel))


def _pose(view: RobotView) -> tuple[NDArray[np.float64], float]:
    for message in view.sensors.values():
        if isinstance(message, Odometry):
            return _pose_of(message)
    state: RobotState = view.state
    return state.position, state.heading


def _pose_of(odometry: Odometry) -> tuple[NDArray[np.float64], float]:
    pose = odometry.pose.pose
    return np.array([pose.position.x, pose.position.y]), 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


def _top_speed(robot: Robot) -> float:
    model = robot.model
    sideways = model.base.max_lateral_speed if isinstance(model.base, Holonomic) else 0.0
    return math.hypot(max(model.max_speed, -model.min_speed), sideways)


def _reach(robot: Robot, time_limit: float) -> float:
    """How far the robot can come [m], and twice that, for noise."""
    return 2.0 * _top_speed(robot) * time_limit


def _within(space: Box, array: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.clip(array, space.low, space.high)
