"""Walls, doors, obstacles and robots as triangles with what their paint needs to know."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.sensors.scan import Cylinders
from crowdcosim.mesh import triangles
from crowdcosim.messages import BeamAgents
from crowdcosim.obstacles import Disc
from crowdcosim.world import Wall, World

Array = NDArray[np.float64]

WALL, DOOR, SIDE, TOP, PILLAR, ROBOT, ROBOT_TOP, MESH = range(8)
"""what a triangle is painted as"""

ROBOT_EDGES = 48
"""a robot is a regular prism, nowhere farther than 0.11% of its radius from the cylinder"""


class Scenery(NamedTuple):
    """Triangles in the map."""

    corner: Array
    """(T, 3, 3) [m]"""
    normal: Array
    """(T, 3) unit vectors"""
    paint: NDArray[np.uint8]
    """(T,) WALL to MESH"""
    kind: NDArray[np.uint8]
    """(T,) as in `BeamAgents`"""
    number: NDArray[np.uint32]
    """(T,) of the wall, obstacle or robot, as in `BeamAgents`"""
    place: Array
    """(T, 6) of what is flat: start (x, y), unit vector along, length, height [m]; of what is round: centre, unit
    vector ahead, radius, height [m]"""


def world_scenery(world: World) -> Scenery:
    """All that stands still in the world.

    Raises:
        ValueError: if its mesh cannot be read.
    """
    parts = []
    for number, wall in enumerate(world.walls, 1):
        parts += _wall(wall, number)
    for number, obstacle in enumerate(world.obstacles, len(world.walls) + 1):
        outline = obstacle.outline
        for edge in np.stack([outline, np.roll(outline, -1, axis=0)], axis=1):
            side = _upright(edge, 0.0, obstacle.height, SIDE, number)
            if isinstance(obstacle, Disc):
                place = np.array([*obstacle.centre, 1.0, 0.0, obstacle.radius, obstacle.height])
                side = side._replace(paint=np.full(2, PILLAR, np.uint8), place=np.tile(place, (2, 1)))
            parts.append(side)
        parts.append(_level(outline, obstacle.height, number))
    if world.mesh:
        number = len(world.walls) + len(world.obstacles) + 1
        parts.append(_scenery(triangles(world.mesh), MESH, BeamAgents.WALL, number, np.zeros(6)))
    return joined(parts)


def robot_scenery(robots: Cylinders, heading: Array, period: Array, size: Array) -> Scenery:
    """Robots, upright cylinders, and their images across a seam that they reach over.

    `heading`: (N,) [rad]; `period` and `size`: (2,) of the map [m], a period of 0 for none.
    """
    parts = []
    for n, number in enumerate(robots.number.tolist()):
        centre, radius, height = robots.centre[n], float(robots.radius[n]), float(robots.height[n])
        shifts = [
            [0.0] + [s * p for s in (-1.0, 1.0) if p > 0 and -radius <= c + s * p <= e + radius]
            for c, p, e in zip(centre, period, size, strict=True)
        ]
        cos, sin = math.cos(heading[n]), math.sin(heading[n])
        for dx in shifts[0]:
            for dy in shifts[1]:
                x, y = float(centre[0]) + dx, float(centre[1]) + dy
                parts.append(_prism(np.array([x, y, cos, sin, radius, height]), number))
    return joined(parts)


def joined(parts: list[Scenery]) -> Scenery:
    """All triangles of several sceneries."""
    if not parts:
        return Scenery(
            np.zeros((0, 3, 3)),
            np.zeros((0, 3)),
            np.zeros(0, np.uint8),
            np.zeros(0, np.uint8),
            np.zeros(0, np.uint32),
            np.zeros((0, 6)),
        )
    return Scenery(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _scenery(corner: Array, paint: int, kind: int, number: int, place: Array) -> Scenery:
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    count = len(corner)
    return Scenery(
        corner,
        normal,
        np.full(count, paint, np.uint8),
        np.full(count, kind, np.uint8),
        np.full(count, number, np.uint32),
        np.tile(place, (count, 1)),
    )


def _wall(wall: Wall, number: int) -> list[Scenery]:
    """A wall as panels between its doors, over them, and the doors."""
    start, end = np.array(wall.start), np.array(wall.end)
    ahead = (end - start) / wall.length if wall.doors else end - start
    parts, free = [], start
    for door in wall.doors:
        left, right = start + (door.at - 0.5 * door.width) * ahead, start + (door.at + 0.5 * door.width) * ahead
        opening = np.array([left, right])
        parts.append(_upright(opening, 0.0, door.height, DOOR, number))
        if door.height < wall.height:
            parts.append(_upright(opening, door.height, wall.height, WALL, number))
        if (left != free).any():
            parts.append(_upright(np.array([free, left]), 0.0, wall.height, WALL, number))
        free = right
    if (free != end).any():
        parts.append(_upright(np.array([free, end]), 0.0, wall.height, WALL, number))
    return parts


def _upright(edge: Array, low: float, high: float, paint: int, number: int) -> Scenery:
    """The rectangle over an edge, (2, 2), between two heights; its front is on the edge's right."""
    (ax, ay), (bx, by) = edge
    length = math.hypot(bx - ax, by - ay)
    a, b, c, d = (ax, ay, low), (bx, by, low), (bx, by, high), (ax, ay, high)
    place = np.array([ax, ay, (bx - ax) / length, (by - ay) / length, length, high])
    return _scenery(np.array([(a, b, c), (a, c, d)], np.float64), paint, BeamAgents.WALL, number, place)


def _level(outline: Array, height: float, number: int) -> Scenery:
    """The top of an obstacle whose corners are (K, 2), counter-clockwise."""
    corner = np.array([[(*outline[i], height) for i in ear] for ear in ears(outline)], np.float64)
    return _scenery(corner, TOP, BeamAgents.WALL, number, np.array([*outline[0], 1.0, 0.0, 1.0, height]))


def ears(outline: Array) -> list[tuple[int, int, int]]:
    """Corners of the triangles that make up a polygon, (K, 2), counter-clockwise, that does not cross itself.

    By clipping ears (Meisters, Polygons have ears, 1975).
    """
    left = list(range(len(outline)))
    found = []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            others = [i for i in left if i not in (a, b, c)]
            if _turn(outline, a, b, c) > 0 and not any(_within(outline, a, b, c, i) for i in others):
                break
        else:  # only corners on a line are left
            k = next(
                k for k in range(len(left)) if _turn(outline, left[k - 1], left[k], left[(k + 1) % len(left)]) == 0
            )
            del left[k]
            continue
        found.append((a, b, c))
        del left[k]
    return [*found, (left[0], left[1], left[2])]


def _turn(outline: Array, a: int, b: int, c: int) -> float:
    """Twice the area of the triangle from a to b to c, positive to the left."""
    u, v = outline[b] - outline[a], outline[c] - outline[a]
    return float(u[0] * v[1] - u[1] * v[0])


def _within(outline: Array, a: int, b: int, c: int, i: int) -> bool:
    return _turn(outline, a, b, i) >= 0 and _turn(outline, b, c, i) >= 0 and _turn(outline, c, a, i) >= 0


def _prism(place: Array, number: int) -> Scenery:
    """A robot's sides, two triangles each, and the fan that is its top."""
    corner = _UNIT_PRISM * (place[4], place[4], place[5]) + (place[0], place[1], 0.0)
    count = len(corner)
    return Scenery(
        corner,
        _PRISM_NORMAL,
        _PRISM_PAINT,
        np.full(count, BeamAgents.ROBOT, np.uint8),
        np.full(count, number, np.uint32),
        np.tile(place, (count, 1)),
    )


def _unit_prism() -> Array:
    """(3 * ROBOT_EDGES, 3, 3) of radius 1 and height 1; its corners are as far outside as its sides are inside."""
    angle = 2.0 * np.pi * np.arange(ROBOT_EDGES + 1) / ROBOT_EDGES
    x, y = 2.0 / (1.0 + math.cos(math.pi / ROBOT_EDGES)) * np.array([np.cos(angle), np.sin(angle)])
    floor, top = np.stack([x, y, 0.0 * x], axis=1), np.stack([x, y, 0.0 * x + 1.0], axis=1)
    middle = np.tile((0.0, 0.0, 1.0), (ROBOT_EDGES, 1))
    fans = [(floor[:-1], floor[1:], top[1:]), (floor[:-1], top[1:], top[:-1]), (middle, top[:-1], top[1:])]
    return np.concatenate([np.stack(fan, axis=1) for fan in fans])


_UNIT_PRISM = _unit_prism()
_PRISM_NORMAL = np.cross(_UNIT_PRISM[:, 1] - _UNIT_PRISM[:, 0], _UNIT_PRISM[:, 2] - _UNIT_PRISM[:, 0])
_PRISM_NORMAL /= np.linalg.norm(_PRISM_NORMAL, axis=1, keepdims=True)
_PRISM_PAINT = np.repeat(np.array([ROBOT, ROBOT, ROBOT_TOP], np.uint8), ROBOT_EDGES)
