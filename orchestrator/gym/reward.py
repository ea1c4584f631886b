"""What a step of the environment is worth: a weighted sum of terms, and of the evaluator's metrics at the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from components.evaluator.metrics import METRICS
from crowdcosim.goal import target
from crowdcosim.messages import Contacts, Goal
from crowdcosim.world import World
from orchestrator.episode import Result
from orchestrator.errors import InputError
from orchestrator.scenario.problems import near_miss
from orchestrator.view import RobotView, View

COMFORT = 0.5
"""gap to the nearest person below which `discomfort` counts [m]"""


@dataclass(frozen=True, kw_only=True)
class Transition:
    """One step of one robot."""

    before: View
    after: View
    robot: str
    goal: Goal
    world: World
    arrived: bool
    """True in the step in which it reaches its goal"""
    timed_out: bool

    @property
    def dt(self) -> float:
        """[s]"""
        return self.after.time - self.before.time

    @property
    def now(self) -> RobotView:
        return self.after.robots[self.robot]

    @cached_property
    def clearance(self) -> float:
        """Gap between the robot's disc and the nearest person's, infinite if there is nobody [m]."""
        crowd, state = self.after.crowd, self.now.state
        if crowd is None or not len(crowd.id):
            return math.inf
        away = self.world.displacement(state.position, crowd.position)
        return float((np.hypot(away[:, 0], away[:, 1]) - crowd.radius).min()) - state.radius


def progress(step: Transition) -> float:
    """How much nearer the goal is than before [m]."""
    return _distance(step, step.before) - _distance(step, step.after)


def arrival(step: Transition) -> float:
    """1 in the step in which the robot reaches its goal."""
    return float(step.arrived)


def timeout(step: Transition) -> float:
    """1 in the step in which the time is up."""
    return float(step.timed_out)


def time(step: Transition) -> float:
    """Duration of the step [s]."""
    return step.dt


def collision(step: Transition) -> float:
    """Contacts with people that begin in the step."""
    contacts = step.now.contacts
    return float(_begun(contacts).sum()) if contacts else 0.0


def contact(step: Transition) -> float:
    """Duration of the step if a person touches the robot at its end [s]."""
    contacts = step.now.contacts
    return step.dt if contacts and (contacts.kind == Contacts.PERSON).any() else 0.0


def energy(step: Transition) -> float:
    """Energy of the contacts with people that begin in the step [J]."""
    contacts = step.now.contacts
    return float(contacts.energy[_begun(contacts)].sum()) if contacts else 0.0


def discomfort(step: Transition) -> float:
    """What the gap to the nearest person lacks of 0.5 m, times the step's duration [m s]."""
    return max(0.0, COMFORT - step.clearance) * step.dt


def variation(step: Transition) -> float:
    """Change of speed [m/s] and of turn rate [rad/s], both absolute, summed as in the metric J."""
    old, new = step.before.robots[step.robot].state, step.now.state
    return abs(math.hypot(*new.velocity.tolist()) - math.hypot(*old.velocity.tolist())) + abs(
        new.angular_velocity - old.angular_velocity
    )


TERMS: Mapping[str, Callable[[Transition], float]] = {
    term.__name__: term
    for term in (progress, arrival, timeout, time, collision, contact, energy, discomfort, variation)
}
DEFAULT: Mapping[str, float] = {"progress": 1.0, "arrival": 10.0, "collision": -1.0, "discomfort": -1.0, "time": -0.1}
"""Weights that make arriving soon, untouched and at a polite distance worth while."""


class Reward:
    """The weighted sum. A name that is no term is a metric, which counts once, at the end, if the run has such a value.

    Raises:
        InputError: if a name is neither, or a weight is not a finite number.
    """

    def __init__(self, weights: Mapping[str, float]) -> None:
        metrics = [metric.name for metric in METRICS]
        for name, weight in weights.items():
            if name not in TERMS and name not in metrics:
                raise InputError(
                    f"reward: there is no term '{name}'{near_miss(name, [*TERMS, *metrics])}; "
                    f"terms: {', '.join(TERMS)}; or a metric: {', '.join(metrics)}"
                )
            if not math.isfinite(weight):
                raise InputError(f"reward: the weight of '{name}' is {weight}, expected a finite number")
        self._terms = [(TERMS[name], weight) for name, weight in weights.items() if name in TERMS]
        self._metrics = {name: weight for name, weight in weights.items() if name not in TERMS}

    def of(self, step: Transition, result: Result | None) -> float:
        """The reward of a step; `result` is there after the last one."""
        reward = sum([weight * term(step) for term, weight in self._terms])
        for metric in result.metrics if result and self._metrics else ():
            if metric.robot == step.robot and metric.value is not None:
                reward += self._metrics.get(metric.name, 0.0) * metric.value
        return float(reward)


def _distance(step: Transition, view: View) -> float:
    position = view.robots[step.robot].state.position
    return math.hypot(*(target(step.goal, position) - position).tolist())


def _begun(contacts: Contacts) -> NDArray[np.bool_]:
    return np.asarray((contacts.kind == Contacts.PERSON) & (contacts.duration == 0.0))
