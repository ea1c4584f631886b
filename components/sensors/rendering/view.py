"""Where a pinhole camera is, where it looks, and what its pixels are.

The camera's axes are those of an optical frame (REP 103): x right, y down, z ahead. Pixel (u, v) looks along
d = ((u - cx) / f, (v - cy) / f, 1), through its centre, and sees the point d / w, where w is the inverse depth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class View(NamedTuple):
    """A pinhole camera in the map; its pixels are square."""

    position: Array
    """(3,) of the pinhole in the map [m]"""
    axes: Array
    """(3, 3) rows: the camera's right, down and ahead, in the map"""
    focal: float
    """focal length f [pixels]"""
    cx: float
    """column of the optical axis"""
    cy: float
    """row of the optical axis"""
    width: int
    """[pixels]"""
    height: int
    """[pixels]"""


def focal_length(width: int, field_of_view: float) -> float:
    """Focal length [pixels] of a picture `width` pixels wide that spans `field_of_view` [rad]."""
    return 0.5 * width / math.tan(0.5 * field_of_view)


def view_of(
    position: tuple[float, float, float], yaw: float, pitch: float, width: int, height: int, field_of_view: float
) -> View:
    """A camera at `position` [m] that looks along `yaw`, then `pitch` downwards [rad].

    Args:
        position: in the map [m]
        yaw: counter-clockwise from the map's x [rad]
        pitch: positive looks down [rad]
        width: columns
        height: rows
        field_of_view: from the left edge to the right one [rad]
    """
    cos, sin, level, down = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    axes = np.array([(sin, -cos, 0.0), (-down * cos, -down * sin, -level), (level * cos, level * sin, -down)])
    return View(
        np.array(position, np.float64),
        axes,
        focal_length(width, field_of_view),
        0.5 * (width - 1),
        0.5 * (height - 1),
        width,
        height,
    )
