"""A limb as its paint sees it: which way its surface faces at a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Tube(NamedTuple):
    """A limb from its end a along e, with what its pixels have in common."""

    ax: float
    ay: float
    az: float
    ex: float
    ey: float
    ez: float
    p: float
    """radius at a [m]"""
    fx: float
    """of a point x, f.x - shift is how far it is along e"""
    fy: float
    fz: float
    shift: float
    thick: float
    """one over the radius at a [1/m]"""
    thinner: float
    """what is added to it at the other end"""


@njit(cache=True, nogil=True, error_model="numpy")
def tube_of(cone: Array, k: int, c: int) -> Tube:
    """Limb c of the k-th person of `cone`, (V, 17, 8), as in `Bodies`."""
    ax, ay, az, p, q = cone[k, c, 0], cone[k, c, 1], cone[k, c, 2], cone[k, c, 3], cone[k, c, 7]
    ex, ey, ez, taper = cone[k, c, 4] - ax, cone[k, c, 5] - ay, cone[k, c, 6] - az, p - q
    per = 1.0 / (ex * ex + ey * ey + ez * ez - taper * taper)
    shift = (ax * ex + ay * ey + az * ez + p * taper) * per
    thick = 1.0 / p
    return Tube(ax, ay, az, ex, ey, ez, p, ex * per, ey * per, ez * per, shift, thick, 1.0 / q - thick)


@njit(cache=True, nogil=True, error_model="numpy")
def normal_of(tube: Tube, x: float, y: float, z: float) -> tuple[float, float, float, float, float]:
    """Of the point z (x, y, 1): the unit normal, how far along the tube it is, 0 to 1, and one over the radius."""
    s = min(max(z * (x * tube.fx + y * tube.fy + tube.fz) - tube.shift, 0.0), 1.0)
    thin = tube.thick + s * tube.thinner
    nx, ny, nz = x * z - tube.ax - s * tube.ex, y * z - tube.ay - s * tube.ey, z - tube.az - s * tube.ez
    return nx * thin, ny * thin, nz * thin, s, thin
