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

from components.robot.bases import drive_at_start
from components.robot.contact import ContactLog
from components.robot.drive import ALONG, Bound, Motion
from components.robot.robot_step import RobotStep, robot_state
from components.robot.surroundings import Obstacle, Surroundings
from components.robot.vicinity import TOUCH, Vicinity
from crowdcosim.messages import Contacts, Crowd, Header, RobotState
from crowdcosim.setup import Setup, time_of


class Chassis:
    """Carries out the motions that `drive` plans, as far as nothing is in the way, and logs the contacts."""

    def __init__(self, setup: Setup) -> None:
        """At the start pose, at rest. Raises ValueError if the component belongs to no robot."""
        robot = setup.own_robot
        self._setup = setup
        self._robot = robot
        self._time = 0
        self._unhindered = False
        self.drive = drive_at_start(robot)
        self._vicinity = Vicinity(setup)
        self._surroundings = Surroundings(setup.world)
        self._log = ContactLog(robot=robot.name, mass=robot.model.mass, radius=robot.model.radius)

    def begin_step(self, crowd: Crowd, others: tuple[RobotState, ...], top_speed: float) -> None:
        """Look around for whatever the robot may touch in this step at `top_speed` [m/s]: walls, people, robots."""
        obstacles = self._vicinity.obstacles(self.drive.x, self.drive.y, crowd, others, top_speed)
        self._surroundings.place(obstacles)
        reach = self._robot.model.radius + top_speed * self._setup.dt + TOUCH
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
        near = self._surroundings.near(drive.x, drive.y, self._robot.model.radius + TOUCH, h=0.0)
        return any(nx * ahead_x + ny * ahead_y > ALONG for _, _, nx, ny in near)

    def end_step(self) -> RobotStep:
        """State and contacts after the last inner step."""
        self._time += self._setup.period
        return self.output()

    def output(self) -> RobotStep:
        """State and contacts now."""
        header = Header(stamp=time_of(self._time), frame_id="map")
        contacts = self._log.close_step(header, self._setup.dt)
        return RobotStep(state=robot_state(self._robot, self.drive, header), contacts=contacts)

    def _move_among_obstacles(self, motion: Motion, h: float) -> None:
        drive = self.drive
        velocity = drive.velocity
        reach = self._robot.model.radius + math.hypot(motion.dx, motion.dy) + TOUCH
        near = self._surroundings.near(drive.x, drive.y, reach, h)
        bounds = [self._bound(motion, *obstacle, h) for obstacle in near]
        until = min(drive.stops_after(motion, bounds), 1.0)
        left = drive.left_of(motion, bounds, h)
        drive.move(left)
        for (obstacle, distance, nx, ny), bound in zip(near, bounds, strict=True):
            met = bound.share <= until
            closing = nx * left.dx + ny * left.dy - (nx * obstacle.vx + ny * obstacle.vy) * h
            if met or distance - self._robot.model.radius - closing <= TOUCH:
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
