"""Pictures of a recorded episode: its states at any time, between ticks too, seen by a camera."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from components.sensors.rendering.picture import Renderer
from components.sensors.rendering.view import View
from components.sensors.scan import Cylinders
from components.sensors.surroundings import people_of
from crowdcosim.messages import Crowd, RobotState
from crowdcosim.world import Wall, World
from orchestrator.errors import InputError
from orchestrator.log.reader import Log
from orchestrator.pictures.cameras import Camera, Onboard, subject, view_at
from orchestrator.scenario.scenario import Scenario, from_resolved

Picture = NDArray[np.uint8]
"""(H, W, 3) red, green and blue"""

NANO = 1_000_000_000


class Film:
    """An episode from its log."""

    def __init__(self, log: Log) -> None:
        """Read where people and robots were.

        Raises:
            InputError: if the log holds neither.
        """
        self.scenario: Scenario = from_resolved(log.scenario())
        self._robots = self.scenario.robots
        self._crowds: list[tuple[int, Crowd]] = list(log.outputs("crowd", "crowd"))
        self._states: dict[str, list[tuple[int, RobotState]]] = {
            robot.name: list(log.outputs(robot.name, "state")) for robot in self._robots
        }
        times = [states[-1][0] for states in self._states.values() if states]
        times += [self._crowds[-1][0]] if self._crowds else []
        if not times:
            raise InputError(f"{log.path} holds neither people nor robots")
        self.end = max(times) * 1e-9
        """time of the last state [s]"""
        self._renderers: dict[World, Renderer] = {}

    def pictures(self, camera: Camera, times: list[float], width: int, height: int) -> Iterator[Picture]:
        """What a camera sees at each of `times` [s], `width` x `height` pixels.

        Raises:
            InputError: if the camera's robot or mount does not exist.
        """
        robot = subject(camera, self._robots)
        for time in times:
            states = {name: _robot_at(states, round(time * NANO)) for name, states in self._states.items() if states}
            try:
                view = view_at(
                    camera, self.scenario.world, robot, states.get(robot.name) if robot else None, width, height
                )
            except ValueError as error:
                raise InputError(str(error)) from None
            own = robot.name if robot and isinstance(camera, Onboard) else None
            yield self._picture(view, time, [s for name, s in states.items() if name != own])

    def _picture(self, view: View, time: float, states: list[RobotState]) -> Picture:
        world = _cut_open(self.scenario.world, view)
        if world not in self._renderers:
            try:
                self._renderers[world] = Renderer(world)
            except ValueError as error:  # its mesh is on another machine, or gone
                raise InputError(f"world.mesh: {error}") from None
        models = {robot.name: robot for robot in self._robots}
        robots = Cylinders(
            np.array([models[s.name].number for s in states], np.uint32),
            np.array([s.position for s in states], np.float64).reshape(-1, 2),
            np.array([s.radius for s in states], np.float64),
            np.array([models[s.name].model.height for s in states], np.float64),
        )
        heading = np.array([s.heading for s in states], np.float64)
        crowd = _crowd_at(self._crowds, round(time * NANO), self.scenario.world)
        inside = world is self.scenario.world and view.position[2] < min((w.height for w in world.walls), default=9.0)
        picture = self._renderers[world].picture(view, people_of(crowd), robots, heading, images=inside)
        assert picture.colour is not None
        return picture.colour


def _cut_open(world: World, view: View) -> World:
    """The world without those walls along its edges that a camera outside would look at from behind."""
    x, y, _ = view.position.tolist()
    (width, depth), walls = world.size, world.walls
    outside = {0: (x < 0.0, 0.0), 1: (x > width, width), 2: (y < 0.0, 0.0), 3: (y > depth, depth)}

    def hides(wall: Wall) -> bool:
        return any(
            beyond and wall.start[side // 2] == wall.end[side // 2] == edge for side, (beyond, edge) in outside.items()
        )

    kept = tuple(wall for wall in walls if not hides(wall))
    return world if len(kept) == len(walls) else replace(world, walls=kept)


def _around(times: list[int], time: int) -> tuple[int, int, float]:
    """Which states are before and after a time, and the share of the way from one to the other."""
    after = min(bisect_right(times, time), len(times) - 1)
    before = max(after - 1, 0)
    span = times[after] - times[before]
    share = min(max((time - times[before]) / span, 0.0), 1.0) if span else 0.0
    return before, after, share


def _robot_at(states: list[tuple[int, RobotState]], time: int) -> RobotState:
    before, after, share = _around([t for t, _ in states], time)
    a, b = states[before][1], states[after][1]
    turn = math.remainder(b.heading - a.heading, 2.0 * math.pi)
    position = a.position + share * (b.position - a.position)
    return replace(a, position=position, heading=a.heading + share * turn)


def _crowd_at(crowds: list[tuple[int, Crowd]], time: int, world: World) -> Crowd:
    if not crowds:
        return Crowd()
    before, after, share = _around([t for t, _ in crowds], time)
    a, b = crowds[before][1], crowds[after][1]
    if not np.array_equal(a.id, b.id):
        return a if share < 0.5 else b
    turn = np.remainder(b.heading - a.heading + np.pi, 2.0 * np.pi) - np.pi
    stride = np.remainder(b.gait_phase - a.gait_phase + 0.5, 1.0) - 0.5
    return replace(
        a,
        position=world.wrap(a.position + share * world.displacement(a.position, b.position)),
        velocity=a.velocity + share * (b.velocity - a.velocity),
        heading=a.heading + share * turn,
        gait_phase=a.gait_phase + share * stride,
        gait_speed=a.gait_speed + share * (b.gait_speed - a.gait_speed),
    )
