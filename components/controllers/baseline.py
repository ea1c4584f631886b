"""Drive at the goal and ignore everybody: the baseline of "Crowd against the machine" (Grzeskowiak et al. 2021).

    v = speed,  omega = 2 e,  e the angle from the robot's heading to the goal

In the corridor, whose goal is straight ahead, this is the paper's constant (1 m/s, 0 rad/s).

Not in the paper: what to do when the goal is not straight ahead. A robot that faces more than 45 degrees away from it
turns on the spot, because one that turns while it drives may circle a goal for ever.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from components.controllers.ego import command, ego_of, heading_error, turn, way_to
from crowdcosim import Controller, Setup
from crowdcosim.messages import Goal, Odometry, Twist

MAX_ERROR = math.pi / 4
"""heading error beyond which the robot turns on the spot [rad]"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of the baseline."""

    speed: float | None = None
    """cruise speed, None for the robot's maximum [m/s]"""

    steer: bool = True
    """turn to the goal; False: drive straight on, wherever the goal is, as the benchmark's authors did"""

    def __post_init__(self) -> None:
        if self.speed is not None and not self.speed > 0:
            raise ValueError(f"speed is {self.speed}, expected a positive number")


class Baseline(Controller):
    """Drives at the goal at constant speed, blind to people and walls."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the robot's limits.

        Raises:
            ValueError: if the robot cannot drive at the configured speed.
        """
        model = setup.own_robot.model
        if self._config.speed is not None and self._config.speed > model.max_speed:
            raise ValueError(f"speed is {self._config.speed}, expected at most the robot's {model.max_speed} m/s")
        self._speed = model.max_speed if self._config.speed is None else self._config.speed
        self._max_turn_rate = model.max_angular_velocity

    def step(self, odometry: Odometry, goal: Goal) -> Twist:
        """Straight at the goal; stand within its disc."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        if way is None:
            return command(0.0, 0.0)
        if not self._config.steer:
            return command(self._speed, 0.0)
        error = heading_error(way.bearing, ego.heading)
        return command(self._speed if abs(error) < MAX_ERROR else 0.0, turn(error, self._max_turn_rate))
