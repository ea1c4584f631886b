"""Nothing matters: every velocity costs the same.

C(v) = 0 (van Toll et al. 2020, "Generalized microscopic crowd simulation using costs in velocity space"): an empty
place for tests and for costs of one's own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from components.crowd.costs.cost import Cost
from components.crowd.surroundings import Surroundings


@dataclass(frozen=True, kw_only=True)
class Generic(Cost):
    """The cost `generic`."""

    def add(
        self,
        around: Surroundings,
        candidates: NDArray[np.float64],
        coefficient: float,
        total: NDArray[np.float64],
    ) -> None:
        """Add nothing."""
