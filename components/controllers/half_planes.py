"""The velocity nearest to a preferred one, or the least wrong one, under half-planes: ORCA's linear programs.

A half-plane is n . v <= b with |n| = 1. The programs are incremental: a half-plane that the best velocity so far obeys
changes nothing, and one that it does not obey holds the new best velocity on its edge.

Those that must hold (walls) come first and are never relaxed.

van den Berg, Guy, Lin, Manocha, "Reciprocal n-body collision avoidance", ISRR 2009, sections 5.1, 5.3 and 5.4; de Berg
et al., "Computational Geometry", chapter 4.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARALLEL = 1e-9
"""sine of the angle below which two edges are parallel"""


@njit(cache=True, nogil=True, error_model="numpy")
def best_velocity(planes: Array, hard: int, max_speed: float, x: float, y: float) -> tuple[float, float]:
    """The velocity to take [m/s].

    Args:
        planes: (P, 3) half-planes as n_x, n_y, b [m/s], the hard ones first. Standing must obey the hard ones: b >= 0.
        hard: how many must hold.
        max_speed: greatest speed [m/s].
        x: preferred velocity [m/s].
        y: [m/s]

    Returns:
        The velocity nearest to the preferred one that obeys all half-planes; where there is none, the one that
        trespasses least on the worst of those that may be relaxed.
    """
    shorten = max_speed / max(max_speed, math.hypot(x, y))
    failed, x, y = _nearest(planes, len(planes), max_speed, x, y, False, shorten * x, shorten * y)
    if failed < len(planes):
        x, y = _least_wrong(planes, hard, failed, max_speed, x, y)
    return x, y


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(
    planes: Array, count: int, max_speed: float, goal_x: float, goal_y: float, far: bool, x: float, y: float
) -> tuple[int, float, float]:
    """Start from (x, y) and obey one half-plane after the other, as near to the goal as possible.

    If `far`, the goal is a direction: the velocity farthest along it is wanted. Returns the number of the half-plane
    that cannot be obeyed, or `count`, and the velocity that obeys all before it.
    """
    for i in range(count):
        if planes[i, 0] * x + planes[i, 1] * y > planes[i, 2]:
            feasible, new_x, new_y = _on_edge(planes, i, max_speed, goal_x, goal_y, far)
            if not feasible:
                return i, x, y
            x, y = new_x, new_y
    return count, x, y


@njit(cache=True, nogil=True, error_model="numpy")
def _on_edge(
    planes: Array, i: int, max_speed: float, goal_x: float, goal_y: float, far: bool
) -> tuple[bool, float, float]:
    """The best velocity b n + t d on the edge of half-plane i that obeys those before it; whether there is one."""
    nx, ny, b = planes[i, 0], planes[i, 1], planes[i, 2]
    square = max_speed * max_speed - b * b
    if square < 0.0:
        return False, 0.0, 0.0
    dx, dy = -ny, nx
    last = math.sqrt(square)
    first = -last
    for j in range(i):
        across = planes[j, 0] * dx + planes[j, 1] * dy
        room = planes[j, 2] - b * (planes[j, 0] * nx + planes[j, 1] * ny)
        if abs(across) <= PARALLEL:
            if room < 0.0:
                return False, 0.0, 0.0
        elif across > 0.0:
            last = min(last, room / across)
        else:
            first = max(first, room / across)
        if first > last:
            return False, 0.0, 0.0
    t = goal_x * dx + goal_y * dy
    if far:
        t = last if t > 0.0 else first
    t = min(last, max(first, t))
    return True, b * nx + t * dx, b * ny + t * dy


@njit(cache=True, nogil=True, error_model="numpy")
def _least_wrong(planes: Array, hard: int, begin: int, max_speed: float, x: float, y: float) -> tuple[float, float]:
    """Raise the common trespass, half-plane by half-plane, no further than each needs."""
    level = 0.0
    projected = np.empty_like(planes)
    projected[:hard] = planes[:hard]
    for i in range(max(begin, hard), len(planes)):
        nx, ny, b = planes[i, 0], planes[i, 1], planes[i, 2]
        if nx * x + ny * y - b <= level:
            continue
        count = hard
        for j in range(hard, i):
            # Where plane j is trespassed no more than plane i.
            px, py = planes[j, 0] - nx, planes[j, 1] - ny
            length = math.hypot(px, py)
            if length > PARALLEL:
                projected[count, 0], projected[count, 1] = px / length, py / length
                projected[count, 2] = (planes[j, 2] - b) / length
                count += 1
        failed, new_x, new_y = _nearest(projected, count, max_speed, -nx, -ny, True, -nx * max_speed, -ny * max_speed)
        # It cannot fail but by rounding, since the last velocity obeys them all; then that one stays.
        if failed == count:
            x, y = new_x, new_y
        level = nx * x + ny * y - b
    return x, y


@njit(cache=True, nogil=True, error_model="numpy")
def escape(
    x: float, y: float, vx: float, vy: float, contact: float, horizon: float, dt: float
) -> tuple[float, float, float, float]:
    """The least change u of the relative velocity that avoids the other within the horizon, and the normal n there.

    Args:
        x: from the robot to the other [m].
        y: [m]
        vx: velocity of the robot relative to the other [m/s].
        vy: [m/s]
        contact: sum of the radii [m].
        horizon: tau [s].
        dt: within which to part where they already touch [s].

    Returns:
        u_x, u_y [m/s], n_x, n_y.
    """
    square = x * x + y * y
    apart = square > contact * contact
    tau = horizon if apart else dt
    wx, wy = vx - x / tau, vy - y / tau
    inward = wx * x + wy * y
    length = math.hypot(wx, wy)
    if apart and (inward >= 0.0 or inward * inward <= contact * contact * length * length):
        # Onto the nearer leg of the cone, whose direction is the line of sight turned until it grazes the other.
        leg = math.sqrt(square - contact * contact)
        side = 1.0 if x * wy - y * wx > 0.0 else -1.0
        dx, dy = (x * leg - side * y * contact) / square, (y * leg + side * x * contact) / square
        nx, ny = -side * dy, side * dx
        out = -(vx * nx + vy * ny)
    else:
        # Onto the circle that cuts the cone off.
        if length > 0.0:
            nx, ny = wx / length, wy / length
        elif square > 0.0:
            nx, ny = -x / math.sqrt(square), -y / math.sqrt(square)
        else:
            nx, ny = -1.0, 0.0
        out = contact / tau - length
    return out * nx, out * ny, nx, ny
