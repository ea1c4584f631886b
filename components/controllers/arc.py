"""How far a disc can drive along a circular arc before it touches discs and walls, in closed form.

The robot's centre, at the origin and facing x, moves along the arc of curvature k. With w = tan(k s / 2) / k it is at

    x = 2 w / (1 + k^2 w^2),  y = 2 k w^2 / (1 + k^2 w^2)   after the length s = 2 atan(k w) / k,

which holds for a straight line too (k = 0, w = s / 2). Contact with a disc at p, when the centres are S apart, and the
crossing of a line n . q = h are therefore quadratic equations in w, well conditioned for any curvature:

    (4 - 4 k p_y + k^2 c) w^2 - 4 p_x w + c = 0,  c = |p|^2 - S^2
    (2 k n_y - k^2 h) w^2 + 2 n_x w - h = 0

A wall is the set of points nearer than S to a segment: two discs and two parallel lines. The lengths s > 0 come in the
order w = 0 ... infinity, -infinity ... 0, so that roots can be compared before the one arc tangent is taken.
A robot that is already nearer than S counts as touching: it may leave, slide along or turn away, but come no nearer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.ego import Ego
from components.controllers.surroundings import Discs, nearest_image, nearest_on_segment

Array = NDArray[np.float64]

TOUCHING = 1e-9
"""gap of two bodies that touch: above rounding, so that leaving and coming nearer are told apart [m]"""


class Obstacles(NamedTuple):
    """What the robot may touch, in its own frame (x forward, y left)."""

    discs: Array
    """(M, 3) centre [m], and c = |p|^2 - S^2 [m2]"""
    lines: Array
    """(K, 5) normal n, offset h [m], and the range of the coordinate along (-n_y, n_x) in which the line counts [m]"""
    nearest_y: float
    """y of the nearest point of all obstacles [m], NaN if there are none"""


@njit(cache=True, nogil=True, error_model="numpy")
def obstacles_near(ego: Ego, discs: Discs, walls: Array, period: Array, body: float, reach: float) -> Obstacles:
    """What a robot may touch within the arc length `reach` [m].

    Args:
        ego: the robot's pose.
        discs: people, seen across the seam, and other robots, which are not.
        walls: (W, 2, 2) both ends of every wall [m].
        period: (2,) period of each axis, 0 for none [m].
        body: radius of the robot, margin included [m].
        reach: longest arc of interest [m].
    """
    rows = np.empty((len(discs.radius) + 2 * len(walls), 3))
    m, gap, y = _put_discs(ego, discs, period, body, reach, rows)
    lines = np.empty((2 * len(walls), 5))
    m, k, wall_gap, wall_y = _put_walls(ego, walls, body, reach, rows, m, lines)
    return Obstacles(rows[:m], lines[:k], wall_y if wall_gap < gap else y)


@njit(cache=True, nogil=True, error_model="numpy")
def _put_discs(
    ego: Ego, discs: Discs, period: Array, body: float, reach: float, rows: Array
) -> tuple[int, float, float]:
    """Write the discs within reach into `rows`; their number, and gap and y of the nearest [m]."""
    m, nearest_gap, nearest_y = 0, np.inf, np.nan
    cos, sin = math.cos(ego.heading), math.sin(ego.heading)
    for i in range(len(discs.radius)):
        dx, dy = discs.position[i, 0] - ego.x, discs.position[i, 1] - ego.y
        if i < discs.people:
            dx, dy = nearest_image(dx, period[0]), nearest_image(dy, period[1])
        contact = body + discs.radius[i]
        distance = math.hypot(dx, dy)
        if distance > reach + contact:
            continue
        px, py = cos * dx + sin * dy, cos * dy - sin * dx
        if distance - contact < nearest_gap:
            nearest_gap, nearest_y = distance - contact, py
        _put_disc(rows, m, px, py, contact_distance(contact, distance))
        m += 1
    return m, nearest_gap, nearest_y


@njit(cache=True, nogil=True, error_model="numpy")
def _put_walls(
    ego: Ego, walls: Array, body: float, reach: float, rows: Array, m: int, lines: Array
) -> tuple[int, int, float, float]:
    """Write the walls within reach into `rows`, from row m, and `lines`; rows of both, gap and y of the nearest."""
    k, nearest_gap, nearest_y = 0, np.inf, np.nan
    cos, sin = math.cos(ego.heading), math.sin(ego.heading)
    for i in range(len(walls)):
        dx, dy = walls[i, 0, 0] - ego.x, walls[i, 0, 1] - ego.y
        ax, ay = cos * dx + sin * dy, cos * dy - sin * dx
        dx, dy = walls[i, 1, 0] - ego.x, walls[i, 1, 1] - ego.y
        bx, by = cos * dx + sin * dy, cos * dy - sin * dx
        qx, qy = nearest_on_segment(ax, ay, bx, by)
        distance = math.hypot(qx, qy)
        if distance > reach + body:
            continue
        if distance - body < nearest_gap:
            nearest_gap, nearest_y = distance - body, qy
        contact = contact_distance(body, distance)
        _put_disc(rows, m, ax, ay, contact)
        _put_disc(rows, m + 1, bx, by, contact)
        m += 2
        length = math.hypot(bx - ax, by - ay)
        if length > 0.0:
            # (-ny, nx) points from a to b.
            nx, ny = (by - ay) / length, (ax - bx) / length
            offset, start = nx * ax + ny * ay, nx * ay - ny * ax
            for side in (-contact, contact):
                lines[k, 0], lines[k, 1], lines[k, 2] = nx, ny, offset + side
                lines[k, 3], lines[k, 4] = start, start + length
                k += 1
    return m, k, nearest_gap, nearest_y


@njit(cache=True, nogil=True, error_model="numpy")
def contact_distance(contact: float, distance: float) -> float:
    """S: how near the centre may come, which is no nearer than it already is [m]."""
    return max(0.0, min(contact, distance - TOUCHING))


@njit(cache=True, nogil=True, error_model="numpy")
def _put_disc(rows: Array, row: int, x: float, y: float, contact: float) -> None:
    distance = math.hypot(x, y)
    rows[row, 0], rows[row, 1], rows[row, 2] = x, y, (distance - contact) * (distance + contact)


@njit(cache=True, nogil=True, error_model="numpy")
def clearance(curvature: float, obstacles: Obstacles) -> float:
    """Length of the arc of a curvature [1/m], positive to the left, up to the first contact [m]; infinite if none."""
    discs, lines = obstacles.discs, obstacles.lines
    # Smallest positive root, and most negative one: contacts of the first and of the second half turn.
    first, second = np.inf, 0.0
    for i in range(len(discs)):
        px, c = discs[i, 0], discs[i, 2]
        a = 4.0 * (1.0 - curvature * discs[i, 1]) + curvature * curvature * c
        discriminant = 4.0 * px * px - a * c
        if discriminant < 0.0:
            continue
        if px > 0.0 or a < 0.0:
            first = min(first, c / (2.0 * px + math.sqrt(discriminant)))
        else:
            second = min(second, (2.0 * px - math.sqrt(discriminant)) / a)
    for i in range(len(lines)):
        nx, ny, h = lines[i, 0], lines[i, 1], lines[i, 2]
        a = 2.0 * curvature * ny - curvature * curvature * h
        discriminant = nx * nx + a * h
        if discriminant < 0.0:
            continue
        q = -(nx + math.copysign(math.sqrt(discriminant), nx))
        for w in (q / a, -h / q):
            # Infinite or undefined roots belong to lines parallel to the way.
            scale = 2.0 * w / (1.0 + curvature * curvature * w * w)
            along = scale * (curvature * w * nx - ny)
            if lines[i, 3] <= along <= lines[i, 4]:
                if w > 0.0:
                    first = min(first, w)
                else:
                    second = min(second, w)
    if first < np.inf:
        return arc_length(first, curvature)
    if second < 0.0 and curvature != 0.0:
        return math.tau / abs(curvature) + arc_length(second, curvature)
    return np.inf


@njit(cache=True, nogil=True, error_model="numpy")
def arc_length(w: float, curvature: float) -> float:
    """s = 2 atan(k w) / k, and its limit 2 w where k w vanishes [m]."""
    angle = curvature * w
    # The next term of the series, a third of the angle squared, is below rounding.
    return 2.0 * w if abs(angle) < 1e-8 else 2.0 * math.atan(angle) / curvature
