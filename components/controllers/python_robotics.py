"""Drives by a function of the signature that PythonRobotics uses, `u, trajectory = control(x, config, goal, ob)`.

    x = [x, y, yaw, v, omega]      the robot [m, rad, m/s, rad/s]
    goal = [x, y]                  where to go; if that is a line to cross, a point well beyond it [m]
    ob = [[x, y], ...]             points to keep clear of [m]
    u = [v, omega]                 the command; trajectory: rows that begin with x, y, yaw, the way it foresees

After A. Sakai et al., PythonRobotics: a Python code collection of robotics algorithms, 2018, arXiv:1808.10703; its
dynamic window approach has this signature. Its obstacles are points: people are given by their centres, walls and
obstacles by points along them, and the config's `robot_radius` is the robot's with that of a person added. Limits and
time step of the robot are written into the config's fields of the names that PythonRobotics uses, where it has them.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.controllers.ego import command, ego_of
from crowdcosim import Controller, Setup
from crowdcosim.component import ComponentError
from crowdcosim.goal import target
from crowdcosim.loading import load_file
from crowdcosim.messages import (
    Crowd,
    Goal,
    Header,
    Odometry,
    Path,
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    RobotState,
    Twist,
)
from crowdcosim.robots import RobotModel

Array = NDArray[np.float64]

NOBODY = np.array([[1e6, 1e6]])
"""a point far away: the functions take the minimum over all points, and of none there is no minimum"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which function, and what of the world it is given."""

    function: str
    """`./file.py:name` of the function"""
    parameters: str = "config"
    """name, in the same file, of the config that it takes: an object, or a class that is called without arguments"""
    reach: float = 10.0
    """obstacles farther away are left out, and a line to cross is aimed at so far beyond [m]"""
    wall_spacing: float = 0.2
    """distance between the points along walls and obstacles [m]"""
    body: float = 0.3
    """radius of a person, added to the robot's [m]"""

    def __post_init__(self) -> None:
        if ".py:" not in self.function:
            raise ValueError(f"function is '{self.function}', expected ./file.py:name")
        for name in ("reach", "wall_spacing"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a positive number")
        if not self.body >= 0:
            raise ValueError(f"body is {self.body}, expected zero or more")


class Decision(NamedTuple):
    """What the function says."""

    twist: Twist
    plan: Path


class PythonRobotics(Controller):
    """Your function behind the interface of a component."""

    def __init__(self, config: Config) -> None:
        """Raises ComponentError if there is no such file, function or config."""
        self._config = config
        file, _, name = config.function.rpartition(":")
        module = load_file(FilePath(file))
        self._control: Callable[..., Any] = _attribute(module, name)
        self._given = _attribute(module, config.parameters)

    def reset(self, setup: Setup) -> None:
        robot, config = setup.own_robot, self._config
        self._own, self._world = robot.name, setup.world
        given = self._given() if isinstance(self._given, type) else copy.deepcopy(self._given)
        self._parameters = _with_limits(given, robot.model, setup.dt, robot.model.radius + config.body)
        self._still = _points_along(setup.world.segments, config.wall_spacing)

    def step(self, odometry: Odometry, goal: Goal, crowd: Crowd, others: tuple[RobotState, ...]) -> Decision:
        """One call of the function. Raises ValueError if it does not return `[v, omega], trajectory`."""
        ego = ego_of(odometry)
        here = np.array([ego.x, ego.y])
        x = np.array([ego.x, ego.y, ego.heading, ego.speed, ego.turn_rate])
        # A line is aimed at from afar: such functions slow down before a point.
        aim = np.array(target(goal, here)) + self._config.reach * goal.direction
        answer = self._control(x, self._parameters, aim, self._obstacles(here, crowd, others))
        try:
            (speed, turn_rate), trajectory = answer
            speed, turn_rate = float(speed), float(turn_rate)
            rows = np.asarray(trajectory, np.float64).reshape(len(trajectory), -1)[:, :3]
        except (TypeError, ValueError):
            raise ValueError(
                f"{self._config.function} returned {str(answer)[:80]}, expected [v, omega] and a trajectory, "
                "whose rows begin with x, y, yaw"
            ) from None
        return Decision(twist=command(speed, turn_rate), plan=_path(rows, odometry.header))

    def _obstacles(self, here: Array, crowd: Crowd, others: tuple[RobotState, ...]) -> Array:
        """(K, 2) points around the robot [m]; people and robots across a seam are given where they are nearest."""
        robots = np.array([r.position for r in others if r.name != self._own], np.float64).reshape(-1, 2)
        moving = self._world.displacement(here, np.concatenate([crowd.position, robots])) + here
        points = np.concatenate([moving, self._still])
        near = points[np.hypot(*(points - here).T) <= self._config.reach]
        return near if len(near) else NOBODY


def _attribute(module: Any, name: str) -> Any:
    try:
        return getattr(module, name)
    except AttributeError:
        raise ComponentError(f"{module.__file__} has no '{name}'") from None


def _with_limits(parameters: Any, model: RobotModel, dt: float, radius: float) -> Any:
    """The config with the robot's limits in those of its fields that PythonRobotics, old or new, calls so."""
    limits = {
        "dt": dt,
        "max_speed": model.max_speed,
        "min_speed": model.min_speed,
        "max_accel": model.max_acceleration,
        "max_yaw_rate": model.max_angular_velocity,
        "max_yawrate": model.max_angular_velocity,
        "max_delta_yaw_rate": model.max_angular_acceleration,
        "max_dyawrate": model.max_angular_acceleration,
        "robot_radius": radius,
    }
    for name, value in limits.items():
        if hasattr(parameters, name):
            setattr(parameters, name, value)
    return parameters


def _points_along(segments: Array, spacing: float) -> Array:
    """(K, 2) points on (W, 2, 2) segments, at most `spacing` apart, both ends included [m]."""
    points = [np.empty((0, 2))]
    for start, end in segments:
        count = math.ceil(math.hypot(*(end - start)) / spacing) + 1
        points.append(np.linspace(start, end, count))
    return np.concatenate(points)


def _path(rows: Array, header: Header) -> Path:
    """The trajectory as a message; it says places, not times."""
    stamp = Header(stamp=header.stamp, frame_id="map")
    poses = [
        Pose(position=Point(x=x, y=y), orientation=Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2)))
        for x, y, yaw in rows.tolist()
    ]
    return Path(header=stamp, poses=tuple([PoseStamped(header=stamp, pose=pose) for pose in poses]))
