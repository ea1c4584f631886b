"""The shipped policies by name, those of van Toll et al. 2020 with the settings of their authors' examples.

"Generalized microscopic crowd simulation using costs in velocity space" brings methods of the literature into one
form, cost functions and an optimiser; the settings are those of its library's example files. `orca` and `social_force`
have kernels of their own.

Differs from the library: `foe` and `ttca_dca` see walls, by `wall_repulsion`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from components.crowd.orca import Orca
from components.crowd.sampling import RandomSampling, RegularSampling
from components.crowd.scene import Policy
from components.crowd.social_force import SocialForce
from components.crowd.steering import Recipe, Steering

PolicyName = Literal[
    "orca",
    "social_force",
    "foe",
    "generic",
    "goal_reaching",
    "karamouzas",
    "moussaid",
    "paris",
    "pledestrians",
    "power_law",
    "random",
    "rvo",
    "ttca_dca",
    "van_toll",
]


def recipe(name: PolicyName) -> Recipe:
    """The costs and the optimiser of a shipped policy that is made of costs.

    Raises:
        ValueError: if it has a kernel of its own, or is not shipped.
    """
    if name in _SLOPES:
        return _SLOPES[name]
    if name in _FANS:
        relaxation_time, fan = _FANS[name]
        return Recipe(costs=({"name": name},), optimiser=fan, relaxation_time=relaxation_time)
    raise ValueError(f"'{name}' is not made of costs, expected one of {', '.join(RECIPES)}")


def make_policy(policy: PolicyName | Recipe, *, time_horizon: float | NDArray[np.float64]) -> Policy:
    """The policy of a name or a recipe; `time_horizon` is that of `orca`, everybody's or (N,) of each [s]."""
    if policy == "orca":
        return Orca(time_horizon=time_horizon)
    if policy == "social_force":
        return SocialForce()
    return Steering(policy if isinstance(policy, Recipe) else recipe(policy))


_SLOPES: dict[str, Recipe] = {
    "foe": Recipe(
        optimiser="gradient",
        relaxation_time=0.5,
        costs=({"name": "foe", "coefficient": 3.0}, {"name": "goal_reaching"}, {"name": "wall_repulsion"}),
    ),
    "goal_reaching": Recipe(optimiser="gradient", relaxation_time=0.5, costs=({"name": "goal_reaching"},)),
    "power_law": Recipe(
        optimiser="gradient", relaxation_time=0.5, costs=({"name": "power_law"}, {"name": "goal_reaching"})
    ),
    "ttca_dca": Recipe(
        optimiser="gradient", costs=({"name": "ttca_dca", "coefficient": 20.0}, {"name": "wall_repulsion"})
    ),
}
"""policies that go down the slope"""

_FANS: dict[str, tuple[float, RegularSampling | RandomSampling]] = {
    "generic": (0.0, RegularSampling(sampling="regular")),
    "karamouzas": (
        0.0,
        RegularSampling(sampling="regular", radius="max_speed", speeds=15, angles=19, include_base=True),
    ),
    "moussaid": (0.5, RegularSampling(sampling="regular", speeds=5, angles=19)),
    "paris": (0.0, RegularSampling(sampling="regular", radius="max_speed", angle_deg=360.0, speeds=4, angles=36)),
    "pledestrians": (
        0.5,
        RegularSampling(sampling="regular", radius="max_speed", angle_deg=360.0, speeds=4, angles=36),
    ),
    "random": (0.0, RegularSampling(sampling="regular")),
    "rvo": (
        0.0,
        RandomSampling(sampling="random", samples=250, base="velocity", radius="max_acceleration", angle_deg=360.0),
    ),
    "van_toll": (0.25, RegularSampling(sampling="regular", speeds=2, angles=19)),
}
"""policies of one cost that try velocities: relaxation time [s] and fan"""

RECIPES = (*_SLOPES, *_FANS)
"""the shipped policies that are made of costs"""
