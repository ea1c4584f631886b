"""The paper's metrics as its authors' code has them, where that differs from the paper's text.

Not among the metrics that an evaluator computes unless it is asked to: `metrics: [..., authors]`.
"""

from __future__ import annotations

import math

import numpy as np

from components.evaluator.flow import Mean
from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, arrival, people, reference
from components.evaluator.scene import Step

NEIGHBOUR_RANGE = 2.0
"""[m]; the paper has 1"""
TELEPORT = 5.0
"""a step this long or longer is a teleport and counts as none [m]"""


class SecondDifferences:
    """Sum over the second differences of x, y [m] and of the heading in degrees, which goes on beyond 180."""

    def __init__(self) -> None:
        self.sum = 0.0
        self._last: tuple[float, float, float] | None = None

    def add(self, step: Step) -> None:
        before, after = step.before.robot, step.after.robot
        dx, dy = (after.position - before.position).tolist()
        if math.hypot(dx, dy) >= TELEPORT:
            dx = dy = 0.0
        turn = math.degrees(math.remainder(after.heading - before.heading, 2 * math.pi))
        if self._last is not None:
            self.sum += abs(dx - self._last[0]) + abs(dy - self._last[1]) + abs(turn - self._last[2])
        self._last = (dx, dy, turn)


class WiderFlow:
    """Sums over people's speed and rate of turn, with neighbours within 2 m."""

    def __init__(self) -> None:
        self.speed, self.speed_near, self.turn, self.turn_near = Mean(), Mean(), Mean(), Mean()

    def add(self, step: Step) -> None:
        speed, rate, stayed = step.people.speed, step.people.turn_rate, step.people.stayed
        near = step.after.around.distance <= NEIGHBOUR_RANGE
        self.speed.add(float(np.add.reduce(speed)), len(speed))
        self.turn.add(float(np.add.reduce(rate)), int(np.count_nonzero(stayed)))
        self.speed_near.add(float(np.add.reduce(speed[near])), int(np.count_nonzero(near)))
        self.turn_near.add(float(np.add.reduce(rate[near])), int(np.count_nonzero(stayed & near)))


@metric(symbol="J authors", unit="1", direction="lower")
def velocity_variation_authors(differences: SecondDifferences) -> float:
    """Second differences of x, y and heading in degrees, absolute, summed.

    Metres and degrees add up as numbers, and more in smaller steps. A teleport of 5 m or more counts as no motion.
    """
    return differences.sum


@metric(symbol="J/Jcr authors", unit="1", direction="higher", needs=(reference, arrival))
def velocity_variation_ratio_authors(run: Run, differences: SecondDifferences) -> float | Invalid:
    """J of the authors' code, alone over in the crowd.

    No value at the time limit, nor where nothing varied.
    """
    alone = (run.reference or {}).get("velocity_variation_authors")
    if alone is None:
        return Invalid(reason="the reference run has no 'velocity_variation_authors'")
    return alone / differences.sum if differences.sum > 0 else Invalid(reason="nothing varied in the crowd")


@metric(symbol="NBR vel. 2 m", unit="1", direction="higher", needs=(people,))
def neighbour_velocity_authors(flow: WiderFlow) -> float | Invalid:
    """Speed of the people within 2 m of the robot over that of all people.

    As NBR vel. of the paper, which has 1 m.
    """
    if not flow.speed_near.count:
        return Invalid(reason="nobody came within 2 m of the robot")
    return flow.speed_near.value / flow.speed.value if flow.speed.sum else Invalid(reason="nobody moved")


@metric(symbol="NBR reac. 2 m", unit="1", direction="higher", needs=(people,))
def neighbour_reaction_authors(flow: WiderFlow) -> float | Invalid:
    """Rate of turn of all people over that of those within 2 m of the robot.

    As NBR reac. of the paper, which has 1 m.
    """
    if not flow.turn_near.sum:
        return Invalid(reason="nobody within 2 m of the robot turned")
    return flow.turn.value / flow.turn_near.value
