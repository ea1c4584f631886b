"""Social groups: people who walk together keep near each other, abreast, so that all see each other.

Moussaid, Perozo, Garnier, Helbing and Theraulaz 2010, "The walking behaviour of pedestrian social groups and its
impact on crowd dynamics", eq. 3 and below: the acceleration
    f = -beta1 alpha v + q_A beta2 U + sum_k q_R beta3 W_k
    alpha  the angle by which the head has to turn for the centre of the others to come into a field of view of
           phi = 90 deg to either side of the walking direction [rad]: those ahead wait
    U      unit vector to the centre of the group; q_A = 1 if it is farther than (K - 1) / 2 metres, K people, else 0
    W_k    unit vector from another member; q_R = 1 if that one is nearer than d0, else 0
beta1 = 4 /s, beta2 = 3 m/s2, beta3 = 1 m/s2, d0 = 0.8 m.

Differs from the paper: the acceleration becomes a change of the preferred velocity by tau f, tau = 0.5 s, which is the
same to a policy that relaxes to it within tau (`social_force`) and works with every other; q_A and q_R go from
0 to 1 over 0.5 m, so that people who follow their preferred velocity at once do not tremble; the walking
direction is that of the preferred velocity, and v in the first term is the preferred velocity. Not in the paper: a
preferred velocity never turns round nor exceeds the greatest speed because of the group.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import shortest
from components.crowd.scene import Scene

Array = NDArray[np.float64]

GAZE, ATTRACTION, REPULSION = 4.0, 3.0, 1.0
"""beta1 [1/s], beta2 and beta3 [m/s2]"""
VIEW = math.radians(90.0)
"""phi [rad]"""
APART = 0.8
"""d0 [m]"""
SOFTNESS = 0.5
"""over which forces begin [m]"""
RELAXATION = 0.5
"""tau [s]"""


class Groups:
    """The social groups of N people."""

    def __init__(self, group: NDArray[np.uint32]) -> None:
        """The number of everybody's group (N,), 0 for who walks alone."""
        order = np.argsort(group, kind="stable")
        self._members = order[group[order] > 0]
        _, sizes = np.unique(group[self._members], return_counts=True)
        self._first = np.concatenate([[0], np.cumsum(sizes)])

    def preferred(self, scene: Scene) -> Array:
        """(N, 2) preferred velocities of those who walk together, and of all others as they were [m/s]."""
        if len(self._members) == 0:
            return scene.preferred
        return _preferred(self._first, self._members, scene.position, scene.preferred, scene.max_speed, scene.period)


def abreast(way: Array, radius: Array) -> Array:
    """(K, 2) places of K people of one group who walk in direction `way` (2,), about their middle [m]."""
    count = len(radius)
    step = max(APART, 2.0 * float(radius.max()) + 0.1)
    left = np.array([-way[1], way[0]])
    return step * (np.arange(count) - 0.5 * (count - 1))[:, None] * left


@njit(cache=True, nogil=True, error_model="numpy")
def _ramp(excess: float) -> float:
    """0 below zero, 1 from SOFTNESS on."""
    return min(max(excess / SOFTNESS, 0.0), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def group_acceleration(px: Array, py: Array, gx: float, gy: float) -> tuple[float, float]:
    """f [m/s2] on somebody who prefers (gx, gy), with the other members at (px, py) (K - 1,) relative to it."""
    others = len(px)
    sx, sy, ax, ay = 0.0, 0.0, 0.0, 0.0
    for k in range(others):
        sx, sy = sx + px[k], sy + py[k]
        distance = math.sqrt(px[k] * px[k] + py[k] * py[k])
        if distance > 0.0:
            q = REPULSION * _ramp(APART - distance)
            ax, ay = ax - q * px[k] / distance, ay - q * py[k] / distance
    # The centre of the others is seen; that of all, oneself included, attracts.
    speed, away = math.sqrt(gx * gx + gy * gy), math.sqrt(sx * sx + sy * sy)
    if away > 0.0:
        q = ATTRACTION * _ramp(away / (others + 1) - 0.5 * others)
        ax, ay = ax + q * sx / away, ay + q * sy / away
        if speed > 0.0:
            angle = math.acos(min(max((sx * gx + sy * gy) / (away * speed), -1.0), 1.0))
            alpha = max(angle - VIEW, 0.0)
            ax, ay = ax - GAZE * alpha * gx, ay - GAZE * alpha * gy
    return ax, ay


@njit(cache=True, nogil=True, error_model="numpy")
def _preferred(
    first: NDArray[np.int64],
    members: NDArray[np.int64],
    position: Array,
    preferred: Array,
    max_speed: Array,
    period: Array,
) -> Array:
    result = preferred.copy()
    for g in range(len(first) - 1):
        count = first[g + 1] - first[g]
        px, py = np.empty(count - 1), np.empty(count - 1)
        for m in range(first[g], first[g + 1]):
            i, k = members[m], 0
            for o in range(first[g], first[g + 1]):
                if o != m:
                    px[k] = shortest(position[members[o], 0] - position[i, 0], period[0])
                    py[k] = shortest(position[members[o], 1] - position[i, 1], period[1])
                    k += 1
            gx, gy = preferred[i, 0], preferred[i, 1]
            ax, ay = group_acceleration(px, py, gx, gy)
            x, y = RELAXATION * ax, RELAXATION * ay
            squared = gx * gx + gy * gy
            if squared > 0.0:
                # Against the way no more than to a stop.
                back = max(-(x * gx + y * gy) / squared - 1.0, 0.0)
                x, y = x + back * gx, y + back * gy
            x, y = gx + x, gy + y
            speed = math.sqrt(x * x + y * y)
            if speed > max_speed[i]:
                x, y = x * max_speed[i] / speed, y * max_speed[i] / speed
            result[i, 0], result[i, 1] = x, y
    return result
