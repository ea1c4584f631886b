"""A car-like drive: the kinematic bicycle, whose steering angle and speed follow a command.

With the speed u of the rear axle's middle, the steering angle d of the front axle's and the wheelbase L,
    omega = u tan(d) / L,
and the base's centre, L / 2 ahead of the rear axle, moves at u ahead and omega L / 2 to the left (Rajamani 2012,
"Vehicle Dynamics and Control", 2nd ed., section 2.2). A command (v, omega) asks for the angle d = atan(omega L / v);
one without speed keeps the wheels as they are, as a car that stands does not turn.
Both u and d change linearly within a step; the turn is that of their means, on an arc of the rear axle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from components.robot.drive import Bound, Drive, Motion, chord, free_share, limited, towards
from crowdcosim.messages import Twist
from crowdcosim.robots import Car


class CarDrive(Drive):
    """Steered front wheels: it turns only while it drives. It ignores a command's `linear.y`."""

    __slots__ = ()

    @property
    def base(self) -> Car:
        assert isinstance(self.model.base, Car)
        return self.model.base

    @property
    def top_speed(self) -> float:
        """The centre swings out to the side of the rear axle's way."""
        slope = 0.5 * math.tan(self.base.max_steering_angle)
        return math.hypot(1.0, slope) * max(self.model.max_speed, -self.model.min_speed)

    def plan(self, command: Twist, h: float) -> Motion:
        model, base = self.model, self.base
        wanted = limited(command.linear.x, model.min_speed, model.max_speed)
        turn_rate = limited(command.angular.z, -model.max_angular_velocity, model.max_angular_velocity)
        angle = math.atan(turn_rate * base.wheelbase / wanted) if wanted else self.steering
        angle = limited(angle, -base.max_steering_angle, base.max_steering_angle)
        speed = towards(self.speed, wanted, model.max_acceleration * h)
        steering = towards(self.steering, angle, base.max_steering_rate * h)
        way = 0.5 * (self.speed + speed) * h
        turn = way * math.tan(0.5 * (self.steering + steering)) / base.wheelbase
        dx, dy = chord(self.heading, way, turn)
        # The centre is ahead of the rear axle, and the turn carries it to the side.
        swing_x, swing_y = chord(self.heading + 0.5 * math.pi, 0.5 * base.wheelbase * turn, turn)
        rate = speed * math.tan(steering) / base.wheelbase
        return Motion(dx + swing_x, dy + swing_y, turn, speed, 0.5 * base.wheelbase * rate, rate, steering)

    def left_of(self, motion: Motion, bounds: Sequence[Bound], h: float) -> Motion:
        """It stops where it meets what it drives at, and so does its turn; the front wheels go on steering."""
        free = free_share(motion, bounds)
        if free >= 1.0:
            return motion
        return Motion(free * motion.dx, free * motion.dy, free * motion.turn, 0.0, 0.0, 0.0, motion.steering)
