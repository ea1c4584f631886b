"""People of different minds: several policies in one crowd, and robots as everybody sees them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from components.crowd.policies import PolicyName, make_policy
from components.crowd.reactions import HIDDEN, MOVING, STILL
from components.crowd.scene import Policy, Scene
from components.crowd.steering import Recipe
from components.crowd.variants import VARIANTS

Array = NDArray[np.float64]

STANDING = np.array([1.0, 1.0, 0.0, 0.0, 1.0])
"""a robot's row in `Scene.robots`, without its velocity"""


class Mixture:
    """Everybody follows one of some policies."""

    def __init__(self, policies: Sequence[Policy], which: NDArray[np.int64]) -> None:
        """Policies, and the index of everybody's (N,)."""
        self._parts = [(policy, np.flatnonzero(which == p)) for p, policy in enumerate(policies)]

    def accelerate(self, scene: Scene, sight: NDArray[np.int8]) -> Array:
        """(N, 2) accelerations that everybody wants [m/s2].

        Args:
            scene: the old state, with all robots
            sight: (N,) what everybody sees of the robots: MOVING, STILL or HIDDEN
        """
        views = {
            MOVING: scene,
            STILL: replace(scene, robots=scene.robots * STANDING),
            HIDDEN: replace(scene, robots=scene.robots[:0]),
        }
        acceleration = np.zeros((len(scene.position), 2))
        for policy, members in self._parts:
            for view, seen in views.items():
                some = members[sight[members] == view]
                if len(some) == len(sight):
                    return policy.accelerate(seen)
                if len(some):
                    acceleration[some] = policy.accelerate(seen, some)[some]
        return acceleration


def mix(
    wanted: Sequence[PolicyName | Recipe],
    population: NDArray[np.int64],
    variant: NDArray[np.int64],
    time_horizon: Array,
) -> Mixture:
    """The policies of several populations; those who follow the same one are computed at once.

    Args:
        wanted: the policy of each population
        population: (N,) index of everybody's population
        variant: (N,) everybody's number of those that a policy with distributed options has
        time_horizon: (N,) of `orca` [s]
    """
    different: list[PolicyName | Recipe] = []
    table = np.empty((len(wanted), VARIANTS), np.int64)
    for p, policy in enumerate(wanted):
        for number in range(VARIANTS):
            one = policy.variant(number) if isinstance(policy, Recipe) and policy.varies else policy
            if one not in different:
                different.append(one)
            table[p, number] = different.index(one)
    return Mixture([make_policy(policy, time_horizon=time_horizon) for policy in different], table[population, variant])
