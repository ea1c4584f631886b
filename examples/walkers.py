"""People in rows who walk against the x axis and stop for robots ahead of them: a crowd in a page."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crowdcosim import Mover, Setup
from crowdcosim.messages import Crowd, Header, RobotState
from crowdcosim.setup import time_of

ROWS, STRIDE, MAX_ACCELERATION = 9, 1.4, 2.0


@dataclass(frozen=True, kw_only=True)
class Config:
    count: int = 20
    """number of people"""
    speed: float = 1.2
    """at which they walk [m/s]"""


class Walkers(Mover):
    """Everybody keeps to his row of a world that wraps around in x."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> Crowd:
        count = 0 if setup.alone else self._config.count
        (self._width, depth), self._dt = setup.world.size, setup.dt
        who = np.arange(count)
        self._x = self._width * who / max(count, 1)
        self._y = 0.5 + who % ROWS * ((depth - 1.0) / (ROWS - 1))
        self._speed, self._phase = np.zeros(count), np.zeros(count)
        self._period, self._time = setup.period, 0
        return self._crowd()

    def step(self, robots: tuple[RobotState, ...]) -> Crowd:
        free = np.ones(len(self._x))
        for robot in robots:
            dx, dy = robot.position[0] - self._x, robot.position[1] - self._y
            share = np.clip(np.sqrt(dx * dx + dy * dy) - 1.0, 0.0, 1.0)
            free = np.where(dx < 0.0, np.minimum(free, share), free)
        most = MAX_ACCELERATION * self._dt
        self._speed = self._speed + np.clip(self._config.speed * free - self._speed, -most, most)
        x = self._x - self._speed * self._dt
        self._x = x - self._width * np.floor(x / self._width)
        phase = self._phase + self._speed * self._dt / STRIDE
        self._phase = phase - np.floor(phase)
        self._time += self._period
        return self._crowd()

    def _crowd(self) -> Crowd:
        count = len(self._x)
        return Crowd(
            header=Header(stamp=time_of(self._time), frame_id="map"),
            id=np.arange(1, count + 1, dtype=np.uint32),
            group=np.zeros(count, np.uint32),
            position=np.column_stack([self._x, self._y]),
            velocity=np.column_stack([-self._speed, np.zeros(count)]),
            heading=np.full(count, math.pi),
            radius=np.full(count, 0.3),
            stature=np.full(count, 1.7),
            mass=np.full(count, 70.0),
            gait_phase=self._phase,
            gait_speed=self._speed,
        )
