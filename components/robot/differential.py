"""A differential drive: speed and turn rate follow a command, the base moves on arcs, an obstacle ahead stops it."""

from __future__ import annotations

from collections.abc import Sequence

from components.robot.drive import Bound, Drive, Motion, chord, free_share, limited, towards
from crowdcosim.messages import Twist


class DifferentialDrive(Drive):
    """Two driven wheels: it never moves sideways, and turns on the spot. It ignores a command's `linear.y`."""

    __slots__ = ()

    def plan(self, command: Twist, h: float) -> Motion:
        model = self.model
        return self.approach(
            limited(command.linear.x, model.min_speed, model.max_speed),
            limited(command.angular.z, -model.max_angular_velocity, model.max_angular_velocity),
            model.max_acceleration,
            model.max_angular_acceleration,
            h,
        )

    def approach(
        self, speed: float, turn_rate: float, acceleration: float, angular_acceleration: float, h: float
    ) -> Motion:
        """The motion of the next `h` [s], in which the rates come as near to these as the accelerations allow.

        `speed` [m/s], `turn_rate` [rad/s], `acceleration` [m/s2] and `angular_acceleration` [rad/s2], the latter two
        either way.
        """
        next_speed = towards(self.speed, speed, acceleration * h)
        next_rate = towards(self.turn_rate, turn_rate, angular_acceleration * h)
        turn = 0.5 * (self.turn_rate + next_rate) * h
        dx, dy = chord(self.heading, 0.5 * (self.speed + next_speed) * h, turn)
        return Motion(dx, dy, turn, next_speed, 0.0, next_rate)

    def left_of(self, motion: Motion, bounds: Sequence[Bound], h: float) -> Motion:
        """It stops on its way where it meets what it drives at, but still turns."""
        free = free_share(motion, bounds)
        if free >= 1.0:
            return motion
        return motion._replace(dx=free * motion.dx, dy=free * motion.dy, speed=0.0)
