"""How soon people collide: exact times of two discs, and of a disc and a straight wall.

Discs at relative position x, at rest relative to it a person who moves at w, with sum of radii R, touch at
    t = (b - sqrt(d)) / |w|^2 = c / (b + sqrt(d)),  b = x . w,  c = |x|^2 - R^2,  d = R^2 |w|^2 - (x cross w)^2
if b > 0 and d >= 0. The rate 1 / t = (b + sqrt(d)) / c needs no division per velocity, loses no digits, and is 0 where
nothing ever touches. A disc touches a wall first at its straight part or at one of its ends.

Discs that overlap already collide at once (rate infinity) at velocities that bring them nearer, and not at others;
or, with `skip`, not at all, for policies that only look ahead.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.surroundings import AX, AY, BX, BY, OX, OY, PX, PY, RADIUS, REACH, Surroundings
from components.crowd.walls import nearest_on_segment

Array = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def raise_to_disc(
    x: float, y: float, u: float, w: float, R: float, cx: Array, cy: Array, skip: bool, rate: Array
) -> None:
    """Raise `rate` (K,) to that of a collision with a disc, for a person who walks at (cx, cy) (K,).

    Args:
        x: position of the disc relative to the person [m]
        y: [m]
        u: velocity of the disc [m/s]
        w: [m/s]
        R: sum of both radii [m]
        cx: velocities of the person [m/s]
        cy: [m/s]
        skip: ignore a disc that overlaps already
        rate: raised where the collision is sooner [1/s]
    """
    c = x * x + y * y - R * R
    if c <= 0.0:
        if not skip:
            for k in range(len(cx)):
                if x * (cx[k] - u) + y * (cy[k] - w) > 0.0:
                    rate[k] = np.inf
        return
    inverse, squared = 1.0 / c, R * R
    for k in range(len(cx)):
        # Choices rather than branches: several velocities at a time.
        wx, wy = cx[k] - u, cy[k] - w
        b = x * wx + y * wy
        across = x * wy - y * wx
        d = squared * (wx * wx + wy * wy) - across * across
        soon = (b + math.sqrt(max(d, 0.0))) * inverse
        soon = soon if (b > 0.0) & (d >= 0.0) else 0.0
        rate[k] = soon if soon > rate[k] else rate[k]


@njit(cache=True, nogil=True, error_model="numpy")
def raise_to_wall(
    ax: float, ay: float, bx: float, by: float, r: float, cx: Array, cy: Array, skip: bool, rate: Array
) -> None:
    """Raise `rate` (K,) to that of a collision with a wall from a to b; arguments as in `raise_to_disc`."""
    px, py, _ = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
    if px * px + py * py <= r * r:
        if not skip:
            for k in range(len(cx)):
                if px * cx[k] + py * cy[k] > 0.0:
                    rate[k] = np.inf
        return
    raise_to_disc(ax, ay, 0.0, 0.0, r, cx, cy, True, rate)
    raise_to_disc(bx, by, 0.0, 0.0, r, cx, cy, True, rate)
    length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    if length == 0.0:
        return
    ux, uy = (bx - ax) / length, (by - ay) / length
    # The normal points to the wall.
    nx, ny = uy, -ux
    gap = nx * ax + ny * ay
    if gap < 0.0:
        nx, ny, gap = -nx, -ny, -gap
    gap -= r
    if gap <= 0.0:
        return
    start = ux * ax + uy * ay
    for k in range(len(cx)):
        towards, along = nx * cx[k] + ny * cy[k], ux * cx[k] + uy * cy[k]
        # Touches at (along t - start) of the wall's length, t = gap / towards.
        place = along * gap - start * towards
        hits = (towards > 0.0) & (place >= 0.0) & (place <= length * towards)
        soon = towards / gap if hits else 0.0
        rate[k] = soon if soon > rate[k] else rate[k]


@njit(cache=True, nogil=True, error_model="numpy")
def raise_to_people(around: Surroundings, i: int, cx: Array, cy: Array, skip: bool, rate: Array) -> None:
    """Raise `rate` (K,) to the first collision of person i with anybody or any robot, at velocities (cx, cy) (K,)."""
    near = around.near
    for p in range(around.first[i], around.first[i + 1]):
        raise_to_disc(near[PX, p], near[PY, p], near[OX, p], near[OY, p], near[REACH, p], cx, cy, skip, rate)


@njit(cache=True, nogil=True, error_model="numpy")
def raise_to_walls(around: Surroundings, i: int, cx: Array, cy: Array, skip: bool, rate: Array) -> None:
    """Raise `rate` (K,) to the first collision of person i with any wall, at velocities (cx, cy) (K,)."""
    edges, r = around.edges, around.own[RADIUS, i]
    for q in range(around.first_edge[i], around.first_edge[i + 1]):
        raise_to_wall(edges[AX, q], edges[AY, q], edges[BX, q], edges[BY, q], r, cx, cy, skip, rate)


@njit(cache=True, nogil=True, error_model="numpy")
def collision_rates(around: Surroundings, i: int, cx: Array, cy: Array, skip: bool, rate: Array) -> None:
    """Set `rate` (K,) to one over the time to person i's first collision at velocities (cx, cy) (K,) [1/s]."""
    rate[:] = 0.0
    raise_to_people(around, i, cx, cy, skip, rate)
    raise_to_walls(around, i, cx, cy, skip, rate)
