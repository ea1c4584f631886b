"""Cameras that look at an episode from outside, or from a robot: what a scenario says of them, and where they are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field

from components.sensors.rendering.view import View, view_of
from crowdcosim.messages import RobotState
from crowdcosim.robots import Mount, Robot
from crowdcosim.world import World
from orchestrator.errors import InputError
from orchestrator.scenario.problems import near_miss

Angle = Annotated[float, Field(gt=0.0, lt=math.pi)]
Positive = Annotated[float, Field(gt=0.0)]
Point = tuple[float, float, float]

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True, kw_only=True)
class Fixed:
    """Stands still and looks at a point."""

    __pydantic_config__ = _STRICT

    view: Literal["fixed"]
    position: Point | None = None
    """in the map; left out: outside of the world and above, from where all of it is seen [m]"""
    target: Point | None = None
    """what it looks at; left out: the middle of the world [m]"""
    field_of_view: Angle = 0.9
    """from left to right [rad]"""


@dataclass(frozen=True, kw_only=True)
class Following:
    """Keeps behind and above a robot and looks over it."""

    __pydantic_config__ = _STRICT

    view: Literal["following"]
    robot: str | None = None
    """which; left out: the first"""
    distance: Positive = 4.0
    """behind it [m]"""
    height: Positive = 2.8
    """above the floor [m]"""
    yaw: float = 0.0
    """around it, counter-clockwise from behind [rad]"""
    ahead: float = 2.0
    """of the robot is the point of the floor that it looks at [m]"""
    field_of_view: Angle = 1.2
    """from left to right [rad]"""


@dataclass(frozen=True, kw_only=True)
class TopDown:
    """Looks straight down, with the map's x to the right: at the whole world or at the surroundings of a robot."""

    __pydantic_config__ = _STRICT

    view: Literal["top_down"]
    robot: str | None = None
    """which it stays above; left out: the whole world"""
    width: Positive = 20.0
    """of the floor that is seen around the robot [m]"""


@dataclass(frozen=True, kw_only=True)
class Onboard:
    """What a robot sees."""

    __pydantic_config__ = _STRICT

    view: Literal["robot"]
    robot: str | None = None
    """which; left out: the first"""
    mount: str | Mount | None = None
    """a mount of its by name, or a place; left out: its mount `camera` if it has one, else its top"""
    field_of_view: Angle = 1.2
    """from left to right [rad]"""


Camera = Annotated[Fixed | Following | TopDown | Onboard, Field(discriminator="view")]

DEFAULT_CAMERAS: dict[str, Fixed | Following | TopDown | Onboard] = {
    "fixed": Fixed(view="fixed"),
    "following": Following(view="following"),
    "top_down": TopDown(view="top_down"),
    "robot": Onboard(view="robot"),
}
"""those that every scenario has"""

_NARROW = 0.12
"""field of view of a camera that looks straight down: from far above, people hardly lean outwards [rad]"""


def named(cameras: Mapping[str, Camera], name: str) -> Camera:
    """The camera of a scenario, or of every scenario, of that name.

    Raises:
        InputError: if there is none.
    """
    known = DEFAULT_CAMERAS | dict(cameras)
    if name not in known:
        raise InputError(f"there is no camera '{name}'{near_miss(name, known)}; cameras: {', '.join(known)}")
    return known[name]


def subject(camera: Camera, robots: tuple[Robot, ...]) -> Robot | None:
    """The robot that a camera belongs to, None if to none.

    Raises:
        InputError: if there is no such robot.
    """
    if isinstance(camera, Fixed) or (isinstance(camera, TopDown) and camera.robot is None):
        return None
    if camera.robot is None and robots:
        return robots[0]
    for robot in robots:
        if robot.name == camera.robot:
            return robot
    if not robots:
        raise InputError(f"a camera with the view '{camera.view}' needs a robot, and the scenario has none")
    names = [robot.name for robot in robots]
    raise InputError(f"there is no robot '{camera.robot}'{near_miss(camera.robot, names)}; robots: {', '.join(names)}")


def view_at(
    camera: Camera, world: World, robot: Robot | None, state: RobotState | None, width: int, height: int
) -> View:
    """The view of a camera whose robot is in that state; `width` and `height` [pixels]."""
    x = y = heading = 0.0
    if state is not None:
        (x, y), heading = state.position.tolist(), state.heading
    match camera:
        case Fixed():
            return _fixed(camera, world, width, height)
        case Following():
            behind = heading + math.pi + camera.yaw
            place = (x + camera.distance * math.cos(behind), y + camera.distance * math.sin(behind), camera.height)
            target = (x + camera.ahead * math.cos(heading), y + camera.ahead * math.sin(heading), 0.6)
            return _towards(place, target, width, height, camera.field_of_view)
        case TopDown():
            return _from_above(camera, world, x, y, width, height)
        case Onboard():
            assert robot is not None
            mount = _mount(camera, robot)
            ahead, left, up = mount.position
            cos, sin = math.cos(heading), math.sin(heading)
            place = (x + cos * ahead - sin * left, y + sin * ahead + cos * left, up)
            return view_of(place, heading + mount.yaw, mount.pitch, width, height, camera.field_of_view)


def _fixed(camera: Fixed, world: World, width: int, height: int) -> View:
    length, depth = world.size
    target = camera.target or (0.5 * length, 0.5 * depth, 0.0)
    # The edge nearest to it is nearer by 0.8 of half the depth, and must fit too.
    away = 0.5 * max(length, depth * width / height) / math.tan(0.5 * camera.field_of_view) + 0.4 * depth
    place = camera.position or (0.5 * length, 0.5 * depth - 0.8 * away, 0.6 * away)
    return _towards(place, target, width, height, camera.field_of_view)


def _from_above(camera: TopDown, world: World, x: float, y: float, width: int, height: int) -> View:
    if camera.robot is None:
        x, y = 0.5 * world.size[0], 0.5 * world.size[1]
        wide = 1.05 * max(world.size[0], world.size[1] * width / height)
    else:
        wide = camera.width
    up = 0.5 * wide / math.tan(0.5 * _NARROW)
    # Straight down, the picture's top is where it looked before it nodded: along the map's y.
    return view_of((x, y, up), 0.5 * math.pi, 0.5 * math.pi, width, height, _NARROW)


def _towards(place: Point, target: Point, width: int, height: int, field_of_view: float) -> View:
    dx, dy, dz = np.subtract(target, place).tolist()
    pitch = math.atan2(-dz, math.hypot(dx, dy))
    return view_of(place, math.atan2(dy, dx), pitch, width, height, field_of_view)


def _mount(camera: Onboard, robot: Robot) -> Mount:
    if camera.mount is not None:
        return robot.model.mount(camera.mount)
    return robot.model.mounts.get("camera") or Mount(position=(0.0, 0.0, robot.model.height))
