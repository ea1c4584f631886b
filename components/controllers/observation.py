"""What a learned policy sees: parts of an observation, each a row of numbers in the robot's frame (x ahead, y left)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from components.controllers.ego import Ego, Way
from components.controllers.surroundings import Discs
from crowdcosim.messages import LaserScan
from crowdcosim.robots import RobotModel

Array = NDArray[np.float64]

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
PERSON = 5
"""numbers per person"""


class View(NamedTuple):
    """What parts are made of."""

    ego: Ego
    way: Way
    discs: Discs
    displacement: Array
    """(N, 2) from the robot to each disc, in the nearest image of a person [m]"""
    scan: LaserScan | None
    model: RobotModel


@dataclass(frozen=True, kw_only=True)
class GoalPart:
    """Where the goal is: x and y [m]; a line is as far as its nearest point, and no farther than `range`."""

    __pydantic_config__ = _STRICT
    part: Literal["goal"]
    """the goal"""
    range: float = 10.0
    """farther goals are pulled in to this distance [m]"""
    size = 2

    def read(self, view: View) -> Array:
        """(2,) [m]"""
        # A line's way is a direction: as far as the range.
        distance = math.hypot(view.way.x, view.way.y) if view.way.weight else self.range
        bearing = view.way.bearing - view.ego.heading
        return min(self.range, distance) * np.array([math.cos(bearing), math.sin(bearing)])


@dataclass(frozen=True, kw_only=True)
class VelocityPart:
    """How the robot moves: speed [m/s] and turn rate [rad/s]."""

    __pydantic_config__ = _STRICT
    part: Literal["velocity"]
    """speed and turn rate"""
    size = 2

    def read(self, view: View) -> Array:
        """(2,) [m/s], [rad/s]"""
        return np.array([view.ego.speed, view.ego.turn_rate])


@dataclass(frozen=True, kw_only=True)
class BodyPart:
    """What the robot is: radius [m], greatest speed [m/s], greatest turn rate [rad/s]."""

    __pydantic_config__ = _STRICT
    part: Literal["body"]
    """radius and limits"""
    size = 3

    def read(self, view: View) -> Array:
        """(3,) [m], [m/s], [rad/s]"""
        return np.array([view.model.radius, view.model.max_speed, view.model.max_angular_velocity])


@dataclass(frozen=True, kw_only=True)
class PeoplePart:
    """The nearest people and robots, near to far: x, y [m], velocity over the ground x, y [m/s], radius [m] each."""

    __pydantic_config__ = _STRICT
    part: Literal["people"]
    """who is near"""
    count: int
    """how many; the rest is zero where there are fewer"""
    range: float = 10.0
    """farther people are left out [m]"""

    def __post_init__(self) -> None:
        if not self.count >= 1:
            raise ValueError(f"count is {self.count}, expected at least 1")

    @property
    def size(self) -> int:
        """Numbers in it."""
        return self.count * PERSON

    def read(self, view: View) -> Array:
        """(5 count,)"""
        distance = np.hypot(view.displacement[:, 0], view.displacement[:, 1])
        near = np.argsort(distance, kind="stable")[: self.count]
        near = near[distance[near] <= self.range]
        cos, sin = math.cos(view.ego.heading), math.sin(view.ego.heading)
        turn = np.array([[cos, -sin], [sin, cos]])
        rows = np.zeros((self.count, PERSON))
        rows[: len(near), :2] = view.displacement[near] @ turn
        rows[: len(near), 2:4] = view.discs.velocity[near] @ turn
        rows[: len(near), 4] = view.discs.radius[near]
        return rows.reshape(-1)


@dataclass(frozen=True, kw_only=True)
class ScanPart:
    """The ranges of the laser scan [m], from the first beam to the last: the least of every group of beams."""

    __pydantic_config__ = _STRICT
    part: Literal["scan"]
    """ranges"""
    beams: int
    """how many; must divide the scanner's"""
    range: float = 10.0
    """of beams that meet nothing, and the most of all others [m]"""

    def __post_init__(self) -> None:
        if not self.beams >= 1:
            raise ValueError(f"beams is {self.beams}, expected at least 1")

    @property
    def size(self) -> int:
        """Numbers in it."""
        return self.beams

    def read(self, view: View) -> Array:
        """(beams,) [m]

        Raises:
            ValueError: if there is no scan, or one whose beams cannot be grouped.
        """
        if view.scan is None:
            raise ValueError("the observation has a scan, but the input 'scan' is not connected: add one lidar")
        ranges = np.asarray(view.scan.ranges, np.float64)
        if len(ranges) % self.beams:
            raise ValueError(f"the scan has {len(ranges)} beams, expected a multiple of beams ({self.beams})")
        ranges = np.where(ranges == -np.inf, view.scan.range_min, np.where(np.isfinite(ranges), ranges, self.range))
        least: Array = np.minimum(ranges, self.range).reshape(self.beams, -1).min(axis=1)
        return least


Part = Annotated[GoalPart | VelocityPart | BodyPart | PeoplePart | ScanPart, Field(discriminator="part")]
"""one part of an observation"""
