"""What metrics look at: the state as one robot sees it, and the step between two states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from components.evaluator.look import Look, look
from crowdcosim.messages import Contacts, Crowd, RobotState
from crowdcosim.world import World


@dataclass(frozen=True, kw_only=True)
class View:
    """The committed state around one robot."""

    world: World
    robot: RobotState
    crowd: Crowd

    @cached_property
    def around(self) -> Look:
        """The people, as this robot has them around it."""
        (x, y), (vx, vy) = self.robot.position.tolist(), self.robot.velocity.tolist()
        crowd = self.crowd
        place = (x, y, vx, vy, self.robot.radius)
        return look(place, crowd.position, crowd.velocity, crowd.heading, crowd.radius, self.world.period)


@dataclass(frozen=True, kw_only=True)
class CrowdStep:
    """How the people moved between two committed states; all robots share it. Arrays are over the N people after it."""

    dt: float
    """[s]"""
    before: Crowd
    after: Crowd

    @cached_property
    def speed(self) -> NDArray[np.float64]:
        """(N,) speed at the end of the step [m/s]."""
        return np.hypot(self.after.velocity[:, 0], self.after.velocity[:, 1])

    @cached_property
    def _same_people(self) -> bool:
        return np.array_equal(self.before.id, self.after.id)

    @cached_property
    def stayed(self) -> NDArray[np.bool_]:
        """(N,) True for those who were there before the step too."""
        if self._same_people:
            return np.ones(len(self.after.id), np.bool_)
        return np.isin(self.after.id, self.before.id)

    @cached_property
    def turn_rate(self) -> NDArray[np.float64]:
        """(N,) mean absolute rate of turn over the step, 0 for those who have just come [rad/s]."""
        if self._same_people:
            return turn(self.before.heading, self.after.heading) / self.dt
        rate = np.zeros(len(self.after.id))
        _, i, j = np.intersect1d(self.before.id, self.after.id, assume_unique=True, return_indices=True)
        rate[j] = turn(self.before.heading[i], self.after.heading[j]) / self.dt
        return rate


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step of one robot: where it was, where it is, and what touched it on the way."""

    before: View
    after: View
    people: CrowdStep
    contacts: Contacts | None
    """None if nobody reports this robot's contacts"""

    @property
    def dt(self) -> float:
        """Its length [s]."""
        return self.people.dt


def turn(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) angle between two headings the short way round, 0 to pi [rad]."""
    return np.abs(np.remainder(after - before + np.pi, 2 * np.pi) - np.pi)
