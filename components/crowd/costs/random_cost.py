"""Chance: every velocity costs something else at every step, uniform in -1 to 1.

C(v) ~ U(-1, 1) (van Toll et al. 2020, "Generalized microscopic crowd simulation using costs in velocity space", for
tests of the simulation and of optimisers).

Not in the paper: the k-th candidate's cost comes from a number of the person's own for the step, and depends on nobody
else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Cost
from components.crowd.sampling import uniform
from components.crowd.surroundings import Surroundings

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RandomCost(Cost):
    """The cost `random`."""

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, coefficient, total)


@njit(cache=True, nogil=True, error_model="numpy")
def _add(around: Surroundings, coefficient: float, total: Array) -> None:
    people, count = total.shape
    for i in range(people):
        # Not the numbers that candidates are drawn with.
        stream = ~around.stream[i]
        for k in range(count):
            total[i, k] += coefficient * (2.0 * uniform(stream, k) - 1.0)
