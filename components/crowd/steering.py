"""A policy as a sum of cost functions in velocity space and a way to go down it.

C(v) = sum_k c_k C_k(v). Gradient: a = -grad C(v_cur). Sampling: a = (v* - v_cur) / max(tau, dt), v* the cheapest of
some candidates. Global: the same with candidates all over the disc of possible velocities (van Toll et al. 2020,
"Generalized microscopic crowd simulation using costs in velocity space").

Differs from the paper: everything within one range counts for all costs of a policy. Robots and walls count for every
cost.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from components.crowd.cells import sort_into_cells
from components.crowd.costs import CostError, make_cost
from components.crowd.sampling import GLOBAL, RandomSampling, RegularSampling, towards_best
from components.crowd.scene import RANGE, Scene
from components.crowd.surroundings import Surroundings, Surveyor, in_order
from components.crowd.variants import VARIANTS, of_variant, varies

Array = NDArray[np.float64]

GRADIENT_BLOCK = 512
"""people at a time: few calls from Python"""
CANDIDATES_BLOCK = 32768
"""candidates at a time: half a megabyte of velocities"""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A policy of your own: cost functions, and how people look for low costs."""

    costs: tuple[Mapping[str, Any], ...]
    """each with the `name` of a shipped cost or './my_cost.py:MyCost', its `coefficient` (1), and its options, of which
    numbers may be distributions"""
    optimiser: Literal["gradient", "global"] | RegularSampling | RandomSampling
    """go down the slope, search all velocities, or try those of a fan"""
    relaxation_time: float = 0.0
    """in which people take on the velocity they want; at least the time step [s]"""
    range: float = RANGE
    """people notice others, robots and walls up to this distance [m]"""

    def __post_init__(self) -> None:
        if not self.costs:
            raise ValueError("costs is empty, expected at least one cost function")
        if not (self.relaxation_time >= 0 and math.isfinite(self.relaxation_time)):
            raise ValueError(f"relaxation_time is {self.relaxation_time}, expected zero or a positive number")
        if not (self.range > 0 and math.isfinite(self.range)):
            raise ValueError(f"range is {self.range}, expected a positive number")
        for k, entry in enumerate(self.costs):
            for variant in range(VARIANTS if varies(entry) else 1):
                try:
                    make_cost(of_variant(entry, variant, k))
                except (CostError, ValueError) as error:
                    raise ValueError(f"costs[{k}]: {error}") from None

    @property
    def varies(self) -> bool:
        """True if people differ in an option of a cost."""
        return any(varies(entry) for entry in self.costs)

    def variant(self, number: int) -> Recipe:
        """This recipe with one value for each option that is distributed."""
        return replace(self, costs=tuple(of_variant(entry, number, k) for k, entry in enumerate(self.costs)))


class Steering:
    """The policy that a recipe describes."""

    def __init__(self, recipe: Recipe) -> None:
        self._costs = [make_cost(entry) for entry in recipe.costs]
        self._sampling = GLOBAL if recipe.optimiser == "global" else recipe.optimiser
        self._reach = float(recipe.range)
        self._surveyor = Surveyor(reach=self._reach, relaxation_time=float(recipe.relaxation_time))

    def accelerate(self, scene: Scene, who: NDArray[np.int64] | None = None) -> Array:
        """(N, 2) accelerations that everybody wants, or only those whose indices are in `who` [m/s2]."""
        cells = sort_into_cells(scene.position, scene.period, 0.5 * self._reach)
        if who is None:
            places = np.arange(len(cells.order))
        else:
            asked = np.zeros(len(cells.order), bool)
            asked[who] = True
            places = np.flatnonzero(asked[cells.order])
        others = in_order(cells, scene.velocity, scene.radius)
        acceleration = np.zeros((len(cells.order), 2))
        # One empty block at least, so that the kernels are loaded in an empty world too.
        for begin in range(0, max(len(places), 1), self._block):
            some = places[begin : begin + self._block]
            around = self._surveyor.surroundings(scene, cells, others, some)
            acceleration[cells.order[some]] = self._wanted(around).T
        return acceleration

    @property
    def _block(self) -> int:
        if isinstance(self._sampling, RegularSampling):
            return max(CANDIDATES_BLOCK // (self._sampling.speeds * self._sampling.angles), 1)
        if isinstance(self._sampling, RandomSampling):
            return max(CANDIDATES_BLOCK // self._sampling.samples, 1)
        return GRADIENT_BLOCK

    def _wanted(self, around: Surroundings) -> Array:
        """(2, B) accelerations of a block [m/s2]."""
        if self._sampling == "gradient":
            push = np.zeros((2, around.own.shape[1]))
            for coefficient, cost in self._costs:
                cost.push(around, coefficient, push)
            return push
        candidates = self._sampling.candidates(around)
        total = np.zeros(candidates.shape[1:])
        for coefficient, cost in self._costs:
            cost.add(around, candidates, coefficient, total)
        return towards_best(around, candidates, total)
