"""What a robot can run into during one step: walls, and people and other robots that keep their velocity (pymunk)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import pymunk

from crowdcosim.messages import Contacts
from crowdcosim.world import World

ROBOT = 2
"""pymunk's category of the robot's own shape, where it has one in the space"""

# One group for all: people and walls pass each other here, only the robot and its queries meet them.
_TOGETHER = pymunk.ShapeFilter(group=1)
_PASSED = pymunk.ShapeFilter(group=1, mask=pymunk.ShapeFilter.ALL_MASKS() ^ ROBOT)
_ANYTHING = pymunk.ShapeFilter(mask=pymunk.ShapeFilter.ALL_MASKS() ^ ROBOT)

# How far bodies may stay within each other [m]: little, but more than rounding.
_SLOP = 1e-4


@dataclass(slots=True, kw_only=True)
class Obstacle:
    """Something that a robot can touch."""

    kind: int
    """Contacts.WALL, PERSON or ROBOT"""
    agent: int
    """a person's id, a robot's number or a wall's, from 1"""
    body_part: int = Contacts.NO_PART
    """the part that a robot of this height touches"""
    reflected_mass: float = 0.0
    """[kg], 0 for a wall"""
    x: float = 0.0
    """centre at the start of the step, in the image next to the robot [m]; without meaning for a wall"""
    y: float = 0.0
    """[m]"""
    vx: float = 0.0
    """velocity [m/s]"""
    vy: float = 0.0
    """[m/s]"""
    radius: float = 0.0
    """[m]"""


class Near(NamedTuple):
    """An obstacle seen from a point."""

    obstacle: Obstacle
    distance: float
    """from the point to the obstacle's surface, negative inside it [m]"""
    nx: float
    """unit vector from the point to the obstacle's centre, or to the nearest point of a wall"""
    ny: float


class _Disc(NamedTuple):
    body: pymunk.Body
    shape: pymunk.Circle


class Surroundings:
    """A pymunk space with the world's walls, and a disc for every obstacle that is near during this step."""

    def __init__(self, world: World, *, movable: bool = False) -> None:
        """With `movable`, people and robots have their masses and yield to a robot that is put into the space."""
        self._space = pymunk.Space()
        self._space.collision_slop = _SLOP
        self._body_type = pymunk.Body.DYNAMIC if movable else pymunk.Body.KINEMATIC
        self._discs: list[_Disc] = []
        self._obstacle_of: dict[pymunk.Shape, Obstacle] = {}
        self._fastest = 0.0
        self._count = 0
        for number, (start, end) in zip(world.segment_numbers.tolist(), world.segments.tolist(), strict=True):
            segment = pymunk.Segment(self._space.static_body, start, end, radius=0.0)
            segment.filter = _TOGETHER
            self._space.add(segment)
            self._obstacle_of[segment] = Obstacle(kind=Contacts.WALL, agent=number)

    @property
    def space(self) -> pymunk.Space:
        """Where a robot with a body of its own belongs."""
        return self._space

    def place(self, obstacles: Sequence[Obstacle]) -> None:
        """Let these people and robots, and no others, be around from now on."""
        self._resize(len(obstacles))
        self._fastest = 0.0
        for (body, shape), obstacle in zip(self._discs, obstacles, strict=False):
            body.position = (obstacle.x, obstacle.y)
            body.velocity = (obstacle.vx, obstacle.vy)
            if self._body_type == pymunk.Body.DYNAMIC:
                body.mass = obstacle.reflected_mass
            shape.filter = _TOGETHER
            shape.unsafe_set_radius(obstacle.radius)
            self._space.reindex_shape(shape)
            self._obstacle_of[shape] = obstacle
            self._fastest = max(self._fastest, math.hypot(obstacle.vx, obstacle.vy))

    def near(self, x: float, y: float, distance: float, h: float) -> list[Near]:
        """All whose surface is, or may be within `h` [s], at most `distance` [m] from the point (x, y) [m]."""
        found = self._space.point_query((x, y), distance + self._fastest * h, _ANYTHING)
        return [Near(self._obstacle_of[hit.shape], hit.distance, -hit.gradient.x, -hit.gradient.y) for hit in found]

    def advance(self, h: float) -> None:
        """Let `h` [s] pass: everybody goes on at constant velocity."""
        self._space.step(h)

    def shrink(self, x: float, y: float, radius: float) -> None:
        """Let those who overlap with a robot of `radius` at (x, y) [m] touch it, or pass if it is over their centre."""
        for body, shape in self._discs[: self._count]:
            free = math.hypot(body.position.x - x, body.position.y - y) - radius
            if free <= 0.0:
                shape.filter = _PASSED
            elif free < shape.radius:
                shape.unsafe_set_radius(free)

    def update(self) -> None:
        """Tell every obstacle the velocity that its body has now."""
        for body, shape in self._discs[: self._count]:
            obstacle = self._obstacle_of[shape]
            obstacle.vx, obstacle.vy = body.velocity

    def halt(self, obstacle: Obstacle, after: float) -> None:
        """Let `obstacle`, a robot, stop for good `after` [s] from now."""
        body = next(body for body, shape in self._discs if self._obstacle_of[shape] is obstacle)
        body.position += pymunk.Vec2d(obstacle.vx, obstacle.vy) * after
        body.velocity = (0.0, 0.0)
        obstacle.vx = obstacle.vy = 0.0

    def _resize(self, count: int) -> None:
        """Have `count` discs in the space; the rest are kept aside, for adding is cheaper than making."""
        while len(self._discs) < count:
            body = pymunk.Body(mass=1.0, moment=math.inf, body_type=self._body_type)
            shape = pymunk.Circle(body, radius=0.0)
            shape.filter = _TOGETHER
            self._discs.append(_Disc(body, shape))
        for disc in self._discs[self._count : count]:
            self._space.add(*disc)
        for disc in self._discs[count : self._count]:
            self._space.remove(*disc)
        self._count = count
