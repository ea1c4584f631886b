"""Initial positions: at random without overlap (random sequential addition), or a check of given ones.

Discs that are placed one by one and never moved jam at a share of about 0.547 of the area (Feder 1980, "Random
sequential adsorption"); 0.7 people of radius 0.3 m per square metre take up 0.198.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import into_period, shortest
from components.crowd.walls import WallGrid, Walls, nearby, nearest_of_thing
from crowdcosim.world import World

Array = NDArray[np.float64]

ATTEMPTS = 100_000
"""so many misses in a row, and there is no room"""
TOLERATED = 0.02
"""share of the least distance by which given positions may overlap, since files round"""


@njit(cache=True, nogil=True, error_model="numpy")
def is_free(x: float, y: float, radius: float, robots: Array, walls: WallGrid, solid: Array, period: Array) -> bool:
    """True if a disc at (x, y) touches neither a robot (M, 3: x, y, radius) nor a wall nor an obstacle (`solid`)."""
    for j in range(len(robots)):
        dx, dy = shortest(robots[j, 0] - x, period[0]), shortest(robots[j, 1] - y, period[1])
        if dx * dx + dy * dy < (radius + robots[j, 2]) ** 2:
            return False
    q, end = nearby(walls, x, y)
    while q < end:
        q, cx, cy = nearest_of_thing(walls, q, end, x, y)
        if cx * cx + cy * cy < radius * radius:
            return False
    return not _inside(x, y, solid, period)


@njit(cache=True, nogil=True, error_model="numpy")
def _inside(x: float, y: float, solid: Array, period: Array) -> bool:
    """True if a point is inside an obstacle, or its image across a seam; `solid` as from `solid_edges`."""
    odd = False
    for f in range(len(solid)):
        if f > 0 and solid[f, 6] != solid[f - 1, 6]:
            if odd:
                return True
            odd = False
        px = solid[f, 4] + shortest(x - solid[f, 4], period[0])
        py = solid[f, 5] + shortest(y - solid[f, 5], period[1])
        ax, ay, bx, by = solid[f, 0], solid[f, 1], solid[f, 2], solid[f, 3]
        if (ay > py) != (by > py) and px < ax + (py - ay) / (by - ay) * (bx - ax):
            odd = not odd
    return odd


def solid_edges(world: World) -> Array:
    """(E, 7) the edges of all obstacles: both ends, the middle of the obstacle [m], and its number."""
    rows = []
    for number, outline in enumerate(world.outlines):
        middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
        label = np.broadcast_to([*middle, number], (len(outline), 3))
        rows.append(np.hstack([outline, np.roll(outline, -1, axis=0), label]))
    return np.concatenate([np.empty((0, 7)), *rows])


@njit(cache=True, nogil=True, error_model="numpy")
def _touches_placed(
    x: float,
    y: float,
    radius: float,
    placed: Array,
    radii: Array,
    period: Array,
    head: NDArray[np.int64],
    following: NDArray[np.int64],
    size: Array,
) -> bool:
    """True if a disc at (x, y) overlaps with somebody placed; `head` and `following` chain the people of each cell."""
    columns, rows = head.shape
    column, row = min(int(x / size[0]), columns - 1), min(int(y / size[1]), rows - 1)
    for dc in range(-1, 2):
        for dr in range(-1, 2):
            k, m = column + dc, row + dr
            if period[0] > 0.0:
                k %= columns
            if period[1] > 0.0:
                m %= rows
            if k < 0 or m < 0 or k >= columns or m >= rows:
                continue
            j = head[k, m]
            while j >= 0:
                dx, dy = shortest(placed[j, 0] - x, period[0]), shortest(placed[j, 1] - y, period[1])
                if dx * dx + dy * dy < (radius + radii[j]) ** 2:
                    return True
                j = following[j]
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    candidates: Array,
    placed: Array,
    radii: Array,
    offset: Array,
    first: NDArray[np.int64],
    party: int,
    misses: int,
    patience: int,
    robots: Array,
    walls: WallGrid,
    solid: Array,
    period: Array,
    extent: Array,
    whole: bool,
    head: NDArray[np.int64],
    following: NDArray[np.int64],
    size: Array,
) -> tuple[int, int]:
    """Take candidates (K, 2) in turn until all are placed or `patience` misses came in a row; returns both counts.

    Party p is the people first[p] to first[p + 1], each at an offset from the party's middle;
    `whole` discs are inside the world, not only their centres.
    """
    columns, rows = head.shape
    for c in range(len(candidates)):
        if party == len(first) - 1 or misses >= patience:
            break
        free = True
        for i in range(first[party], first[party + 1]):
            x, y, r = candidates[c, 0] + offset[i, 0], candidates[c, 1] + offset[i, 1], radii[i]
            x = into_period(x, period[0])
            y = into_period(y, period[1])
            placed[i, 0], placed[i, 1] = x, y
            free = free and (not whole or period[0] > 0.0 or r <= x <= extent[0] - r)
            free = free and (not whole or period[1] > 0.0 or r <= y <= extent[1] - r)
            free = free and is_free(x, y, r, robots, walls, solid, period)
            free = free and not _touches_placed(x, y, r, placed, radii, period, head, following, size)
        if not free:
            misses += 1
            continue
        for i in range(first[party], first[party + 1]):
            column = min(int(placed[i, 0] / size[0]), columns - 1)
            row = min(int(placed[i, 1] / size[1]), rows - 1)
            following[i], head[column, row] = head[column, row], i
        party += 1
        misses = 0
    return party, misses


class _Floor:
    """The floor as it fills up."""

    def __init__(
        self, radius: Array, offset: Array, parties: NDArray[np.int64], world: World, robots: Array, *, whole: bool
    ) -> None:
        self.placed = np.empty((len(radius), 2))
        self.party = 0
        self._misses = 0
        self._first = np.concatenate([[0], np.cumsum(parties)])
        self._people = (radius, offset, self._first)
        extent = np.asarray(world.size, np.float64)
        walls = Walls.of(world).within(float(radius.max(initial=0.01)))
        self._scene = (robots, walls, solid_edges(world), world.period, extent, whole)
        # Cells are at least the greatest diameter wide.
        cells = np.maximum((extent / (2 * radius.max(initial=0.01))).astype(int), 1)
        self._chains = (np.full(cells, -1, np.int64), np.full(len(radius), -1, np.int64), extent / cells)

    @property
    def count(self) -> int:
        """How many people are placed."""
        return int(self._first[self.party])

    def add(self, candidates: Array, patience: int) -> bool:
        """Place the parties that fit at the candidates (K, 2); False after `patience` misses in a row."""
        self.party, self._misses = _add(
            candidates, self.placed, *self._people, self.party, self._misses, patience, *self._scene, *self._chains
        )
        return self._misses < patience


def place(
    rng: np.random.Generator,
    radius: Array,
    world: World,
    robots: Array,
    *,
    offset: Array | None = None,
    parties: NDArray[np.int64] | None = None,
    bounds: Array | None = None,
) -> Array:
    """(N, 2) random centres of discs that overlap neither each other, nor robots, nor what stops people [m].

    Args:
        rng: where chance comes from
        radius: (N,) of the discs [m]
        world: its extent, seams and walls; along an axis that does not wrap around the whole disc is inside
        robots: (M, 3) x, y and radius of the robots at their start [m]
        offset: (N, 2) from the middle of the party that somebody belongs to [m]; none
        parties: (P,) how many people, in their order, are placed together; everybody alone
        bounds: (2, 2) lower left and upper right corner of the part of the world that is wanted [m]; all of it

    Raises:
        ValueError: if there is no room.
    """
    count = len(radius)
    offset = np.zeros((count, 2)) if offset is None else offset
    parties = np.ones(count, np.int64) if parties is None else parties
    extent = np.asarray(world.size, np.float64)
    margin = np.where(world.period > 0, 0.0, radius.min(initial=np.inf) if count else 0.0)
    low, high = (np.zeros(2), extent) if bounds is None else bounds
    low, high = np.maximum(low, margin), np.minimum(high, extent - margin)
    floor = _Floor(radius, offset, parties, world, robots, whole=True)
    room = bool((high >= low).all())
    while room and floor.count < count:
        room = floor.add(low + rng.random((1024, 2)) * (high - low), ATTEMPTS)
    if not room:
        size = extent if bounds is None else bounds[1] - bounds[0]
        share = math.pi * (radius**2).sum() / max(float(np.prod(size)), 1e-9)
        raise ValueError(
            f"no room for person {floor.count + 1} of {count} with radius {radius[floor.count]:g} m in "
            f"{'a world' if bounds is None else 'an area'} of {size[0]:g} x {size[1]:g} m: all would take up "
            f"{share:.0%} of it, and random placing stops "
            "at about 55%, less what walls, obstacles and robots take; lower `count` or `radius`, or give `positions`"
        )
    return floor.placed


def check(position: Array, radius: Array, world: World, robots: Array) -> None:
    """Check that given centres (N, 2) of discs (N,) [m] are inside and overlap by no more than files round.

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
    count = len(position)
    floor = _Floor(
        (1.0 - TOLERATED) * radius, np.zeros((count, 2)), np.ones(count, np.int64), world, robots, whole=False
    )
    if floor.add(position, patience=1):
        return
    i = floor.count
    gaps = np.hypot(*world.displacement(position[i], position[:i]).T)
    lacking = radius[i] + radius[:i] - gaps
    if (lacking > TOLERATED * (radius[i] + radius[:i])).any():
        j = int(lacking.argmax())
        what = f"{gaps[j]:.3f} m from positions[{j}], expected at least {radius[i] + radius[j]:g} m"
    else:
        what = (
            f"inside an obstacle, less than {radius[i]:g} m from one or from a wall that stops people, or on a robot's "
            "start: move it or the robot"
        )
    raise ValueError(f"positions[{i}] is {position[i].tolist()}, {what}")
