"""All metrics by group, in the order in which they are printed, and how a scenario names those it wants."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from components.evaluator import arrival, authors, clearance, company, motion, strikes
from components.evaluator.collisions import colliding, collision_energy_rate, collision_rate
from components.evaluator.flow import neighbour_reaction, neighbour_velocity
from components.evaluator.metric import Metric
from components.evaluator.proximity import proximity
from components.evaluator.travel import (
    path_length,
    path_length_ratio,
    time,
    time_ratio,
    velocity_variation,
    velocity_variation_ratio,
)
from crowdcosim.component import ComponentError
from crowdcosim.loading import load_attribute

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

BASIC: tuple[Metric, ...] = (arrival.success, time, path_length, velocity_variation)
"""What ratios of the run in the crowd to the run alone are made of."""

GROUPS: dict[str, tuple[Metric, ...]] = {
    "paper": (*PAPER, collision_rate, collision_energy_rate, *BASIC),
    "task": (
        arrival.timeout,
        arrival.path_weighted_success,
        arrival.time_weighted_success,
        arrival.goal_distance,
    ),
    "motion": (
        motion.speed,
        motion.acceleration,
        motion.acceleration_max,
        motion.jerk,
        motion.jerk_max,
        motion.motion_energy,
        motion.time_not_moving,
        motion.heading_change,
        motion.path_irregularity,
    ),
    "safety": (
        strikes.collisions,
        strikes.robot_on_person,
        strikes.person_on_robot,
        strikes.collision_energy,
        strikes.collision_energy_max,
        strikes.wall_collisions,
        strikes.robot_collisions,
        clearance.near_collisions,
        clearance.near_collision_rate,
        clearance.near_collision_share,
        clearance.danger,
        clearance.clearance_min,
        clearance.clearance_mean,
        clearance.time_to_collision_min,
        clearance.imminent_collision_share,
    ),
    "comfort": (
        clearance.intimate_share,
        clearance.personal_share,
        clearance.social_share,
        company.personal_space_intrusion,
        company.social_work,
        company.closest_person_speed,
        company.density_2_5m,
        company.density_5m,
        company.density_10m,
    ),
    "authors": (
        authors.velocity_variation_ratio_authors,
        authors.velocity_variation_authors,
        authors.neighbour_velocity_authors,
        authors.neighbour_reaction_authors,
    ),
}
"""Group -> its metrics. `authors` are variants of the paper's."""

METRICS: tuple[Metric, ...] = tuple(metric for group in GROUPS.values() for metric in group)
"""Name, symbol, unit, direction and description of every metric; each knows how to compute itself."""


def chosen(names: Iterable[str]) -> tuple[Metric, ...]:
    """The metrics that a scenario asks for: groups, metrics by name, or a file's own, `./my_metric.py:name`.

    Raises:
        ValueError: if there is no such metric.
    """
    found: dict[str, Metric] = {}
    for name in names:
        for metric in _named(name):
            found.setdefault(metric.name, metric)
    return tuple(found.values())


def _named(name: str) -> tuple[Metric, ...]:
    if name in GROUPS:
        return GROUPS[name]
    known = {metric.name: metric for metric in METRICS}
    if name in known:
        return (known[name],)
    if ":" not in name:
        near = get_close_matches(name, [*GROUPS, *known], 1)
        hint = f"did you mean '{near[0]}'? " if near else ""
        raise ValueError(
            f"metrics has '{name}': {hint}expected a group ({', '.join(GROUPS)}), a metric's name, or your own as "
            "'./file.py:name'"
        )
    try:
        own = load_attribute(name)
    except ComponentError as error:
        raise ValueError(f"metrics has '{name}': {error}") from None
    if not isinstance(own, Metric):
        raise ValueError(f"metrics has '{name}': it is no metric; decorate it with components.evaluator.metric.metric")
    return (own,)
