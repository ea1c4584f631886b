"""Choosing a velocity by trying many: candidates on a regular fan or at random, and the cheapest of them.

Candidates are base + length direction(angle), with length from 0 to a radius and angle within a fan about a direction
(van Toll et al. 2020, "Generalized microscopic crowd simulation using costs in velocity space", section on sampling).
Random ones are uniform in angle and in length, not in area.

Not in the paper: whoever is almost at rest looks to the preferred velocity where the fan is about the own one. Of
equally cheap candidates the first is taken; where all are forbidden, people want to stop. Random numbers are counted
(SplitMix64; Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators") from a number of everybody's
own for each step, so that they depend on nobody else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.surroundings import GX, GY, MAX_ACCELERATION, MAX_SPEED, VX, VY, Surroundings, facing

Array = NDArray[np.float64]

AT_REST = 0.1
"""slower people look to the preferred velocity, rather than where contacts push them [m/s]"""

Base = Literal["zero", "velocity"]
Direction = Literal["x", "velocity", "preferred"]
Radius = Literal["preferred_speed", "max_speed", "max_acceleration"]

_BASES: tuple[Base, ...] = ("zero", "velocity")
_DIRECTIONS: tuple[Direction, ...] = ("x", "velocity", "preferred")
_RADII: tuple[Radius, ...] = ("preferred_speed", "max_speed", "max_acceleration")


@dataclass(frozen=True, kw_only=True)
class _Fan:
    """Where candidates lie."""

    base: Base = "zero"
    """where the fan begins: standing still, or the own velocity"""
    direction: Direction = "velocity"
    """its middle: along x, the own velocity, or the preferred one"""
    radius: Radius = "preferred_speed"
    """its length; `max_acceleration`: what a step can change, at most twice the maximum speed"""
    angle_deg: float = 180.0
    """how wide it opens, both sides together [deg]"""

    def __post_init__(self) -> None:
        if not 0 < self.angle_deg <= 360:
            raise ValueError(f"angle_deg is {self.angle_deg}, expected more than 0 and at most 360")

    def _choices(self) -> tuple[int, int, int]:
        return _BASES.index(self.base), _DIRECTIONS.index(self.direction), _RADII.index(self.radius)


@dataclass(frozen=True, kw_only=True)
class RegularSampling(_Fan):
    """Candidates at equal steps of length and angle."""

    sampling: Literal["regular"]
    speeds: int = 4
    """number of lengths"""
    angles: int = 11
    """number of angles"""
    include_base: bool = False
    """the base is the first length, once; otherwise the first length is one step away from it"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.speeds < 1 + self.include_base:
            raise ValueError(f"speeds is {self.speeds}, expected at least {1 + self.include_base}")
        if self.angles < 1 + (self.angle_deg < 360):
            raise ValueError(f"angles is {self.angles}, expected at least {1 + (self.angle_deg < 360)}")

    def pattern(self) -> Array:
        """(2, K) candidates of a fan of radius 1 about the x axis, shortest first, from right to left."""
        half = math.radians(self.angle_deg) / 2
        closed = self.angle_deg == 360
        angle = -half + np.arange(self.angles) * 2 * half / (self.angles if closed else self.angles - 1)
        length = np.arange(1, self.speeds + 1 - self.include_base) / (self.speeds - self.include_base)
        fan = np.array([np.outer(length, np.cos(angle)).ravel(), np.outer(length, np.sin(angle)).ravel()])
        return np.ascontiguousarray(np.concatenate([np.zeros((2, 1)), fan], axis=1) if self.include_base else fan)

    def candidates(self, around: Surroundings) -> Array:
        """(2, B, K) velocities that each may choose [m/s]."""
        return _fan_out(around, self.pattern(), *self._choices())


@dataclass(frozen=True, kw_only=True)
class RandomSampling(_Fan):
    """Candidates at random, new ones for everybody and every step."""

    sampling: Literal["random"]
    samples: int = 100
    """number of candidates"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.samples < 1:
            raise ValueError(f"samples is {self.samples}, expected at least 1")

    def candidates(self, around: Surroundings) -> Array:
        """(2, B, K) velocities that each may choose [m/s]."""
        return _throw(around, self.samples, math.radians(self.angle_deg) / 2, *self._choices())


GLOBAL = RegularSampling(
    sampling="regular", direction="x", radius="max_speed", angle_deg=360.0, speeds=11, angles=36, include_base=True
)
"""the search for a global minimum that has no closed form"""


def next_streams(stream: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """(N,) the numbers from which random choices begin one step later: as far apart as others drawn at random."""
    return stream * np.uint64(0xD1342543DE82EF95) + np.uint64(1)


@njit(cache=True, nogil=True, error_model="numpy")
def uniform(stream: np.uint64, k: int) -> float:
    """The k-th random number of a stream, in [0, 1)."""
    z = stream + np.uint64(k) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return (z >> np.uint64(11)) * 2.0**-53


@njit(cache=True, nogil=True, error_model="numpy")
def _frame(around: Surroundings, i: int, base: int, direction: int, radius: int) -> tuple[float, float, float, float]:
    """The base of person i's fan, and the vector of its middle, as long as its radius [m/s]."""
    own = around.own
    bx, by = (own[VX, i], own[VY, i]) if base == 1 else (0.0, 0.0)
    ux, uy = 1.0, 0.0
    if direction == 1:
        ux, uy, _ = facing(own, i, AT_REST)
    elif direction == 2:
        ux, uy, _ = facing(own, i, np.inf)
    if radius == 0:
        reach = math.sqrt(own[GX, i] ** 2 + own[GY, i] ** 2)
    elif radius == 1:
        reach = own[MAX_SPEED, i]
    else:
        reach = min(2.0 * own[MAX_SPEED, i], own[MAX_ACCELERATION, i] * around.dt)
    return bx, by, reach * ux, reach * uy


@njit(cache=True, nogil=True, error_model="numpy")
def _fan_out(around: Surroundings, pattern: Array, base: int, direction: int, radius: int) -> Array:
    people, count = around.own.shape[1], pattern.shape[1]
    candidates = np.empty((2, people, count))
    for i in range(people):
        bx, by, dx, dy = _frame(around, i, base, direction, radius)
        for k in range(count):
            candidates[0, i, k] = bx + pattern[0, k] * dx - pattern[1, k] * dy
            candidates[1, i, k] = by + pattern[0, k] * dy + pattern[1, k] * dx
    return candidates


@njit(cache=True, nogil=True, error_model="numpy")
def _throw(around: Surroundings, count: int, half: float, base: int, direction: int, radius: int) -> Array:
    people = around.own.shape[1]
    candidates = np.empty((2, people, count))
    for i in range(people):
        bx, by, dx, dy = _frame(around, i, base, direction, radius)
        stream = around.stream[i]
        for k in range(count):
            angle = half * (2.0 * uniform(stream, 2 * k) - 1.0)
            length = uniform(stream, 2 * k + 1)
            along, across = length * math.cos(angle), length * math.sin(angle)
            candidates[0, i, k] = bx + along * dx - across * dy
            candidates[1, i, k] = by + along * dy + across * dx
    return candidates


@njit(cache=True, nogil=True, error_model="numpy")
def towards_best(around: Surroundings, candidates: Array, total: Array) -> Array:
    """(2, B) accelerations to everybody's cheapest candidate within the relaxation time [m/s2]."""
    people, count = total.shape
    result = np.empty((2, people))
    for i in range(people):
        x, y, least = 0.0, 0.0, np.inf
        for k in range(count):
            if total[i, k] < least:
                x, y, least = candidates[0, i, k], candidates[1, i, k], total[i, k]
        result[0, i] = (x - around.own[VX, i]) / around.relaxation_time
        result[1, i] = (y - around.own[VY, i]) / around.relaxation_time
    return result
