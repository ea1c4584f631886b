"""What the robot does to the crowd's flow: how people near it walk and turn, against everybody.

Grzeskowiak et al. 2021, "Crowd against the machine", section IV-C: effects on the crowd flow.

Not in the paper: how averages are taken. Here every person counts once per step, at its end, until the robot arrives;
the crowd includes the neighbours; distances are centre to centre, as the paper's "distance to the closest agent" comes
from positions of agents. Without a neighbour in the whole run there is no value. The time limit changes nothing.
"""

from __future__ import annotations

import numpy as np

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, people
from components.evaluator.scene import Step

NEIGHBOUR_RANGE = 1.0
"""Neighbours are at most this far from the robot, centre to centre [m]; the authors' code has 2."""


ROUNDING = 1e-6
"""a mean rate of turn below this is rounding of headings, and no turning [rad/s]"""


class Mean:
    """A running mean."""

    def __init__(self) -> None:
        self.sum = 0.0
        self.count = 0

    def add(self, total: float, count: int) -> None:
        self.sum += total
        self.count += count

    @property
    def value(self) -> float:
        """The mean so far, 0 of nothing."""
        return self.sum / self.count if self.count else 0.0


class Flow:
    """Sums over people's speed and rate of turn."""

    def __init__(self) -> None:
        self.speed = Mean()
        """everybody's [m/s]"""
        self.speed_near = Mean()
        """the neighbours' [m/s]"""
        self.turn_rate = Mean()
        """everybody's, absolute; those who have just come have none [rad/s]"""
        self.turn_rate_near = Mean()
        """the neighbours' [rad/s]"""

    def add(self, step: Step) -> None:
        speed, rate, stayed = step.people.speed, step.people.turn_rate, step.people.stayed
        self.speed.add(float(np.add.reduce(speed)), len(speed))
        self.turn_rate.add(float(np.add.reduce(rate)), int(np.count_nonzero(stayed)))
        near = np.flatnonzero(step.after.around.distance <= NEIGHBOUR_RANGE)
        if near.size:
            self.speed_near.add(float(np.add.reduce(speed[near])), near.size)
            self.turn_rate_near.add(float(np.add.reduce(rate[near])), int(np.count_nonzero(stayed[near])))


@metric(symbol="NBR vel.", unit="1", direction="higher", needs=(people,))
def neighbour_velocity(flow: Flow) -> float | Invalid:
    """Speed of the people near the robot over that of all people.

    V_neighbours / V_all, means over people and time. No value without a neighbour or if nobody moved.
    """
    if not flow.speed_near.count:
        return Invalid(reason="nobody came within 1 m of the robot")
    if not flow.speed.sum:
        return Invalid(reason="nobody moved")
    return flow.speed_near.value / flow.speed.value


@metric(symbol="NBR reac.", unit="1", direction="higher", needs=(people,))
def neighbour_reaction(flow: Flow) -> float | Invalid:
    """Rate of turn of all people over that of those near the robot.

    w_all / w_neighbours, means over people and time of the heading's absolute change over a step, the short way round,
    divided by the step. No value without a neighbour or if no neighbour turned.
    """
    if not flow.speed_near.count:
        return Invalid(reason="nobody came within 1 m of the robot")
    if flow.turn_rate_near.value < ROUNDING:
        return Invalid(reason="nobody within 1 m of the robot turned")
    return flow.turn_rate.value / flow.turn_rate_near.value
