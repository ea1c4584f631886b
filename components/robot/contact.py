"""Contacts of one robot: what each was like when the two met, how long it lasts, and how hard it was.

dE = mu v^2 / 2, mu = 1 / (1/m_ref + 1/m_rob), where v is the speed at which the centres approach when they meet
(Grzeskowiak et al., "Crowd against the machine", 2021, section "Collision assessment").
Not in the paper: a wall has no finite mass, so mu is the robot's own. A contact that is lost and found again within a
step, or from one step to the next, is one contact: else a robot at somebody's heels would collide many times a second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from components.robot.surroundings import Obstacle
from crowdcosim.messages import Contacts, Header


def impact_energy(approach_speed: float, reflected_mass: float, robot_mass: float) -> float:
    """Energy [J] that a collision absorbs, and may give back: 0 if the two recede (`approach_speed` [m/s] below 0).

    `reflected_mass` of what was hit [kg], 0 for a wall, which gives way to nothing; `robot_mass` [kg].
    """
    if approach_speed <= 0.0:
        return 0.0
    if reflected_mass == 0.0:
        return 0.5 * robot_mass * approach_speed**2
    return 0.5 * approach_speed**2 / (1.0 / reflected_mass + 1.0 / robot_mass)


def part_of_rim(normal: tuple[float, float], heading: float) -> int:
    """The quarter of a robot's rim (a constant of `Contacts`) in the direction `normal`, at a `heading` [rad]."""
    bearing = math.atan2(normal[1], normal[0]) - heading
    return _QUARTERS[round(bearing / (0.5 * math.pi)) % 4]


_QUARTERS = (Contacts.FRONT, Contacts.LEFT, Contacts.REAR, Contacts.RIGHT)


@dataclass(slots=True, kw_only=True)
class _Contact:
    obstacle: Obstacle
    robot_part: int
    striker: int
    relative_velocity: tuple[float, float]
    approach_speed: float
    robot_closing_speed: float
    energy: float
    position: tuple[float, float]
    normal: tuple[float, float]
    steps: int = 0


class ContactLog:
    """The contacts of the step under way, and those of the step before it."""

    def __init__(self, *, robot: str, mass: float, radius: float) -> None:
        """`mass` [kg] and `radius` [m] of the robot whose contacts these are."""
        self._robot = robot
        self._mass = mass
        self._radius = radius
        self._before: dict[tuple[int, int], _Contact] = {}
        self._now: dict[tuple[int, int], _Contact] = {}

    def touch(
        self,
        obstacle: Obstacle,
        position: tuple[float, float],
        heading: float,
        normal: tuple[float, float],
        velocity: tuple[float, float],
    ) -> None:
        """Note that the robot at `position` [m], heading there [rad], touches `obstacle` in the direction `normal`.

        `velocity` of the robot [m/s], and that of the obstacle, count when this is how they meet.
        """
        key = (obstacle.kind, obstacle.agent)
        contact = self._now.get(key)
        if contact is None and (contact := self._before.get(key)) is not None:
            contact.steps += 1
        if contact is None:
            mine = velocity[0] * normal[0] + velocity[1] * normal[1]
            theirs = -(obstacle.vx * normal[0] + obstacle.vy * normal[1])
            speed = mine + theirs
            contact = _Contact(
                obstacle=obstacle,
                robot_part=part_of_rim(normal, heading),
                striker=Contacts.BY_ROBOT * (mine > 0.0) + Contacts.BY_OTHER * (theirs > 0.0),
                relative_velocity=(obstacle.vx - velocity[0], obstacle.vy - velocity[1]),
                approach_speed=speed,
                robot_closing_speed=mine,
                energy=impact_energy(speed, obstacle.reflected_mass, self._mass),
                position=position,
                normal=normal,
            )
        contact.position = (position[0] + self._radius * normal[0], position[1] + self._radius * normal[1])
        contact.normal = normal
        self._now[key] = contact

    def close_step(self, header: Header, dt: float) -> Contacts:
        """The contacts of the step that ends at `header`'s time, `dt` [s] after the one before, by kind and agent."""
        contacts = [self._now[key] for key in sorted(self._now)]
        self._before, self._now = self._now, {}
        if not contacts:
            return Contacts(header=header, robot=self._robot, **_NONE)
        return Contacts(
            header=header,
            robot=self._robot,
            kind=np.array([c.obstacle.kind for c in contacts], np.uint8),
            agent=np.array([c.obstacle.agent for c in contacts], np.uint32),
            body_part=np.array([c.obstacle.body_part for c in contacts], np.uint8),
            robot_part=np.array([c.robot_part for c in contacts], np.uint8),
            striker=np.array([c.striker for c in contacts], np.uint8),
            position=np.array([c.position for c in contacts]),
            normal=np.array([c.normal for c in contacts]),
            relative_velocity=np.array([c.relative_velocity for c in contacts]),
            approach_speed=np.array([c.approach_speed for c in contacts]),
            robot_closing_speed=np.array([c.robot_closing_speed for c in contacts]),
            reflected_mass=np.array([c.obstacle.reflected_mass for c in contacts]),
            energy=np.array([c.energy for c in contacts]),
            duration=np.array([c.steps * dt for c in contacts]),
        )


# The arrays of a step without contacts, made once: most steps are such.
_NONE = {spec.name: getattr(Contacts(), spec.name) for spec in Contacts._ARRAYS}
