"""A robot as rigid bodies in pymunk: a base, the wheels that are joined to it, and friction between them and the floor.

Friction is a force that brings the velocity v of a place on the robot to the velocity u with which its surface moves
over the floor, and has a limit:
    F = F_max (u - v) / |u - v| while they differ, |F| <= F_max when they do not,
solved by pymunk as an impulse, as contacts are, so that a floor that can hold the robot does hold it. It is
    uniform      under a holonomic base: u is the commanded velocity, F_max = min(mu m g, m a); and about the vertical
                 F_max R 2 / 3, as under a disc;
    directional  under a wheel with the load N: across it u = 0, F_max = mu N; along it, where it is driven, u is the
                 commanded speed and F_max what the motor gives, at most mu N; it rolls freely where it is not.
With the limits a and alpha of the robot's accelerations, the motors give (m a + 2 I alpha / b) / 2 to each of two
wheels at the distance b of each other, and m a to one.
A differential base has two driven wheels beside its centre, castors not counted. A car-like base has one wheel in the
middle of each axle (the bicycle of `car.py`): the rear one is driven, the front one steers and rolls freely.

Each wheel is a body with a tenth of the mass, which keeps the joints stiff; mass and yaw inertia of the whole are those
of a disc. The weight rests evenly on the wheels. Not modelled: a wheel that skids one way holds less the other way.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import pymunk

from components.robot.drive import Drive, Motion
from components.robot.floor import GRAVITY
from components.robot.surroundings import ROBOT
from crowdcosim.component import ComponentError
from crowdcosim.robots import Car, Differential, Robot, RobotModel

ITERATIONS = 40
"""of pymunk's solver: with wheels of a tenth of the mass, joints then stay closed within 0.1 mm"""
_WHEEL_MASS = 0.1  # share of the whole robot's mass
_FLAT = 0.01  # gyration radius of a wheel about the vertical, over the robot's radius


class _Wheel(NamedTuple):
    """A wheel, and the floor as it rolls over it."""

    body: pymunk.Body
    axle: pymunk.GearJoint
    floor: pymunk.Body
    side: float
    """to the left of the base's centre [m]"""
    driven: bool


class Rig:
    """The bodies of one robot in a space."""

    def __init__(self, space: pymunk.Space, robot: Robot, drive: Drive, grip: float) -> None:
        """Stands where `drive` is; `grip` is the coefficient of friction.

        Raises:
            ComponentError: if the robot file does not say where a differential base has its wheels.
        """
        model = robot.model
        space.iterations = ITERATIONS
        places = _places(robot)
        mass = model.mass * (1.0 - _WHEEL_MASS * len(places))
        wheel = _WHEEL_MASS * model.mass
        own = wheel * (_FLAT * model.radius) ** 2
        inertia = 0.5 * model.mass * model.radius**2 - sum(own + wheel * (x * x + y * y) for x, y, _ in places)
        if not inertia > 0.0:
            raise ComponentError(
                f"the wheels of '{robot.name}' are too far out for a disc of {model.radius} m: see `base` and `radius` "
                "in its robot file"
            )
        self.base = pymunk.Body(mass, inertia)
        self.base.position, self.base.angle = (drive.x, drive.y), drive.heading
        shape = pymunk.Circle(self.base, model.radius)
        shape.filter = pymunk.ShapeFilter(categories=ROBOT)
        space.add(self.base, shape)
        self._drive = drive
        weight = model.mass * GRAVITY
        self._wheels = [
            self._join(space, *place, pymunk.Body(wheel, own), grip * weight / len(places), _motor_force(model))
            for place in places
        ]
        most = min(grip * weight, model.mass * model.max_acceleration)
        self._plate = None if places else self._stand(space, most, 2.0 / 3.0 * model.radius)

    def pull(self, motion: Motion) -> None:
        """Let the motors ask for the rates at the end of `motion`, and the front wheel steer."""
        self._drive.steering = motion.steering
        cos, sin = math.cos(self.base.angle), math.sin(self.base.angle)
        if self._plate is not None:
            ahead, left = motion.speed, motion.lateral_speed
            self._plate.velocity = (cos * ahead - sin * left, sin * ahead + cos * left)
            self._plate.angular_velocity = motion.turn_rate
        for wheel in self._wheels:
            wheel.floor.position, wheel.floor.angle = wheel.body.position, wheel.body.angle
            if wheel.driven:
                speed = motion.speed - wheel.side * motion.turn_rate
                wheel.floor.velocity = (speed * cos, speed * sin)
            else:
                wheel.axle.phase = motion.steering

    def read(self) -> None:
        """Tell the drive where the base is, and how it moves."""
        base, drive = self.base, self._drive
        drive.x, drive.y = base.position
        drive.heading = math.remainder(base.angle, 2.0 * math.pi)
        cos, sin = math.cos(drive.heading), math.sin(drive.heading)
        vx, vy = base.velocity
        drive.speed, drive.lateral_speed = cos * vx + sin * vy, cos * vy - sin * vx
        drive.turn_rate = base.angular_velocity

    def shove(self, vx: float, vy: float, turn_rate: float) -> None:
        """Give the whole robot a velocity [m/s] and turn rate [rad/s], as a rigid body."""
        for body in (self.base, *(wheel.body for wheel in self._wheels)):
            x, y = body.position - self.base.position
            body.velocity = (vx - turn_rate * y, vy + turn_rate * x)
            body.angular_velocity = turn_rate
        self.read()

    def _join(
        self, space: pymunk.Space, x: float, y: float, driven: bool, body: pymunk.Body, hold: float, motor: float
    ) -> _Wheel:
        """Put a wheel at (x, y) of the base [m], held by at most `hold` and driven by at most `motor` [N]."""
        body.position, body.angle = self.base.local_to_world((x, y)), self.base.angle
        pivot = pymunk.PivotJoint(self.base, body, (x, y), (0.0, 0.0))
        axle = pymunk.GearJoint(self.base, body, 0.0, 1.0)
        pivot.error_bias = axle.error_bias = 0.0  # of an error, nothing may be left after a step
        floor = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        # In a groove along its way a wheel is held across it, in a groove across its way it is driven along.
        space.add(body, pivot, axle)
        space.add(_friction(pymunk.GrooveJoint(floor, body, (-1.0, 0.0), (1.0, 0.0), (0.0, 0.0)), hold))
        if driven:
            drive = pymunk.GrooveJoint(floor, body, (0.0, -1.0), (0.0, 1.0), (0.0, 0.0))
            space.add(_friction(drive, min(motor, hold)))
        return _Wheel(body, axle, floor, y, driven)

    def _stand(self, space: pymunk.Space, most: float, lever: float) -> pymunk.Body:
        """Put the base itself on the floor, with friction of at most `most` [N] at a mean `lever` [m]."""
        floor = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        slide = pymunk.PivotJoint(floor, self.base, (0.0, 0.0), (0.0, 0.0))
        turn = pymunk.GearJoint(floor, self.base, 0.0, 1.0)
        space.add(_friction(slide, most), _friction(turn, most * lever))
        return floor


def _friction(joint: pymunk.Constraint, most: float) -> pymunk.Constraint:
    """A joint that resists motion with at most `most` [N or N m] and never brings anything back to its place."""
    joint.max_bias = 0.0
    joint.max_force = most
    return joint


def _motor_force(model: RobotModel) -> float:
    """The most that the motor of a driven wheel gives [N]."""
    force = model.mass * model.max_acceleration
    if isinstance(model.base, Differential) and model.base.track is not None:
        turning = 0.5 * model.mass * model.radius**2 * model.max_angular_acceleration
        return 0.5 * force + turning / model.base.track
    return force


def _places(robot: Robot) -> list[tuple[float, float, bool]]:
    """Where wheels are: ahead, to the left of the centre [m], and whether they are driven."""
    base = robot.model.base
    if isinstance(base, Car):
        return [(-0.5 * base.wheelbase, 0.0, True), (0.5 * base.wheelbase, 0.0, False)]
    if not isinstance(base, Differential):
        return []
    if base.track is None:
        raise ComponentError(
            f"the model of '{robot.name}' gives no track, expected it where forces move the wheels: add it to its "
            "robot file, `base: {kind: differential, track: ...}`"
        )
    return [(0.0, 0.5 * base.track, True), (0.0, -0.5 * base.track, True)]
