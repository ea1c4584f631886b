"""Setups, states and crowds for sensors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from crowdcosim.messages import Crowd, Header, RobotState
from crowdcosim.robots import Pose, Robot, RobotModel, Target
from crowdcosim.setup import Setup, time_of
from crowdcosim.world import World


def _setup(world: World, *, seed: int = 1, heights: tuple[float, ...] = (0.42, 1.2, 0.2)) -> Setup:
    robots = tuple(
        Robot(
            name=f"robot{number}",
            number=number,
            model=RobotModel(
                radius=0.177,
                height=height,
                mass=20.0,
                max_speed=1.0,
                max_acceleration=5.0,
                max_angular_velocity=np.pi,
                max_angular_acceleration=10.0,
            ),
            start=Pose(x=0.0, y=0.0),
            goal=Target(x=0.0, y=0.0),
        )
        for number, height in enumerate(heights, 1)
    )
    return Setup(component="robot1/sensor", period=100_000_000, seed=seed, world=world, robots=robots, robot="robot1")


def _robot(
    x: float,
    y: float,
    heading: float = 0.0,
    *,
    number: int = 1,
    velocity: tuple[float, float] = (0.0, 0.0),
    turn_rate: float = 0.0,
    radius: float = 0.177,
    nanoseconds: int = 0,
) -> RobotState:
    return RobotState(
        header=Header(stamp=time_of(nanoseconds), frame_id="map"),
        name=f"robot{number}",
        position=np.array((x, y)),
        heading=heading,
        velocity=np.array(velocity),
        angular_velocity=turn_rate,
        radius=radius,
    )


def _people(*rows: tuple[float, float], heading: float = 0.0, stature: float = 1.75) -> Crowd:
    n = len(rows)
    return Crowd(
        id=np.arange(101, 101 + n),
        group=np.zeros(n, np.uint32),
        position=np.array(rows, np.float64).reshape(-1, 2),
        velocity=np.zeros((n, 2)),
        heading=np.full(n, heading),
        radius=np.full(n, 0.3),
        stature=np.full(n, stature),
        mass=np.full(n, 70.0),
        gait_phase=np.zeros(n),
        gait_speed=np.zeros(n),
    )


@pytest.fixture(scope="session")
def setup() -> Callable[..., Setup]:
    """The setup of a sensor on robot1 in a world."""
    return _setup


@pytest.fixture(scope="session")
def robot() -> Callable[..., RobotState]:
    """A robot's state from x, y and heading."""
    return _robot


@pytest.fixture(scope="session")
def people() -> Callable[..., Crowd]:
    """A crowd that stands at rows of x, y; ids from 101."""
    return _people
