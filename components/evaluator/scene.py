"""What metrics look at: the state as one robot sees it, and the step between two states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crowdcosim.messages import Contacts, Crowd, RobotState
from crowdcosim.world import World


@dataclass(frozen=True, kw_only=True)
class View:
    """The committed state around one robot."""

    world: World
    robot: RobotState
    crowd: Crowd

    @cached_property
    def distance(self) -> NDArray[np.float64]:
        """(N,) from the robot's centre to each person's, across the seam where that is shorter [m]."""
        d = self.world.displacement(self.robot.position, self.crowd.position)
        return np.hypot(d[:, 0], d[:, 1])

    @cached_property
    def closest(self) -> float:
        """Distance to the nearest person, centre to centre, infinite if there is nobody [m]."""
        return float(np.minimum.reduce(self.distance, initial=np.inf))


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


def turn(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) angle between two headings the short way round, 0 to pi [rad]."""
    return np.abs(np.remainder(after - before + np.pi, 2 * np.pi) - np.pi)
