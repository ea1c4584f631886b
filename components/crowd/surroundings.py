"""What each of a block of people has around it: its own motion, neighbours, robots and walls, in flat arrays.

Costs are computed for a block of people at a time: few calls from Python, and arrays that stay in the processor's
cache however large the crowd is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import Cells, gather, shortest
from components.crowd.scene import Scene
from components.crowd.walls import WallGrid, nearby, nearest_on_segment

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

VX, VY, GX, GY, RADIUS, MAX_SPEED, MAX_ACCELERATION = range(7)
"""rows of `own`: velocity, preferred velocity [m/s], radius [m], greatest speed [m/s] and acceleration [m/s2]"""
PX, PY, OX, OY, REACH = range(5)
"""rows of `near`: position relative to the person [m], velocity [m/s], sum of both radii [m]"""
AX, AY, BX, BY, THING = range(5)
"""rows of `edges`: both ends relative to the person [m], number of the wall or obstacle"""


class Surroundings(NamedTuple):
    """A block of B people, who have P neighbours and Q walls in range together."""

    own: Array
    """(7, B) rows VX, VY, GX, GY, RADIUS, MAX_SPEED, MAX_ACCELERATION"""
    first: Indices
    """(B + 1,) person i has the neighbours first[i] to first[i + 1], robots among them"""
    near: Array
    """(5, at least P) rows PX, PY, OX, OY, REACH"""
    first_edge: Indices
    """(B + 1,) person i has the walls first_edge[i] to first_edge[i + 1]"""
    edges: Array
    """(5, at least Q) rows AX, AY, BX, BY, THING; edges of one obstacle follow each other"""
    stream: NDArray[np.uint64]
    """(B,) where everybody's random numbers of this step begin"""
    relaxation_time: float
    """in which people take on the velocity they want, at least the time step [s]"""
    dt: float
    """time step [s]"""


class Surveyor:
    """Collects the surroundings of people; its buffers grow to what is needed and are used again."""

    def __init__(self, *, reach: float, relaxation_time: float) -> None:
        self._reach = reach
        self._relaxation_time = relaxation_time
        self._near = np.empty((5, 4104))
        self._edges = np.empty((5, 256))

    def surroundings(self, scene: Scene, cells: Cells, others: Array, places: Indices) -> Surroundings:
        """The surroundings of those at some places of the cells' order; valid until the next call.

        Args:
            scene: the old state
            cells: of everybody in it
            others: (3, N) what `in_order` makes of them
            places: (B,) places of the order
        """
        while True:
            own, first, first_edge, stream = _survey(
                cells,
                others,
                places,
                scene.preferred,
                scene.max_speed,
                scene.max_acceleration,
                scene.stream,
                scene.robots,
                scene.walls.within(self._reach),
                self._reach,
                self._near,
                self._edges,
            )
            if first[-1] <= self._near.shape[1] and first_edge[-1] <= self._edges.shape[1]:
                break
            # The counts are right even where there was no room; one more round with room to spare.
            self._near = np.empty((5, max(2 * int(first[-1]), self._near.shape[1])))
            self._edges = np.empty((5, max(2 * int(first_edge[-1]), self._edges.shape[1])))
        return Surroundings(
            own,
            first,
            self._near,
            first_edge,
            self._edges,
            stream,
            max(self._relaxation_time, scene.dt),
            scene.dt,
        )


@njit(cache=True, nogil=True, error_model="numpy")
def in_order(cells: Cells, velocity: Array, radius: Array) -> Array:
    """(3, N) velocities in x and y [m/s] and radii [m] in the cells' order, so that neighbours are near in memory."""
    n = len(radius)
    others = np.empty((3, n))
    for k in range(n):
        i = cells.order[k]
        others[0, k], others[1, k], others[2, k] = velocity[i, 0], velocity[i, 1], radius[i]
    return others


@njit(cache=True, nogil=True, error_model="numpy")
def _survey(
    cells: Cells,
    others: Array,
    places: Indices,
    preferred: Array,
    max_speed: Array,
    max_acceleration: Array,
    streams: NDArray[np.uint64],
    robots: Array,
    walls: WallGrid,
    reach: float,
    near: Array,
    edges: Array,
) -> tuple[Array, Indices, Indices, NDArray[np.uint64]]:
    """Fill `near` and `edges` as far as there is room; the counts returned are those that are needed."""
    n, b = len(cells.order), len(places)
    # Taken out once: numba counts references at every access to a field or a row.
    order, xs, ys = cells.order, cells.x, cells.y
    px, py, ox, oy, R = near[PX], near[PY], near[OX], near[OY], near[REACH]
    us, vs, radii = others[0], others[1], others[2]
    period = np.array((cells.period_x, cells.period_y))
    found, dx, dy = np.empty(n + 1, np.int64), np.empty(n + 1), np.empty(n + 1)
    own, stream = np.empty((7, b)), np.empty(b, np.uint64)
    first, first_edge = np.zeros(b + 1, np.int64), np.zeros(b + 1, np.int64)
    for t in range(b):
        k = places[t]
        i = order[k]
        x, y, r = xs[k], ys[k], radii[k]
        own[VX, t], own[VY, t] = us[k], vs[k]
        own[GX, t], own[GY, t] = preferred[i, 0], preferred[i, 1]
        own[RADIUS, t] = r
        own[MAX_SPEED, t], own[MAX_ACCELERATION, t] = max_speed[i], max_acceleration[i]
        stream[t] = streams[i]
        p = first[t]
        count = gather(cells, k, 0, reach, found, dx, dy)
        if p + count + len(robots) > near.shape[1]:
            first[t + 1] = p + count + len(robots)
        else:
            # Row by row, which is quicker than neighbour by neighbour.
            for f in range(count):
                px[p + f] = dx[f]
            for f in range(count):
                py[p + f] = dy[f]
            for f in range(count):
                ox[p + f] = us[found[f]]
            for f in range(count):
                oy[p + f] = vs[found[f]]
            for f in range(count):
                R[p + f] = r + radii[found[f]]
            p += count
            for f in range(len(robots)):
                rx, ry = shortest(robots[f, 0] - x, period[0]), shortest(robots[f, 1] - y, period[1])
                if rx * rx + ry * ry <= reach * reach:
                    px[p], py[p], ox[p], oy[p], R[p] = rx, ry, robots[f, 2], robots[f, 3], r + robots[f, 4]
                    p += 1
            first[t + 1] = p
        q = first_edge[t]
        begin, end = nearby(walls, x, y)
        for f in walls.listed[begin:end]:
            ax, ay, bx, by = walls.ends[f, 0] - x, walls.ends[f, 1] - y, walls.ends[f, 2] - x, walls.ends[f, 3] - y
            cx, cy, _ = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
            if cx * cx + cy * cy <= reach * reach:
                if q < edges.shape[1]:
                    edges[AX, q], edges[AY, q], edges[BX, q], edges[BY, q] = ax, ay, bx, by
                    edges[THING, q] = walls.thing[f]
                q += 1
        first_edge[t + 1] = q
    return own, first, first_edge, stream


@njit(cache=True, nogil=True, error_model="numpy")
def facing(own: Array, i: int, slow: float) -> tuple[float, float, float]:
    """Unit vector of person i's way, and the speed; at less than `slow` [m/s] those of the preferred velocity.

    Whoever wants to stand, too, faces x.
    """
    x, y = own[VX, i], own[VY, i]
    speed = math.sqrt(x * x + y * y)
    if speed <= slow:
        x, y = own[GX, i], own[GY, i]
        speed = math.sqrt(x * x + y * y)
    return (x / speed, y / speed, speed) if speed > 0.0 else (1.0, 0.0, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_of_thing(edges: Array, q: int, end: int) -> tuple[int, float, float]:
    """Of the wall or obstacle that `edges` go on with at `q`: where the next one begins, at most `end`, and the way to
    its nearest point [m]."""
    thing = edges[THING, q]
    nearest, nx, ny = np.inf, 0.0, 0.0
    while q < end and edges[THING, q] == thing:
        px, py, _ = nearest_on_segment(edges[AX, q], edges[AY, q], edges[BX, q], edges[BY, q], 0.0, 0.0)
        squared = px * px + py * py
        if squared < nearest:
            nearest, nx, ny = squared, px, py
        q += 1
    return q, nx, ny
