"""What is kept of one robot's run while it lasts: running sums, and the last state."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from components.evaluator.metric import Metric, Sums
from components.evaluator.run import Invalid, Run
from components.evaluator.scene import CrowdStep, Step, View
from crowdcosim import Setup
from crowdcosim.goal import reached
from crowdcosim.messages import Contacts, Goal, RobotState
from crowdcosim.robots import Robot


class Account:
    """One robot's account: open from the state at t = 0 to the state in which it has reached its goal."""

    def __init__(self, setup: Setup, robot: Robot, metrics: Iterable[Metric]) -> None:
        self.name = robot.name
        self._setup = setup
        self._goal = Goal(
            robot=robot.name,
            position=np.array([robot.goal.x, robot.goal.y]),
            direction=np.array(robot.goal.direction),
            tolerance=robot.goal.tolerance,
        )
        kinds = dict.fromkeys(kind for m in metrics for kind in m.inputs if kind is not Run)
        self._sums: dict[type, Sums] = {kind: kind() for kind in kinds}
        self._before: View | None = None
        self._arrived = False
        self._steps = 0
        self._people = 0

    def add(self, robot: RobotState, people: CrowdStep, contacts: Contacts | None) -> None:
        """Take the next committed state into account, and the step that led to it, unless the robot has arrived."""
        if self._arrived:
            return
        after = View(world=self._setup.world, robot=robot, crowd=people.after)
        if self._before is not None:
            step = Step(before=self._before, after=after, people=people, contacts=contacts)
            for sums in self._sums.values():
                sums.add(step)
            self._steps += 1
        self._people = max(self._people, len(people.after.id))
        self._before = after
        self._arrived = reached(self._goal, robot.position)

    def _left(self) -> float:
        """What is left to the goal [m]."""
        if self._before is None or self._arrived:
            return 0.0
        way = self._goal.position - self._before.robot.position
        if self._goal.direction.any():
            return max(float(way @ self._goal.direction), 0.0)
        return max(math.hypot(*way.tolist()) - self._goal.tolerance, 0.0)

    def value(self, metric: Metric) -> float | Invalid:
        """The verdict on what was seen so far."""
        reference = self._setup.reference
        run = Run(
            steps=self._steps,
            time=self._steps * self._setup.period / 1e9,  # exact up to here, where `steps * dt` would not be
            arrived=self._arrived,
            goal_distance=self._left(),
            alone=self._setup.alone,
            people=self._people,
            reference=None if reference is None else reference.get(self.name),
        )
        return metric(run, self._sums)
