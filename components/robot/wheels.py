"""A robot on two wheels with motors: a regulator turns the command into torques, and the floor gives the grip.

The command becomes the wheels' wanted speeds, w = (v -+ omega b / 2) / r for the left and the right one; motors, native
or an FMU, give the wheels' speeds; the robot follows them, v = r (w_l + w_r) / 2 and omega = r (w_r - w_l) / b, as fast
as the tyres' grip mu lets it: |dv/dt| <= mu g, |domega/dt| <= mu m g b / (2 I), with all weight on the driven wheels
and the inertia of a disc, I = m R^2 / 2.

What is in the way stops the robot as it stops any other (`chassis.py`). The wheels then slip, or stall: while it is
commanded against something that it touches, the floor resists each wheel with up to mu m g r / 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Protocol

from components.robot.chassis import Chassis
from components.robot.differential import DifferentialDrive
from components.robot.floor import GRAVITY, GRIP
from components.robot.fmu_parts import Variables
from components.robot.motor import Motor, NativeMotors, Vehicle
from components.robot.robot_step import INNER_STEPS, RobotStep
from crowdcosim.component import ComponentError, Mover
from crowdcosim.messages import Crowd, RobotState, Twist
from crowdcosim.robots import Differential, Robot
from crowdcosim.setup import Setup


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of `Wheels`."""

    grip: float = GRIP
    """coefficient of friction between tyres and floor [1]"""
    motor: Motor = field(default_factory=Motor)
    """of each wheel; for the native motors and the built-in FMU"""
    fmu: str | None = None
    """an FMU in the place of the native motors: `built-in`, `built-in-fmi2`, or a file, `./supplier.fmu`"""
    variables: Variables | None = None
    """which variables of the FMU play which part; without, those that are called like the parts"""
    parameters: Mapping[str, float | bool | str] = field(default_factory=dict)
    """start values of the FMU's own variables, in its units"""

    def __post_init__(self) -> None:
        if not self.grip > 0.0:
            raise ValueError(f"grip is {self.grip}, expected more than zero")
        if self._own_file is not None and not self._own_file.startswith(("./", "../", "/")):
            raise ValueError(
                f"fmu is '{self.fmu}', expected built-in, built-in-fmi2, or a path that begins with ./, ../ or /"
            )
        for name, without in (("variables", None), ("parameters", {})):
            if self._own_file is None and getattr(self, name) != without:
                raise ValueError(f"{name} is given, expected none: only an FMU of your own (`fmu: FILE`) has them")
        if self._own_file is not None and self.motor != Motor():
            raise ValueError("motor is given, expected none beside an FMU of your own: it has motors, and `parameters`")

    @property
    def _own_file(self) -> str | None:
        return None if self.fmu in (None, "built-in", "built-in-fmi2") else self.fmu


class Motors(Protocol):
    """What moves the wheels."""

    def reset(self) -> None: ...

    def step(self, command: tuple[float, float], load: tuple[float, float], h: float) -> tuple[float, float]: ...


class Wheels(Mover):
    """A disc on two wheels with motors. The command is `linear.x` and `angular.z` of the Twist; it ignores the rest."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._file = Path(config.fmu).absolute() if config.fmu else None
        self._motors: Motors | None = None

    def reset(self, setup: Setup) -> RobotStep:
        """The robot at its start pose, at rest.

        Raises ValueError if the component belongs to no robot, ComponentError if that has no two wheels whose measures
        are known, or if the FMU cannot be had or used.
        """
        model = setup.own_robot.model
        config = self._config
        self._model = model
        self._h = setup.dt / INNER_STEPS
        self._vehicle = vehicle = _vehicle_of(setup.own_robot)
        if self._motors is None:
            self._motors = self._new_motors(setup)
        self._motors.reset()
        self._wheels = (0.0, 0.0)
        self._acceleration = config.grip * GRAVITY
        self._angular_acceleration = 0.5 * config.grip * model.mass * GRAVITY * vehicle.track / vehicle.yaw_inertia
        self._most_load = 0.5 * config.grip * model.mass * GRAVITY * vehicle.wheel_radius
        self._chassis = Chassis(setup)
        return self._chassis.output()

    def step(self, twist: Twist, crowd: Crowd, others: tuple[RobotState, ...]) -> RobotStep:
        model, chassis, vehicle = self._model, self._chassis, self._vehicle
        speed = min(max(twist.linear.x, model.min_speed), model.max_speed)
        turn_rate = min(max(twist.angular.z, -model.max_angular_velocity), model.max_angular_velocity)
        aside = 0.5 * turn_rate * vehicle.track
        command = ((speed - aside) / vehicle.wheel_radius, (speed + aside) / vehicle.wheel_radius)
        chassis.begin_step(crowd, others, self._top_speed())
        for _ in range(INNER_STEPS):
            self._inner_step(command, speed)
        return chassis.end_step()

    def _inner_step(self, command: tuple[float, float], speed: float) -> None:
        """Let the motors turn the wheels towards `command` [rad/s], which drives the robot at `speed` [m/s]."""
        assert self._motors is not None
        chassis, vehicle = self._chassis, self._vehicle
        assert isinstance(chassis.drive, DifferentialDrive)
        load = 0.0
        if speed and chassis.touches(speed):
            load = self._most_load if speed > 0.0 else -self._most_load
        self._wheels = left, right = self._motors.step(command, (load, load), self._h)
        motion = chassis.drive.approach(
            0.5 * vehicle.wheel_radius * (left + right),
            vehicle.wheel_radius * (right - left) / vehicle.track,
            self._acceleration,
            self._angular_acceleration,
            self._h,
        )
        chassis.move(motion, self._h)

    def _top_speed(self) -> float:
        """What the robot cannot exceed in the step that begins [m/s]."""
        return abs(self._chassis.drive.speed) + self._acceleration * INNER_STEPS * self._h

    def _new_motors(self, setup: Setup) -> Motors:
        config, vehicle = self._config, self._vehicle
        if self._file is None:
            return NativeMotors(config.motor, vehicle)
        # Imported here, as who needs no FMU need not wait for fmpy.
        from components.robot.fmu_build import built_in
        from components.robot.fmu_drive import FmuMotors

        file, parameters = self._file, config.parameters
        if config.fmu in ("built-in", "built-in-fmi2"):
            file = built_in("3" if config.fmu == "built-in" else "2")
            parameters = asdict(config.motor) | asdict(vehicle)
        return FmuMotors(
            file,
            name=setup.component,
            variables=config.variables,
            parameters=parameters,
            vehicle=vehicle,
            wheel_inertia=config.motor.wheel_inertia,
            h=self._h,
        )


def _vehicle_of(robot: Robot) -> Vehicle:
    model, base = robot.model, robot.model.base
    if not isinstance(base, Differential):
        raise ComponentError(
            f"the base of '{robot.name}' is of kind '{base.kind}', expected 'differential': motors turn two wheels "
            "on one axis; use the drive `kinematic` or `forces`, or change the robot's model"
        )
    if base.wheel_radius is None or base.track is None:
        raise ComponentError(
            f"the model of '{robot.name}' gives no wheel_radius and track, expected both where motors turn the wheels: "
            "add them to its robot file, `base: {kind: differential, wheel_radius: ..., track: ...}`"
        )
    return Vehicle(
        wheel_radius=base.wheel_radius,
        track=base.track,
        mass=model.mass,
        yaw_inertia=0.5 * model.mass * model.radius**2,
    )
