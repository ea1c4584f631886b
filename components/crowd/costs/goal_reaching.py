"""Goal reaching: people drive at their preferred velocity.

F = (v_pref - v) / tau (Helbing and Molnar 1995, "Social force model for pedestrian dynamics", eq. 2), tau the policy's
relaxation time.

Not in the paper: tau is at least the time step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from components.crowd.costs.cost import Force
from components.crowd.surroundings import GX, GY, VX, VY, Surroundings


@dataclass(frozen=True, kw_only=True)
class GoalReaching(Force):
    """The cost `goal_reaching`."""

    def push(self, around: Surroundings, coefficient: float, total: NDArray[np.float64]) -> None:
        """Add coefficient F to `total` (2, B) [m/s2]."""
        own = around.own
        total += coefficient / around.relaxation_time * (own[GX : GY + 1] - own[VX : VY + 1])
