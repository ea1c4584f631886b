"""Optical flow: people turn so that their focus of expansion is not on anybody who is coming.

In a frame with y along one's velocity and x to its right, neighbour j at (p_x, p_y) moves at (w_x, w_y) relative to the
person. It collides where its image x_g = p_x / p_y is at its own focus of expansion x_f = w_x / w_y:
    C(v) = sum_j I(ttc_j) exp(-|x_g - x_f| / sigma_j),  ttc_j = -p_y / w_y,  sigma_j = R_j / (p_y ln 10)
(Lopez, Chaumette, Marchand and Pettre 2019, "Character navigation in dynamic environments based on optical flow"; the
form is that of van Toll et al. 2020), with I(t) = 10 - 2 t / s, at least 0.1 and none beyond 10 s, over those with
p_y > 0.1 m and w_y < -0.01 m/s. Down the slope, with I and sigma held, theta to the right and s = |v|:
    d(x_g - x_f)/dtheta = x_f^2 - x_g^2 + s / w_y,   d(x_g - x_f)/ds = -x_f / w_y
    a = -(|v| clip(dC/dtheta, +-0.1) e_theta + dC/ds e_s)

Not in the paper: the turn of at most 0.1, without which every encounter is at the limit of the acceleration; two
exactly head on pass on the right.
Differs from the paper: neighbours are seen one by one, without pixels; walls are left to `wall_repulsion`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Cost
from components.crowd.surroundings import OX, OY, PX, PY, REACH, VX, VY, Surroundings

Array = NDArray[np.float64]

NEAREST = 0.1
"""p_y [m]"""
SLOWEST = 0.01
"""-w_y [m/s]"""
LATEST = 10.0
"""[s]"""
GREATEST_TURN = 0.1
"""limit of dC/dtheta"""


@dataclass(frozen=True, kw_only=True)
class Foe(Cost):
    """The cost `foe`."""

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, total)

    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add the accelerations down the slope."""
        _push(around, coefficient, total)


@njit(cache=True, nogil=True, error_model="numpy")
def importance(t: float) -> float:
    """I of a collision after t [s]."""
    return min(max(10.0 - 2.0 * t, 0.1), 10.0) if 0.0 <= t <= LATEST else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _view(near: Array, p: int, vx: float, vy: float, speed: float) -> tuple[bool, float, float, float, float, float]:
    """Neighbour p of somebody who walks at v: does it matter; x_g, x_f, w_y, sigma and ttc."""
    hx, hy = vx / speed, vy / speed
    wx, wy = near[OX, p] - vx, near[OY, p] - vy
    ahead, closing = near[PX, p] * hx + near[PY, p] * hy, wx * hx + wy * hy
    if ahead <= NEAREST or closing >= -SLOWEST:
        return False, 0.0, 0.0, 0.0, 0.0, 0.0
    right, drift = near[PX, p] * hy - near[PY, p] * hx, wx * hy - wy * hx
    sigma = near[REACH, p] / (ahead * math.log(10.0))
    return True, right / ahead, drift / closing, closing, sigma, -ahead / closing


@njit(cache=True, nogil=True, error_model="numpy")
def _add(around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
    people, count = total.shape
    for i in range(people):
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            speed = math.sqrt(cx * cx + cy * cy)
            if speed == 0.0:
                continue
            price = 0.0
            for p in range(around.first[i], around.first[i + 1]):
                matters, image, focus, _, sigma, t = _view(around.near, p, cx, cy, speed)
                if matters:
                    price += importance(t) * math.exp(-abs(image - focus) / sigma)
            total[i, k] += coefficient * price


@njit(cache=True, nogil=True, error_model="numpy")
def _push(around: Surroundings, coefficient: float, total: Array) -> None:
    own = around.own
    for i in range(own.shape[1]):
        vx, vy = own[VX, i], own[VY, i]
        speed = math.sqrt(vx * vx + vy * vy)
        if speed == 0.0:
            continue
        by_angle, by_speed = 0.0, 0.0
        for p in range(around.first[i], around.first[i + 1]):
            matters, image, focus, closing, sigma, t = _view(around.near, p, vx, vy, speed)
            if matters:
                off = image - focus
                # Steepness of exp(-|off| / sigma); zero counts as negative, so that people turn right.
                slope = importance(t) * math.exp(-abs(off) / sigma) / sigma * (-1.0 if off > 0.0 else 1.0)
                by_angle += slope * (focus * focus - image * image + speed / closing)
                by_speed += slope * -focus / closing
        by_angle = min(max(by_angle, -GREATEST_TURN), GREATEST_TURN)
        hx, hy = vx / speed, vy / speed
        total[0, i] -= coefficient * (speed * by_angle * hy + by_speed * hx)
        total[1, i] -= coefficient * (speed * by_angle * -hx + by_speed * hy)
