"""How the robot travelled: time, path and smoothness, absolute and against the robot alone.

Grzeskowiak et al. 2021, "Crowd against the machine", section IV-C: path efficiency. "cr" marks the run in the crowd,
no subscript the reference run of the robot alone: 1 where the crowd changes nothing, less as it costs more.

Not in the paper: what a run that hits the time limit gives. Here T goes on to the limit, and T/Tcr with it. L/Lcr and
J/Jcr have no value then: a robot that freezes at once would have the best path of all.
"""

from __future__ import annotations

import math

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, arrival, duration, reference
from components.evaluator.scene import Step
from crowdcosim.messages import RobotState

LEVER = 1.0
"""Makes a change of turn rate one of velocity: that of a point this far from the axis [m]."""


class Travel:
    """Sums over the robot's own motion."""

    def __init__(self) -> None:
        self.length = 0.0
        """of the polygon through the centre's positions [m]"""
        self.variation = 0.0
        """sum of the changes of velocity, linear and `LEVER` times angular [m/s]"""

    def add(self, step: Step) -> None:
        before, after = step.before.robot, step.after.robot
        dx, dy = step.after.world.displacement(before.position, after.position).tolist()
        self.length += math.hypot(dx, dy)
        (u0, w0), (u1, w1) = body_velocity(before), body_velocity(after)
        self.variation += math.hypot(u1 - u0, w1 - w0)
        self.variation += LEVER * abs(after.angular_velocity - before.angular_velocity)


def body_velocity(robot: RobotState) -> tuple[float, float]:
    """Velocity in the robot's own frame, forward and to the left [m/s]; in the map's, every turn would count twice."""
    x, y = robot.velocity.tolist()
    c, s = math.cos(robot.heading), math.sin(robot.heading)
    return x * c + y * s, y * c - x * s


@metric(symbol="T", unit="s", direction="lower")
def time(run: Run) -> float:
    """Time to the goal.

    At the time limit it is the episode's whole length.
    """
    return run.time


@metric(symbol="L", unit="m", direction="lower")
def path_length(travel: Travel) -> float:
    """Length of the path.

    L = sum |p_k - p_(k-1)|. At the time limit it is that of the unfinished journey.
    """
    return travel.length


@metric(symbol="J", unit="m/s", direction="lower")
def velocity_variation(travel: Travel) -> float:
    """Summed variation of linear and angular velocity.

    J = sum |v_k - v_(k-1)| + l |w_k - w_(k-1)|, v in the robot's frame. It is a total variation: smaller steps leave it
    as it is. At the time limit it is that of the unfinished journey.
    Not in the paper: how linear and angular velocity add up, so a lever l of 1 m makes the units agree.
    Differs from the authors' code, which sums second differences of x, y and heading in degrees.
    """
    return travel.variation


@metric(symbol="T/Tcr", unit="1", direction="higher", needs=(reference, duration))
def time_ratio(run: Run) -> float | Invalid:
    """Time to the goal, alone over in the crowd.

    At the time limit Tcr is the limit, and the ratio an upper bound of what it would have been.
    """
    return _ratio(run, "time", run.time)


@metric(symbol="L/Lcr", unit="1", direction="higher", needs=(reference, arrival))
def path_length_ratio(run: Run, travel: Travel) -> float | Invalid:
    """Length of the path to the goal, alone over in the crowd.

    No value at the time limit.
    """
    return _ratio(run, "path_length", travel.length)


@metric(symbol="J/Jcr", unit="1", direction="higher", needs=(reference, arrival))
def velocity_variation_ratio(run: Run, travel: Travel) -> float | Invalid:
    """Variation of velocity on the way to the goal, alone over in the crowd.

    No value at the time limit, nor where the velocity never varied.
    """
    return _ratio(run, "velocity_variation", travel.variation)


def _ratio(run: Run, name: str, value: float) -> float | Invalid:
    alone = (run.reference or {}).get(name)
    if alone is None:
        return Invalid(reason=f"the reference run has no '{name}'")
    return alone / value if value > 0 else Invalid(reason=f"'{name}' is 0 in the crowd")
