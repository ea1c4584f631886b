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
        numbers, cut = setup.world.mesh_section(height)
        self.walls = Walls(
            np.concatenate([setup.world.segment_numbers[seen], numbers]),
            np.concatenate([setup.world.segments[seen], cut]),
        )
        """those that are as high as the sensor, and the section of the mesh"""
        self.period = setup.world.period
        """(2,) of the map [m]"""
        self._height_of = {robot.name: robot.model.height for robot in setup.robots}
        self._nobody = _cylinders([], [], [], [])
        self._number_of = {robot.name: robot.number for robot in setup.robots}

    def robots(self, states: tuple[RobotState, ...]) -> Cylinders:
        """Other robots."""
        if not states:
            return self._nobody
        return _cylinders(
            [self._number_of[state.name] for state in states],
            [state.position for state in states],
            [state.radius for state in states],
            [self._height_of[state.name] for state in states],
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


def _cylinders(number: list[int], centre: list[NDArray], radius: list[float], height: list[float]) -> Cylinders:
    """Their arrays are read-only, as those of a message are, so that kernels are compiled once."""
    arrays = Cylinders(
        np.array(number, np.uint32),
        np.array(centre, np.float64).reshape(-1, 2),
        np.array(radius, np.float64),
        np.array(height, np.float64),
    )
    for array in arrays:
        array.flags.writeable = False
    return arrays
