"""What a component is told when an episode begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crowdcosim.messages import Time
from crowdcosim.robots import Robot
from crowdcosim.world import World


@dataclass(frozen=True, kw_only=True)
class Setup:
    """The episode as one component sees it; the same on every host."""

    component: str
    """this component's name in the scenario"""
    period: int
    """time between two of this component's steps [ns]"""
    seed: int
    """this component's own seed, from the scenario's seed and the component's name; 0 <= seed < 2**64"""
    world: World
    """extent, walls and seams"""
    robots: tuple[Robot, ...] = ()
    """all robots, in the scenario's order"""
    robot: str | None = None
    """the robot that this component belongs to, None for the crowd and the evaluator"""
    alone: bool = False
    """True in the reference run, in which there are no people"""
    reference: Mapping[str, Mapping[str, float]] | None = None
    """robot -> metric -> value in the reference run, where one was made"""

    @property
    def dt(self) -> float:
        """Time between two of this component's steps [s]."""
        return self.period * 1e-9

    @cached_property
    def own_robot(self) -> Robot:
        """The robot that this component belongs to.

        Raises:
            ValueError: if the component belongs to no robot.
        """
        for robot in self.robots:
            if robot.name == self.robot:
                return robot
        raise ValueError(f"component '{self.component}' belongs to no robot: place it under `robots:` in the scenario")

    def rng(self, *stream: int) -> np.random.Generator:
        """A generator of this component's own; other `stream` numbers give independent ones."""
        return np.random.Generator(np.random.PCG64(np.random.SeedSequence([self.seed, *stream])))


def time_of(nanoseconds: int) -> Time:
    """Simulated time as a ROS 2 `Time`."""
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def nanoseconds_of(time: Time) -> int:
    """A ROS 2 `Time` as integer nanoseconds."""
    return time.sec * 1_000_000_000 + time.nanosec
