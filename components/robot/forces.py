"""A robot that forces move: motors pull, friction holds, and whom it hits is pushed and pushes back (pymunk).

A step is cut into 10 inner steps. In each, the drive asks for the velocity that the command and its limits allow next
(`drive.py`), friction with the floor gives it as far as it can (`rig.py`), and pymunk moves everybody and lets bodies
that meet exchange momentum. Impacts are perfectly plastic and without friction. People have the reflected mass of the
part that is touched, other robots their whole mass; both keep the velocity of the state between impacts, and what an
impact does to them lasts until the end of the step: then they are where their own component says.
So a robot is deflected as far as its wheels let it slip, and loses speed to whomever it runs into: momentum is that of
the two together, and the energy of `Contacts` is what the impact takes from it.

Not pushed apart are those who overlap when a step begins: within it, they just do not come nearer. Somebody whose
centre is within the robot's disc has no side from which to push, and does not hold it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from components.robot.bases import drive_at_start
from components.robot.contact import ContactLog
from components.robot.floor import GRIP
from components.robot.rig import Rig
from components.robot.robot_step import INNER_STEPS, RobotStep, robot_state
from components.robot.surroundings import Surroundings
from components.robot.vicinity import TOUCH, Vicinity
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, Header, RobotState, Twist
from crowdcosim.setup import Setup, time_of


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of `Forces`."""

    grip: float = GRIP
    """coefficient of friction between wheels and floor [1]"""

    def __post_init__(self) -> None:
        if not self.grip > 0.0:
            raise ValueError(f"grip is {self.grip}, expected more than zero")


class Forces(Mover):
    """Rigid bodies with friction: it is slowed, stopped or shoved by what it meets, and may skid."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> RobotStep:
        """The robot at its start pose, at rest.

        Raises ValueError if the component belongs to no robot, ComponentError if that lacks a measure.
        """
        robot = setup.own_robot
        self._setup, self._robot = setup, robot
        self._h = setup.dt / INNER_STEPS
        self._time = 0
        self._drive = drive_at_start(robot)
        self._vicinity = Vicinity(setup)
        self._surroundings = Surroundings(setup.world, movable=True)
        self._rig = Rig(self._surroundings.space, robot, self._drive, self._config.grip)
        self._log = ContactLog(robot=robot.name, mass=robot.model.mass, radius=robot.model.radius)
        return self._output()

    def step(self, twist: Twist, crowd: Crowd, others: tuple[RobotState, ...]) -> RobotStep:
        self._look_around(crowd, others)
        for _ in range(INNER_STEPS):
            self._rig.pull(self._drive.plan(twist, self._h))
            self._advance()
        self._time += self._setup.period
        return self._output()

    def _look_around(self, crowd: Crowd, others: tuple[RobotState, ...]) -> None:
        """Set out whatever the robot may touch in this step, and note what touches it already."""
        drive, dt = self._drive, self._setup.dt
        speed = max(math.hypot(*drive.velocity), drive.top_speed) + self._robot.model.max_acceleration * dt
        obstacles = self._vicinity.obstacles(drive.x, drive.y, crowd, others, speed)
        self._surroundings.place(obstacles)
        reach = self._robot.model.radius + speed * dt + TOUCH
        self._unhindered = not self._surroundings.near(drive.x, drive.y, reach, dt)
        self._note(self._drive.velocity)
        self._surroundings.shrink(drive.x, drive.y, self._robot.model.radius)

    def _advance(self) -> None:
        before = self._drive.velocity
        self._surroundings.advance(self._h)
        self._rig.read()
        self._note(before)
        self._surroundings.update()

    def _note(self, velocity: tuple[float, float]) -> None:
        """Log all that touch the robot, which had this `velocity` [m/s] until now."""
        if self._unhindered:
            return
        drive = self._drive
        for obstacle, _, nx, ny in self._surroundings.near(drive.x, drive.y, self._robot.model.radius + TOUCH, 0.0):
            self._log.touch(obstacle, (drive.x, drive.y), drive.heading, (nx, ny), velocity)

    def _output(self) -> RobotStep:
        header = Header(stamp=time_of(self._time), frame_id="map")
        contacts = self._log.close_step(header, self._setup.dt)
        return RobotStep(state=robot_state(self._robot, self._drive, header), contacts=contacts)
