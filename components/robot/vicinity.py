"""Who a robot may touch in one step: of all people and robots, those who can come that near."""

from __future__ import annotations

import math

import numpy as np

from components.robot.body_part import REFLECTED_MASS, TouchedPart
from components.robot.surroundings import Obstacle
from crowdcosim.messages import Contacts, Crowd, RobotState
from crowdcosim.setup import Setup

TOUCH = 1e-3
"""surfaces this near touch: more than rounding and what a tangent plane leaves out, less than what matters [m]"""


class Vicinity:
    """Looks around for one robot, across the seam where that is nearer."""

    def __init__(self, setup: Setup) -> None:
        """Raises ValueError if the component belongs to no robot."""
        self._setup = setup
        self._robot = setup.own_robot
        self._robot_of = {other.name: other for other in setup.robots}
        self._touched_part = TouchedPart(self._robot.model.height)

    def obstacles(
        self, x: float, y: float, crowd: Crowd, others: tuple[RobotState, ...], top_speed: float
    ) -> list[Obstacle]:
        """The people and robots that a robot at (x, y) [m] may touch in this step at `top_speed` [m/s]."""
        return self._people(x, y, crowd, top_speed) + self._robots(x, y, others, top_speed)

    def _people(self, x: float, y: float, crowd: Crowd, top_speed: float) -> list[Obstacle]:
        """The people whom the robot may touch in this step, in the image next to it."""
        model = self._robot.model
        position = np.array((x, y))
        way = self._setup.world.displacement(position, crowd.position)
        gap = np.hypot(way[:, 0], way[:, 1]) - crowd.radius - model.radius
        closing = np.hypot(crowd.velocity[:, 0], crowd.velocity[:, 1]) + top_speed
        obstacles = []
        for k in np.flatnonzero(gap <= closing * self._setup.dt + TOUCH).tolist():
            part = self._touched_part(crowd, k, way[k])
            obstacles.append(
                Obstacle(
                    kind=Contacts.PERSON,
                    agent=int(crowd.id[k]),
                    body_part=part,
                    reflected_mass=REFLECTED_MASS[part],
                    x=float(x + way[k, 0]),
                    y=float(y + way[k, 1]),
                    vx=float(crowd.velocity[k, 0]),
                    vy=float(crowd.velocity[k, 1]),
                    radius=float(crowd.radius[k]),
                )
            )
        return obstacles

    def _robots(self, x: float, y: float, others: tuple[RobotState, ...], top_speed: float) -> list[Obstacle]:
        """The robots that this one may touch in this step, in the image next to it."""
        position = np.array((x, y))
        obstacles = []
        for other in others:
            dx, dy = self._setup.world.displacement(position, other.position).tolist()
            vx, vy = other.velocity.tolist()
            gap = math.hypot(dx, dy) - other.radius - self._robot.model.radius
            if gap > (math.hypot(vx, vy) + top_speed) * self._setup.dt + TOUCH:
                continue
            robot = self._robot_of[other.name]
            obstacles.append(
                Obstacle(
                    kind=Contacts.ROBOT,
                    agent=robot.number,
                    reflected_mass=robot.model.mass,
                    x=x + dx,
                    y=y + dy,
                    vx=vx,
                    vy=vy,
                    radius=other.radius,
                )
            )
        return obstacles
