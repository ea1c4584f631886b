"""What is around a sensor, as the kernels of `components.sensors.scan` take it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from components.sensors.scan import Cylinders, People, Pose, Walls
from crowdcosim.messages import Crowd, RobotState
from crowdcosim.robots import Mount
from crowdcosim.setup import Setup


class Surroundings:
    """The world of an episode for a sensor that looks level, at the height of its mount."""

    def __init__(self, setup: Setup, height: float) -> None:
        seen = setup.world.segment_heights >= height
        self.walls = Walls(setup.world.segment_numbers[seen], setup.world.segments[seen])
        """those that are as high as the sensor"""
        self.period = setup.world.period
        """(2,) of the map [m]"""
        self._height_of = {robot.name: robot.model.height for robot in setup.robots}
        self._number_of = {robot.name: robot.number for robot in setup.robots}

    def robots(self, states: tuple[RobotState, ...]) -> Cylinders:
        """Other robots; arrays are read-only, as those of a message are, so that kernels are compiled once."""
        return Cylinders(
            _read_only(np.array([self._number_of[state.name] for state in states], np.uint32)),
            _read_only(np.array([state.position for state in states], np.float64).reshape(-1, 2)),
            _read_only(np.array([state.radius for state in states], np.float64)),
            _read_only(np.array([self._height_of[state.name] for state in states], np.float64)),
        )


def people_of(crowd: Crowd) -> People:
    """Everybody."""
    return People(crowd.id, crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)


def pose_of(robot: RobotState, mount: Mount) -> Pose:
    """Where a mount is in the map, while its robot is there."""
    ahead, left, up = mount.position
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    x, y = robot.position.tolist()
    heading = robot.heading + mount.yaw
    return Pose(x + cos * ahead - sin * left, y + sin * ahead + cos * left, up, math.cos(heading), math.sin(heading))


def _read_only(array: NDArray) -> NDArray:
    array.flags.writeable = False
    return array
