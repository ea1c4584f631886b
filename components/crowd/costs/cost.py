"""What a cost function is: a price on every velocity that somebody may choose, and the slope of that price.

Write your own in one file: a frozen, keyword-only dataclass with the options, and `add`. Plain numpy will do; for
speed write the loop over people as a numba kernel, as the shipped ones do. `docs/crowd.md` has an example.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.surroundings import VX, VY, Surroundings

Array = NDArray[np.float64]

STEP = 0.1
"""of the central difference that stands in for a missing gradient [m/s]; costs have kinks, which it smooths"""


class Cost(ABC):
    """A cost function C(v) of the velocity that a person may choose."""

    @abstractmethod
    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates.

        Args:
            around: a block of B people
            candidates: (2, B, K) velocities that each may choose: x, then y [m/s]
            coefficient: factor of the cost
            total: (B, K) costs, to which this one is added; infinity forbids a velocity
        """

    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add the accelerations down the slope of the cost, -coefficient grad C at the current velocities.

        Args:
            around: a block of B people
            coefficient: factor of the cost
            total: (2, B) accelerations, to which this one is added [m/s2]
        """
        velocity = around.own[[VX, VY]]
        offsets = np.array([[STEP, -STEP, 0.0, 0.0], [0.0, 0.0, STEP, -STEP]])
        candidates = velocity[:, :, None] + offsets[:, None, :]
        price = np.zeros(candidates.shape[1:])
        self.add(around, candidates, coefficient, price)
        total[0] -= _slope(price[:, 0], price[:, 1])
        total[1] -= _slope(price[:, 2], price[:, 3])


def _slope(ahead: Array, behind: Array) -> Array:
    """Central differences; none where a neighbouring velocity is forbidden."""
    known = np.isfinite(ahead) & np.isfinite(behind)
    return np.where(known, np.where(known, ahead, 0.0) - np.where(known, behind, 0.0), 0.0) / (2.0 * STEP)


class Force(Cost):
    """A cost given by the acceleration F that it causes: C(v) = |v - v_cur - F dt|^2 / (2 dt).

    Its gradient at the current velocity is -F (van Toll et al. 2020, "Generalized microscopic crowd simulation using
    costs in velocity space", section on force-based methods). A subclass defines `push`.
    """

    @abstractmethod
    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add coefficient F to `total` (2, B) [m/s2]."""

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        force = np.zeros((2, candidates.shape[1]))
        self.push(around, 1.0, force)
        target = around.own[[VX, VY]] + force * around.dt
        off = candidates - target[:, :, None]
        total += coefficient / (2.0 * around.dt) * (off[0] ** 2 + off[1] ** 2)


@njit(cache=True, nogil=True, error_model="numpy")
def speeds(cx: Array, cy: Array, speed: Array) -> None:
    """Set `speed` (K,) to the lengths of the velocities (cx, cy) (K,) [m/s]."""
    for k in range(len(cx)):
        speed[k] = math.sqrt(cx[k] * cx[k] + cy[k] * cy[k])


@njit(cache=True, nogil=True, error_model="numpy")
def cosine(ax: float, ay: float, bx: float, by: float) -> float:
    """Cosine of the angle between two vectors; 1 if one of them is zero."""
    squared = (ax * ax + ay * ay) * (bx * bx + by * by)
    return min(max((ax * bx + ay * by) / math.sqrt(squared), -1.0), 1.0) if squared > 0.0 else 1.0
