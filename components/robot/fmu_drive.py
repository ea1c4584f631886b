"""The wheel motors as a co-simulation FMU, whose variables play the parts that a drive has to fill.

An FMU that gives the wheels' speeds has the robot's inertia in itself. One that gives torques gets the measured speeds
back, and the wheels turn here: J dw/dt = torque - load, with the J of `motor.py`, one communication step at a time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

from components.robot.fmu_file import FmuError
from components.robot.fmu_instance import FmuInstance, Value
from components.robot.fmu_parts import INPUTS, RESULTS, Variable, Variables
from components.robot.motor import Vehicle, compliance, hold
from components.robot.robot_step import INNER_STEPS


@dataclass(frozen=True, kw_only=True)
class _Part:
    """A part that a variable of the FMU plays."""

    role: str
    variable: Variable


class FmuMotors:
    """Two wheels moved by an FMU; in the place of `NativeMotors`."""

    def __init__(
        self,
        file: Path,
        *,
        name: str,
        variables: Variables | None,
        parameters: Mapping[str, Value],
        vehicle: Vehicle,
        wheel_inertia: float,
        h: float,
    ) -> None:
        """Load `file`; without `variables`, those that are called like the parts play them.

        `name` is the robot's; `wheel_inertia` [kg m2] counts where the FMU gives torques; steps will be of `h` [s].

        Raises:
            FmuError: if the FMU cannot be used, or the parts cannot be filled with its variables.
        """
        self._file = file
        self._instance = FmuInstance(file, name)
        self._check_step(h)
        self._parameters = parameters
        self._vehicle = vehicle
        self._compliance = compliance(
            wheel_inertia, vehicle.wheel_radius, vehicle.track, vehicle.mass, vehicle.yaw_inertia
        )
        parts = self._parts(variables or self._namesakes())
        inputs = [part for part in parts if part.role in INPUTS]
        self._places = [(INPUTS.index(part.role), 1.0 / part.variable.factor) for part in inputs]
        self._give = self._instance.access([part.variable.name for part in inputs])
        roles = {part.role: part.variable for part in parts}
        self._by_torque = "left_speed" not in roles
        self._results = [roles[role] for role in RESULTS[self._by_torque]]
        self._take = self._instance.access([variable.name for variable in self._results])

    def reset(self) -> None:
        """A new instance, at rest at t = 0."""
        self._instance.start(self._parameters)
        self._steps = 0
        self._speed = (0.0, 0.0)

    def step(self, command: tuple[float, float], load: tuple[float, float], h: float) -> tuple[float, float]:
        """Speeds of the wheels [rad/s] after `h` [s], the same in every step; as in `NativeMotors`.

        Raises:
            FmuError: if the FMU fails, or gives a value that is not finite.
        """
        radius, track = self._vehicle.wheel_radius, self._vehicle.track
        left, right = command
        values = (
            left,
            right,
            0.5 * radius * (left + right),
            radius * (right - left) / track,
            *load,
            *self._speed,
        )
        self._give.set([values[place] * scale for place, scale in self._places])
        self._instance.step(self._steps * h, h)
        self._steps += 1
        results = [v * part.factor for v, part in zip(self._take.get(), self._results, strict=True)]
        for value, part in zip(results, self._results, strict=True):
            if not math.isfinite(value):
                raise FmuError(
                    f"variable '{part.name}' of {self._file} is {value} at t = {self._steps * h:g} s, expected a "
                    "finite number: see what its parameters and inputs allow"
                )
        self._speed = self._turned(results, load, h) if self._by_torque else (results[0], results[1])
        return self._speed

    def _turned(self, torque: list[float], load: tuple[float, float], h: float) -> tuple[float, float]:
        """The wheels' speeds once torques and loads [N m] have acted on them."""
        yielding, coupling = self._compliance
        left = self._speed[0] + h * (yielding * torque[0] + coupling * torque[1])
        right = self._speed[1] + h * (coupling * torque[0] + yielding * torque[1])
        return hold(left, right, 0.0, load[0], load[1], yielding, coupling, h)

    def _check_step(self, h: float) -> None:
        fixed = self._instance.description.fixed_step
        if fixed is not None and abs(h / fixed - round(h / fixed)) > 1e-6:
            raise FmuError(
                f"{self._file} advances in steps of {fixed:g} s, expected one that goes into the {h:g} s between two "
                f"exchanges: set the scenario's `dt` to a multiple of {fixed * INNER_STEPS:g} s"
            )

    def _namesakes(self) -> Variables:
        """The variables of the FMU that are called like a part; its speeds rather than its torques."""
        names = {variable.name for variable in self._instance.description.variables}
        found = {f.name: Variable(name=f.name) for f in fields(Variables) if f.name in names}
        if set(RESULTS[False]) <= set(found):
            found = {role: variable for role, variable in found.items() if role not in RESULTS[True]}
        try:
            return Variables(**found)
        except ValueError as error:
            raise FmuError(
                f"{self._file} has no variables called like the parts of a drive ({error}): say under `variables` "
                f"which of its own play them; list them: crowdcosim fmu inspect {self._file}"
            ) from None

    def _parts(self, variables: Variables) -> list[_Part]:
        """Every part that is filled, with a variable that there is and that may fill it."""
        parts = []
        for field in fields(variables):
            variable: Variable | None = getattr(variables, field.name)
            if variable is None:
                continue
            known = self._instance.description.variable(variable.name)
            if field.name in INPUTS and known.causality != "input":
                inputs = [v.name for v in self._instance.description.variables if v.causality == "input"]
                raise FmuError(
                    f"variables.{field.name}: '{known.name}' of {self._file} is of causality {known.causality}, "
                    f"expected an input: {', '.join(inputs) or 'it has none'}"
                )
            parts.append(_Part(role=field.name, variable=variable))
        return parts
