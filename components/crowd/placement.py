"""Initial positions: at random without overlap (random sequential addition), or a check of given ones.

Discs that are placed one by one and never moved jam at a share of about 0.547 of the area (Feder 1980, "Random
sequential adsorption"); 0.7 people of radius 0.3 m per square metre take up 0.198.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import shortest
from components.crowd.walls import nearest_on_segment, seen_from
from crowdcosim.world import World

Array = NDArray[np.float64]

ATTEMPTS = 100_000
"""so many misses in a row, and there is no room"""
TOLERATED = 0.02
"""share of the least distance by which given positions may overlap, since files round"""


@njit(cache=True, nogil=True, error_model="numpy")
def _is_free(x: float, y: float, radius: float, robots: Array, walls: Array, period: Array) -> bool:
    """True if a disc at (x, y) touches neither a robot (M, 3: x, y, radius) nor a wall."""
    for j in range(len(robots)):
        dx, dy = shortest(robots[j, 0] - x, period[0]), shortest(robots[j, 1] - y, period[1])
        if dx * dx + dy * dy < (radius + robots[j, 2]) ** 2:
            return False
    for j in range(len(walls)):
        ax, ay, bx, by = seen_from(walls[j], x, y, period)
        cx, cy, _ = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
        if cx * cx + cy * cy < radius * radius:
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    candidates: Array,
    placed: Array,
    count: int,
    misses: int,
    patience: int,
    radius: float,
    robots: Array,
    walls: Array,
    period: Array,
    head: NDArray[np.int64],
    following: NDArray[np.int64],
    size: Array,
) -> tuple[int, int]:
    """Take candidates (K, 2) in turn until all are placed or `patience` misses came in a row; returns both counts.

    `head` (columns, rows) and `following` chain the placed people of each cell; cells are at least a diameter wide.
    """
    columns, rows = head.shape
    for c in range(len(candidates)):
        if count == len(placed) or misses >= patience:
            break
        x, y = candidates[c, 0], candidates[c, 1]
        column, row = min(int(x / size[0]), columns - 1), min(int(y / size[1]), rows - 1)
        free = _is_free(x, y, radius, robots, walls, period)
        for dc in range(-1, 2):
            for dr in range(-1, 2):
                k, m = column + dc, row + dr
                if period[0] > 0.0:
                    k %= columns
                if period[1] > 0.0:
                    m %= rows
                if not free or k < 0 or m < 0 or k >= columns or m >= rows:
                    continue
                j = head[k, m]
                while j >= 0:
                    dx, dy = shortest(placed[j, 0] - x, period[0]), shortest(placed[j, 1] - y, period[1])
                    if dx * dx + dy * dy < 4.0 * radius * radius:
                        free = False
                        break
                    j = following[j]
        if free:
            placed[count, 0], placed[count, 1] = x, y
            following[count], head[column, row] = head[column, row], count
            count += 1
            misses = 0
        else:
            misses += 1
    return count, misses


class _Floor:
    """The floor as it fills up."""

    def __init__(self, count: int, radius: float, world: World, robots: Array) -> None:
        self.placed = np.empty((count, 2))
        self.count = 0
        self._misses = 0
        self._scene = (radius, robots, world.segments_for_people, world.period)
        extent = np.asarray(world.size, np.float64)
        cells = np.maximum((extent / (2 * radius)).astype(int), 1)
        self._chains = (np.full(cells, -1, np.int64), np.full(count, -1, np.int64), extent / cells)

    def add(self, candidates: Array, patience: int) -> bool:
        """Place what fits of the candidates (K, 2); False after `patience` misses in a row."""
        self.count, self._misses = _add(
            candidates, self.placed, self.count, self._misses, patience, *self._scene, *self._chains
        )
        return self._misses < patience


def place(rng: np.random.Generator, count: int, radius: float, world: World, robots: Array) -> Array:
    """(count, 2) random centres of discs that overlap neither each other, nor robots, nor walls [m].

    Args:
        rng: where chance comes from
        count: how many
        radius: of everybody [m]
        world: its extent, seams and walls; along an axis that does not wrap around the whole disc is inside
        robots: (M, 3) x, y and radius of the robots at their start [m]

    Raises:
        ValueError: if there is no room.
    """
    extent = np.asarray(world.size, np.float64)
    margin = np.where(world.period > 0, 0.0, radius)
    floor = _Floor(count, radius, world, robots)
    room = bool((extent > 2 * margin).all())
    while room and floor.count < count:
        room = floor.add(margin + rng.random((1024, 2)) * (extent - 2 * margin), ATTEMPTS)
    if not room:
        share = count * math.pi * radius**2 / (world.size[0] * world.size[1])
        raise ValueError(
            f"no room for person {floor.count + 1} of {count} with radius {radius:g} m in a world of "
            f"{world.size[0]:g} x {world.size[1]:g} m: all would take up {share:.0%} of it, and random placing stops "
            "at about 55%, less what walls and robots take; lower `count` or `radius`, or give `positions`"
        )
    return floor.placed


def check(position: Array, radius: float, world: World, robots: Array) -> None:
    """Check that given centres (N, 2) [m] are inside and overlap by no more than files round.

    Raises:
        ValueError: with the index of the first that does not fit.
    """
    extent = np.asarray(world.size)
    # The far edge of a periodic axis is another name of the near one.
    outside = (position < 0) | np.where(world.period > 0, position >= extent, position > extent)
    if outside.any():
        i = int(outside.any(axis=1).argmax())
        raise ValueError(
            f"positions[{i}] is {position[i].tolist()}, expected within the world of {extent[0]:g} x {extent[1]:g} m"
        )
    floor = _Floor(len(position), (1.0 - TOLERATED) * radius, world, robots)
    if floor.add(position, patience=1):
        return
    i = floor.count
    gaps = np.hypot(*world.displacement(position[i], position[:i]).T)
    if (gaps < 2 * (1.0 - TOLERATED) * radius).any():
        what = f"{gaps.min():.3f} m from positions[{gaps.argmin()}], expected at least {2 * radius:g} m"
    else:
        what = f"less than {radius:g} m from a wall that stops people, or on a robot's start: move it or the robot"
    raise ValueError(f"positions[{i}] is {position[i].tolist()}, {what}")
