"""A disc on wheels among obstacles: whatever drives it, it is stopped or deflected by what it drives at.

A step is cut into 10 inner steps of length h. In each, the drive plans its motion d, the others are taken to go on at
their committed velocity u, and all that is within reach is looked up in pymunk. With the unit vector n towards an
obstacle and the gap g to it, the two meet if g <= 0 or n.(d - u h) > g, after the share g / n.(d - u h) of the inner
step. If the robot drives at the obstacle (n.d > 0), the drive says what is left of the motion (`Drive.left_of`): a
differential or car-like one stops there, a holonomic one goes on along the obstacle; if not, it drives on. It is never
pushed, and may always drive away. The plane that touches an obstacle stands for it; it lies before the obstacle, so
that nothing is driven through at any speed.

After Grzeskowiak et al., "Crowd against the machine", 2021: walls stop the robot, and who drives straight stays on
that line. Not in the paper: what contact does. As in its authors' simulator, the robot stands until contact ends; but
who is behind it, or within its disc and not ahead, does not hold it. Another robot that drives at this one stops where
they meet: both compute that from the same old states and agree, but for what new commands change within the step.
The robot itself does not wrap around: its position goes on beyond a seam, across which it touches people and robots.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from components.robot.body_part import REFLECTED_MASS, TouchedPart
from components.robot.car import CarDrive
from components.robot.contact import ContactLog
from components.robot.differential import DifferentialDrive
from components.robot.drive import ALONG, Bound, Drive, Motion
from components.robot.holonomic import HolonomicDrive
from components.robot.surroundings import Obstacle, Surroundings
from crowdcosim.messages import Contacts, Crowd, Header, RobotState
from crowdcosim.setup import Setup, time_of

INNER_STEPS = 10

# Surfaces this near touch [m]: more than rounding and what the tangent plane leaves out, less than what matters.
_TOUCH = 1e-3

_DRIVES: dict[str, type[Drive]] = {"differential": DifferentialDrive, "holonomic": HolonomicDrive, "car": CarDrive}


class RobotStep(NamedTuple):
    """What a robot's body says at the end of a step."""

    state: RobotState
    contacts: Contacts


class Chassis:
    """Carries out the motions that `drive` plans, as far as nothing is in the way, and logs the contacts."""

    def __init__(self, setup: Setup) -> None:
        """At the start pose, at rest. Raises ValueError if the component belongs to no robot."""
        robot = setup.own_robot
        self._setup = setup
        self._robot = robot
        self._time = 0
        self._unhindered = False
        self._robot_of = {other.name: other for other in setup.robots}
        self.drive = _DRIVES[robot.model.base.kind](
            model=robot.model,
            x=robot.start.x,
            y=robot.start.y,
            heading=math.remainder(robot.start.heading, 2.0 * math.pi),
        )
        self._touched_part = TouchedPart(robot.model.height)
        self._surroundings = Surroundings(setup.world)
        self._log = ContactLog(robot=robot.name, mass=robot.model.mass, radius=robot.model.radius)

    def begin_step(self, crowd: Crowd, others: tuple[RobotState, ...], top_speed: float) -> None:
        """Look around for whatever the robot may touch in this step at `top_speed` [m/s]: walls, people, robots."""
        obstacles = self._people(crowd, top_speed) + self._robots(others, top_speed)
        self._surroundings.place(obstacles)
        reach = self._robot.model.radius + top_speed * self._setup.dt + _TOUCH
        self._unhindered = not (obstacles or self._surroundings.near(self.drive.x, self.drive.y, reach, h=0.0))

    def move(self, motion: Motion, h: float) -> None:
        """One inner step of `h` [s]."""
        if self._unhindered:
            self.drive.move(motion)
        else:
            self._move_among_obstacles(motion, h)

    def touches(self, way: float) -> bool:
        """True if something touches the robot in the direction of its heading (`way` > 0), or behind (`way` < 0)."""
        if self._unhindered:
            return False
        drive = self.drive
        ahead_x, ahead_y = way * math.cos(drive.heading), way * math.sin(drive.heading)
        near = self._surroundings.near(drive.x, drive.y, self._robot.model.radius + _TOUCH, h=0.0)
        return any(nx * ahead_x + ny * ahead_y > ALONG for _, _, nx, ny in near)

    def end_step(self) -> RobotStep:
        """State and contacts after the last inner step."""
        self._time += self._setup.period
        return self.output()

    def output(self) -> RobotStep:
        """State and contacts now."""
        drive = self.drive
        header = Header(stamp=time_of(self._time), frame_id="map")
        state = RobotState(
            header=header,
            name=self._robot.name,
            position=np.array((drive.x, drive.y)),
            heading=drive.heading,
            velocity=np.array(drive.velocity),
            angular_velocity=drive.turn_rate,
            radius=self._robot.model.radius,
        )
        return RobotStep(state=state, contacts=self._log.close_step(header, self._setup.dt))

    def _move_among_obstacles(self, motion: Motion, h: float) -> None:
        drive = self.drive
        velocity = drive.velocity
        reach = self._robot.model.radius + math.hypot(motion.dx, motion.dy) + _TOUCH
        near = self._surroundings.near(drive.x, drive.y, reach, h)
        bounds = [self._bound(motion, *obstacle, h) for obstacle in near]
        until = min(drive.stops_after(motion, bounds), 1.0)
        left = drive.left_of(motion, bounds, h)
        drive.move(left)
        for (obstacle, distance, nx, ny), bound in zip(near, bounds, strict=True):
            met = bound.share <= until
            closing = nx * left.dx + ny * left.dy - (nx * obstacle.vx + ny * obstacle.vy) * h
            if met or distance - self._robot.model.radius - closing <= _TOUCH:
                self._log.touch(obstacle, (drive.x, drive.y), drive.heading, (nx, ny), velocity)
            # A robot that drives at this one stops where they meet, if this one is still on its way.
            if met and obstacle.kind == Contacts.ROBOT and nx * obstacle.vx + ny * obstacle.vy < 0.0:
                self._surroundings.halt(obstacle, bound.share * h)
        self._surroundings.advance(h)

    def _bound(self, motion: Motion, obstacle: Obstacle, distance: float, nx: float, ny: float, h: float) -> Bound:
        """What an obstacle at `distance` [m] in the direction (nx, ny) leaves of `motion`."""
        gap = distance - self._robot.model.radius
        mine = nx * motion.dx + ny * motion.dy
        theirs = (nx * obstacle.vx + ny * obstacle.vy) * h
        most = max(gap + theirs, 0.0)
        if 0.0 < gap >= mine - theirs:
            return Bound(nx, ny, most, math.inf)
        return Bound(nx, ny, most, gap / (mine - theirs) if gap > 0.0 else 0.0)

    def _people(self, crowd: Crowd, top_speed: float) -> list[Obstacle]:
        """The people whom the robot may touch in this step, in the image next to it."""
        model = self._robot.model
        position = np.array((self.drive.x, self.drive.y))
        way = self._setup.world.displacement(position, crowd.position)
        gap = np.hypot(way[:, 0], way[:, 1]) - crowd.radius - model.radius
        closing = np.hypot(crowd.velocity[:, 0], crowd.velocity[:, 1]) + top_speed
        obstacles = []
        for k in np.flatnonzero(gap <= closing * self._setup.dt + _TOUCH).tolist():
            part = self._touched_part(crowd, k, way[k])
            obstacles.append(
                Obstacle(
                    kind=Contacts.PERSON,
                    agent=int(crowd.id[k]),
                    body_part=part,
                    reflected_mass=REFLECTED_MASS[part],
                    x=float(position[0] + way[k, 0]),
                    y=float(position[1] + way[k, 1]),
                    vx=float(crowd.velocity[k, 0]),
                    vy=float(crowd.velocity[k, 1]),
                    radius=float(crowd.radius[k]),
                )
            )
        return obstacles

    def _robots(self, others: tuple[RobotState, ...], top_speed: float) -> list[Obstacle]:
        """The robots that this one may touch in this step, in the image next to it."""
        position = np.array((self.drive.x, self.drive.y))
        obstacles = []
        for other in others:
            dx, dy = self._setup.world.displacement(position, other.position).tolist()
            vx, vy = other.velocity.tolist()
            gap = math.hypot(dx, dy) - other.radius - self._robot.model.radius
            if gap > (math.hypot(vx, vy) + top_speed) * self._setup.dt + _TOUCH:
                continue
            robot = self._robot_of[other.name]
            obstacles.append(
                Obstacle(
                    kind=Contacts.ROBOT,
                    agent=robot.number,
                    reflected_mass=robot.model.mass,
                    x=self.drive.x + dx,
                    y=self.drive.y + dy,
                    vx=vx,
                    vy=vy,
                    radius=other.radius,
                )
            )
        return obstacles
