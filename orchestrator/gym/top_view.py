"""A picture of the episode from above, drawn in a millisecond or two: walls, people, robots and where they look."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from crowdcosim.robots import Robot
from crowdcosim.world import World
from orchestrator.view import View

LONG_SIDE = 1000
"""of the picture [pixels]"""
MARGIN = 8
"""[pixels]"""
_PAPER, _WALL, _PERSON, _NOSE = (250, 250, 248), (60, 60, 66), (116, 143, 178), (40, 62, 98)
_ROBOT, _GOAL = (214, 84, 56), (86, 160, 106)


class TopView:
    """Draws views of one world."""

    def __init__(self, world: World, robots: tuple[Robot, ...]) -> None:
        self._world = world
        self._robots = robots
        self._scale = (LONG_SIDE - 2 * MARGIN) / max(world.size)
        self._size = tuple(round(side * self._scale) + 2 * MARGIN for side in world.size)
        self._ground = self._draw_ground()

    def draw(self, view: View) -> NDArray[np.uint8]:
        """(height, width, 3) the view, x to the right and y up."""
        picture = self._ground.copy()
        pen = ImageDraw.Draw(picture)
        if view.crowd is not None:
            people = zip(
                view.crowd.position.tolist(), view.crowd.radius.tolist(), view.crowd.heading.tolist(), strict=True
            )
            for (x, y), radius, heading in people:
                self._disc(pen, x, y, radius, heading, _PERSON)
        for robot in view.robots.values():
            x, y = robot.state.position.tolist()
            self._disc(pen, x, y, robot.state.radius, robot.state.heading, _ROBOT)
        return np.asarray(picture)

    def _draw_ground(self) -> Image.Image:
        picture = Image.new("RGB", (self._size[0], self._size[1]), _PAPER)
        pen = ImageDraw.Draw(picture)
        for outline in self._world.outlines:
            pen.polygon([self._pixel(x, y) for x, y in outline.tolist()], fill=_WALL)
        for start, end in self._world.segments.tolist():
            pen.line([self._pixel(*start), self._pixel(*end)], fill=_WALL, width=2)
        reach = math.hypot(*self._world.size)
        for goal in (robot.goal for robot in self._robots):
            if goal.direction == (0.0, 0.0):
                pen.ellipse(self._box(goal.x, goal.y, goal.tolerance), outline=_GOAL, width=2)
            else:
                (dx, dy), (x, y) = goal.direction, (goal.x, goal.y)
                ends = [self._pixel(x - dy * side * reach, y + dx * side * reach) for side in (-1, 1)]
                pen.line(ends, fill=_GOAL, width=2)
        return picture

    def _disc(
        self, pen: ImageDraw.ImageDraw, x: float, y: float, radius: float, heading: float, colour: tuple[int, int, int]
    ) -> None:
        pen.ellipse(self._box(x, y, radius), fill=colour)
        tip = (x + radius * math.cos(heading), y + radius * math.sin(heading))
        pen.line([self._pixel(x, y), self._pixel(*tip)], fill=_NOSE, width=2)

    def _box(self, x: float, y: float, radius: float) -> list[tuple[float, float]]:
        return [self._pixel(x - radius, y + radius), self._pixel(x + radius, y - radius)]

    def _pixel(self, x: float, y: float) -> tuple[float, float]:
        return MARGIN + x * self._scale, self._size[1] - MARGIN - y * self._scale
