"""All metrics, in the order in which they are printed."""

from __future__ import annotations

from components.evaluator.collisions import colliding, collision_energy_rate, collision_rate
from components.evaluator.flow import neighbour_reaction, neighbour_velocity
from components.evaluator.metric import Metric
from components.evaluator.proximity import proximity
from components.evaluator.travel import (
    path_length,
    path_length_ratio,
    success,
    time,
    time_ratio,
    velocity_variation,
    velocity_variation_ratio,
)

PAPER: tuple[Metric, ...] = (
    time_ratio,
    path_length_ratio,
    velocity_variation_ratio,
    neighbour_velocity,
    neighbour_reaction,
    proximity,
    colliding,
)
"""The seven of the paper's radar charts."""

METRICS: tuple[Metric, ...] = (
    *PAPER,
    collision_rate,
    collision_energy_rate,
    success,
    time,
    path_length,
    velocity_variation,
)
"""Name, symbol, unit, direction and description of every metric; each knows how to compute itself."""
