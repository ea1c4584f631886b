"""A holonomic drive: the base moves in any direction and turns meanwhile; an obstacle deflects it along its surface.

`max_speed` limits the size of the velocity: what is commanded beyond keeps its direction. The velocity changes, as a
vector, by at most the acceleration limit. What meets an obstacle loses the part of its motion that leads into it, and
keeps the rest: the way is the one nearest to the plan that exceeds no bound (a projection onto at most two planes).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

from components.robot.drive import Bound, Drive, Motion, chord, limited, towards
from crowdcosim.messages import Twist
from crowdcosim.robots import Holonomic

# What a way may exceed a bound by [m]: rounding.
_ROUNDING = 1e-12


class HolonomicDrive(Drive):
    """Omnidirectional wheels: `linear.x`, `linear.y` and `angular.z` of a command are obeyed alike."""

    __slots__ = ()

    @property
    def top_speed(self) -> float:
        return self.model.max_speed

    @property
    def base(self) -> Holonomic:
        assert isinstance(self.model.base, Holonomic)
        return self.model.base

    def plan(self, command: Twist, h: float) -> Motion:
        model = self.model
        ahead, left = self._within_limits(command.linear.x, command.linear.y)
        change_ahead, change_left = ahead - self.speed, left - self.lateral_speed
        change = math.hypot(change_ahead, change_left)
        share = min(1.0, model.max_acceleration * h / change) if change else 1.0
        speed = self.speed + share * change_ahead
        lateral_speed = self.lateral_speed + share * change_left
        wanted = limited(command.angular.z, -model.max_angular_velocity, model.max_angular_velocity)
        turn_rate = towards(self.turn_rate, wanted, model.max_angular_acceleration * h)
        turn = 0.5 * (self.turn_rate + turn_rate) * h
        dx, dy = chord(self.heading, 0.5 * (self.speed + speed) * h, turn)
        aside_x, aside_y = chord(self.heading + 0.5 * math.pi, 0.5 * (self.lateral_speed + lateral_speed) * h, turn)
        return Motion(dx + aside_x, dy + aside_y, turn, speed, lateral_speed, turn_rate)

    def _within_limits(self, ahead: float, left: float) -> tuple[float, float]:
        """The commanded velocity [m/s], shortened until it is within all limits; what is too fast backwards is cut."""
        ahead = max(ahead, self.model.min_speed)
        excess = max(1.0, math.hypot(ahead, left) / self.model.max_speed, abs(left) / self.base.max_lateral_speed)
        return ahead / excess, left / excess

    def stops_after(self, motion: Motion, bounds: Sequence[Bound]) -> float:
        return 1.0  # it is deflected

    def left_of(self, motion: Motion, bounds: Sequence[Bound], h: float) -> Motion:
        """It loses what leads into obstacles, goes on along them, and turns."""
        planned = motion.dx, motion.dy
        if _fits(planned, bounds):
            return motion
        dx, dy = nearest_within(planned, bounds)
        heading = self.heading + motion.turn
        vx, vy = dx / h, dy / h
        cos, sin = math.cos(heading), math.sin(heading)
        return motion._replace(dx=dx, dy=dy, speed=cos * vx + sin * vy, lateral_speed=cos * vy - sin * vx)


def nearest_within(planned: tuple[float, float], bounds: Sequence[Bound]) -> tuple[float, float]:
    """The way [m] nearest to `planned` that exceeds no bound: on one plane, where two cross, or no way at all."""
    x, y = planned
    best, least = (0.0, 0.0), math.hypot(x, y)
    for way in (*(_on_plane(x, y, b) for b in bounds), *(_crossing(a, b) for a, b in combinations(bounds, 2))):
        distance = math.hypot(way[0] - x, way[1] - y)
        if distance < least and _fits(way, bounds):
            best, least = way, distance
    return best


def _fits(way: tuple[float, float], bounds: Sequence[Bound]) -> bool:
    return all(b.nx * way[0] + b.ny * way[1] <= b.most + _ROUNDING for b in bounds)


def _on_plane(x: float, y: float, bound: Bound) -> tuple[float, float]:
    excess = bound.nx * x + bound.ny * y - bound.most
    return x - excess * bound.nx, y - excess * bound.ny


def _crossing(a: Bound, b: Bound) -> tuple[float, float]:
    """Where both planes are reached; infinitely far if they are parallel."""
    determinant = a.nx * b.ny - a.ny * b.nx
    if determinant == 0.0:
        return math.inf, math.inf
    return (a.most * b.ny - b.most * a.ny) / determinant, (a.nx * b.most - b.nx * a.most) / determinant
