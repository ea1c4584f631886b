"""People of different minds: several policies in one crowd, each for its share of the people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from components.crowd.policies import PolicyName
from components.crowd.scene import Policy, Scene
from components.crowd.steering import Recipe

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Share:
    """A part of the crowd with a policy of its own."""

    policy: PolicyName | Recipe
    """how these people avoid others"""
    share: float
    """how many of them, in proportion to the other shares"""

    def __post_init__(self) -> None:
        if not (self.share > 0 and math.isfinite(self.share)):
            raise ValueError(f"share is {self.share}, expected a positive number")


class Mixture:
    """Everybody follows the policy of the group that they belong to."""

    def __init__(self, policies: Sequence[Policy], group: NDArray[np.int64]) -> None:
        """Policies, and the index of everybody's (N,)."""
        self._parts = [(policy, np.flatnonzero(group == g)) for g, policy in enumerate(policies)]

    def accelerate(self, scene: Scene, who: NDArray[np.int64] | None = None) -> Array:
        """(N, 2) accelerations that everybody wants, or at least those of `who` [m/s2]."""
        acceleration = np.zeros((len(scene.position), 2))
        for policy, members in self._parts:
            some = members if who is None else np.intersect1d(members, who)
            acceleration[some] = policy.accelerate(scene, some)[some]
        return acceleration


def draw_groups(rng: np.random.Generator, count: int, shares: Sequence[float]) -> NDArray[np.int64]:
    """(count,) index of everybody's group, in random order; the sizes are as near to the shares as whole people are."""
    edges = np.rint(np.cumsum(shares) / np.sum(shares) * count).astype(np.int64)
    return rng.permutation(np.repeat(np.arange(len(shares)), np.diff(edges, prepend=0)))
