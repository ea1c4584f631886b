"""The people before a camera, nearest first, as round cones in its frame with their places in the picture."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.round_cone import WITHIN, ball_extent, holds_camera, round_cone
from components.sensors.rendering.view import View
from components.sensors.scan import People
from crowdcosim.avatar import CAPSULES, REACH, pose_one
from crowdcosim.body import SEGMENTS

Array = NDArray[np.float64]

SIGHT = 60.0
"""nobody farther away than this is drawn [m]"""

_TAPER = {
    "shank": (0.76, 1.14),
    "thigh": (0.80, 1.16),
    "trunk": (0.94, 1.0),
    "head": (0.82, 1.0),
    "upper arm": (1.10, 0.88),
    "forearm": (1.06, 0.74),
    "hand": (0.86, 1.0),
}
TAPER = np.array([next((t for part, t in _TAPER.items() if part in segment), (1.0, 1.0)) for segment in SEGMENTS])
"""(17, 2) radii at both ends of a limb, over those of the avatar's capsules"""

_BALL = math.hypot(0.5, REACH)
"""no part of a body is farther than this from the middle of its height, over stature"""


class InSight(NamedTuple):
    """Those who may be seen, nearest first; somebody may be there twice, on both sides of a seam."""

    index: NDArray[np.intp]
    """(V,) of the person in the crowd"""
    centre: Array
    """(V, 2) where they, or their image across the seam, are in the map [m]"""


class Bodies(NamedTuple):
    """Their bodies in the picture; pixels are counted from 0 and may be beyond its edges."""

    cone: Array
    """(V, 17, 8) both ends (x, y, z) in the camera's frame, each with its radius [m]"""
    box: Array
    """(V, 17, 2, 4) of both ends' balls: first and last column, first and last row [pixels]"""
    nearest: Array
    """(V, 17) greatest inverse depth that a limb can have [1/m], 0 if it is not in the picture"""
    extent: Array
    """(V, 4) of the whole body: first and last column, first and last row [pixels]"""
    front: Array
    """(V,) greatest inverse depth of the whole body [1/m]"""
    facing: Array
    """(V, 3) unit vector ahead of them, in the camera's frame"""


def in_sight(view: View, people: People, period: Array, reach: float, size: Array) -> InSight:
    """Those who may be in the picture.

    Args:
        view: the camera
        people: the crowd
        period: (2,) of the map [m], 0 along an axis that does not wrap around
        reach: images across a seam are seen that are at most this far outside of the world's rectangle [m]
        size: (2,) the world's extent [m]
    """
    if len(people.id) == 0:
        return InSight(np.zeros(0, np.intp), np.zeros((0, 2)))
    index, centre, away = _candidates(view, people.position, people.stature, period, reach, size)
    order = np.argsort(away, kind="stable")
    return InSight(index[order], centre[order])


@njit(cache=True, nogil=True, error_model="numpy")
def _candidates(
    view: View, position: Array, stature: Array, period: Array, reach: float, size: Array
) -> tuple[NDArray[np.intp], Array, Array]:
    """Index, centre and squared distance of everybody, and of their images, who are in the camera's pyramid."""
    index, centre, away = [], [], []
    tx, ty = (0.5 * view.width + 1.0) / view.focal, (0.5 * view.height + 1.0) / view.focal
    nx, ny = math.sqrt(1.0 + tx * tx), math.sqrt(1.0 + ty * ty)
    for n in range(len(position)):
        radius, up = _BALL * stature[n], 0.5 * stature[n] - view.position[2]
        west, east = _shifts(position[n, 0], view.position[0], period[0], reach, size[0])
        south, north = _shifts(position[n, 1], view.position[1], period[1], reach, size[1])
        for i in range(west, east + 1):
            for j in range(south, north + 1):
                dx = position[n, 0] + i * period[0] - view.position[0]
                dy = position[n, 1] + j * period[1] - view.position[1]
                x = view.axes[0, 0] * dx + view.axes[0, 1] * dy + view.axes[0, 2] * up
                y = view.axes[1, 0] * dx + view.axes[1, 1] * dy + view.axes[1, 2] * up
                z = view.axes[2, 0] * dx + view.axes[2, 1] * dy + view.axes[2, 2] * up
                if z < -radius or abs(x) - tx * z > nx * radius or abs(y) - ty * z > ny * radius:
                    continue
                square = dx * dx + dy * dy
                if square <= SIGHT * SIGHT:
                    index.append(n)
                    centre.append((dx + view.position[0], dy + view.position[1]))
                    away.append(square)
    count = len(index)
    indices, centres, distances = np.empty(count, np.intp), np.empty((count, 2)), np.empty(count)
    for k in range(count):
        indices[k], distances[k] = index[k], away[k]
        centres[k, 0], centres[k, 1] = centre[k]
    return indices, centres, distances


@njit(cache=True, nogil=True, error_model="numpy")
def _shifts(here: float, camera: float, period: float, reach: float, size: float) -> tuple[int, int]:
    """First and last number of periods after which somebody is in sight and within `reach` of [0, size]."""
    if period == 0.0:
        return 0, 0
    low, high = max(-reach, camera - SIGHT), min(size + reach, camera + SIGHT)
    return math.ceil((low - here) / period), math.floor((high - here) / period)


@njit(cache=True, nogil=True, error_model="numpy")
def bodies(view: View, people: People, seen: InSight, taper: Array) -> Bodies:
    """Everybody in sight as round cones, and where these are in the picture."""
    count = len(seen.index)
    cone = np.empty((count, CAPSULES, 8))
    box = np.empty((count, CAPSULES, 2, 4))
    nearest = np.zeros((count, CAPSULES))
    extent = np.empty((count, 4))
    front = np.zeros(count)
    facing = np.empty((count, 3))
    capsules = np.empty((CAPSULES, 7))
    position, axes, index, centre = view.position, view.axes, seen.index, seen.centre
    velocity, heading, stature, gait_phase = people.velocity, people.heading, people.stature, people.gait_phase
    for v in range(count):
        n = index[v]
        dx, dy = centre[v, 0] - position[0], centre[v, 1] - position[1]
        pose_one(dx, dy, velocity[n, 0], velocity[n, 1], heading[n], stature[n], gait_phase[n], capsules)
        cos, sin = math.cos(heading[n]), math.sin(heading[n])
        for axis in range(3):
            facing[v, axis] = axes[axis, 0] * cos + axes[axis, 1] * sin
        left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
        for c in range(CAPSULES):
            for end in range(2):
                x, y, z = capsules[c, 3 * end], capsules[c, 3 * end + 1], capsules[c, 3 * end + 2] - position[2]
                for axis in range(3):
                    cone[v, c, 4 * end + axis] = axes[axis, 0] * x + axes[axis, 1] * y + axes[axis, 2] * z
                cone[v, c, 4 * end + 3] = capsules[c, 6] * taper[c, end]
            near = _place(cone, v, c, box, view.width, view.height, view.focal, view.cx, view.cy)
            nearest[v, c] = near
            if near > 0.0:
                front[v] = max(front[v], near)
                left, right = min(left, box[v, c, 0, 0], box[v, c, 1, 0]), max(right, box[v, c, 0, 1], box[v, c, 1, 1])
                top, bottom = min(top, box[v, c, 0, 2], box[v, c, 1, 2]), max(bottom, box[v, c, 0, 3], box[v, c, 1, 3])
        extent[v, 0], extent[v, 1], extent[v, 2], extent[v, 3] = left, right, top, bottom
    return Bodies(cone, box, nearest, extent, front, facing)


@njit(cache=True, nogil=True, error_model="numpy")
def _place(
    cone: Array, v: int, c: int, box: Array, width: int, height: int, focal: float, cx: float, cy: float
) -> float:
    """Write both ends' places in the picture into `box`; the greatest inverse depth, 0 if out of the picture."""
    near = np.inf
    for end in range(2):
        x, y, z, radius = (
            cone[v, c, 4 * end],
            cone[v, c, 4 * end + 1],
            cone[v, c, 4 * end + 2],
            cone[v, c, 4 * end + 3],
        )
        near = min(near, z - radius)
        if z > radius:
            low, high = ball_extent(x, z, radius)
            box[v, c, end, 0], box[v, c, end, 1] = cx + focal * low, cx + focal * high
            low, high = ball_extent(y, z, radius)
            box[v, c, end, 2], box[v, c, end, 3] = cy + focal * low, cy + focal * high
    if near <= 0.0:
        if _beside(cone, v, c, (0.5 * width + 1.0) / focal, (0.5 * height + 1.0) / focal):
            return 0.0
        for end in range(2):
            box[v, c, end, 0], box[v, c, end, 1] = 0.0, width - 1.0
            box[v, c, end, 2], box[v, c, end, 3] = 0.0, height - 1.0
        return WITHIN
    if (
        max(box[v, c, 0, 1], box[v, c, 1, 1]) < 0.0
        or min(box[v, c, 0, 0], box[v, c, 1, 0]) > width - 1
        or max(box[v, c, 0, 3], box[v, c, 1, 3]) < 0.0
        or min(box[v, c, 0, 2], box[v, c, 1, 2]) > height - 1
    ):
        return 0.0
    return min(1.0 / near, WITHIN)


@njit(cache=True, nogil=True, error_model="numpy")
def _beside(cone: Array, v: int, c: int, tx: float, ty: float) -> bool:
    """True if both balls are behind the camera or beyond the same side of its pyramid."""
    if holds_camera(round_cone(cone, v, c)):
        return False
    if cone[v, c, 2] <= -cone[v, c, 3] and cone[v, c, 6] <= -cone[v, c, 7]:
        return True
    for axis in range(2):
        t = tx if axis == 0 else ty
        norm = math.sqrt(1.0 + t * t)
        for sign in (-1.0, 1.0):
            if (
                sign * cone[v, c, axis] - t * cone[v, c, 2] > norm * cone[v, c, 3]
                and sign * cone[v, c, 4 + axis] - t * cone[v, c, 6] > norm * cone[v, c, 7]
            ):
                return True
    return False
