"""A robot that follows its command exactly, within its limits, until something is in its way (`chassis.py`)."""

from __future__ import annotations

from components.robot.chassis import Chassis
from components.robot.robot_step import INNER_STEPS, RobotStep
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, RobotState, Twist
from crowdcosim.setup import Setup


class Kinematic(Mover):
    """A base that obeys at once, within its limits: differential, holonomic or car-like, as its robot file says."""

    def reset(self, setup: Setup) -> RobotStep:
        """The robot at its start pose, at rest. Raises ValueError if the component belongs to no robot."""
        self._h = setup.dt / INNER_STEPS
        self._chassis = Chassis(setup)
        return self._chassis.output()

    def step(self, twist: Twist, crowd: Crowd, others: tuple[RobotState, ...]) -> RobotStep:
        chassis = self._chassis
        chassis.begin_step(crowd, others, chassis.drive.top_speed)
        for _ in range(INNER_STEPS):
            chassis.move(chassis.drive.plan(twist, self._h), self._h)
        return chassis.end_step()
