"""A co-simulation FMU (FMI 2.0 or 3.0) that runs: started, set, stepped, got; its failures in its own words."""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from components.robot.fmu_file import (
    CallFailed,
    FmuError,
    FmuVariable,
    callbacks_of_fmi2,
    check_usable,
    describe,
    load_library,
    same_folder,
)

Value = float | bool | str

_STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
_REALS = ("Real", "Float64", "Float32")
_NUMBERS: dict[str, Any] = {
    "Real": ctypes.c_double,
    "Float64": ctypes.c_double,
    "Float32": ctypes.c_float,
    "Integer": ctypes.c_int,
    **{f"{u}Int{bits}": getattr(ctypes, f"c_{u.lower()}int{bits}") for u in ("", "U") for bits in (8, 16, 32, 64)},
}
"""FMI type -> ctypes type, of variables that are numbers"""
_TOLD = 5
"""messages of the FMU that an error quotes, the last ones"""
# Files of FMUs that allow one instance per process, and have it.
_taken: set[Path] = set()


class FmuInstance:
    """A co-simulation FMU, loaded into this process. `start` begins an episode, again and again."""

    def __init__(self, file: Path, name: str) -> None:
        """Load the library of `file`; `name` is what the FMU calls itself in its messages.

        Raises:
            FmuError: if it is no co-simulation FMU of version 2.0 or 3.0 with a binary for this machine.
        """
        self.description = describe(file)
        check_usable(self.description)
        self._messages: list[str] = []
        self._fmu = load_library(self.description, name)
        self._major = self.description.fmi_version[0]
        self._living = False

    def start(self, parameters: Mapping[str, Value]) -> None:
        """Instantiate it and initialize it at t = 0 with these start values.

        Raises:
            FmuError: if there is no such variable, or the FMU refuses.
        """
        self._messages.clear()
        with same_folder(), self._failing("initialize"):
            self._begin()
            for name, value in parameters.items():
                self._set_parameter(self.description.variable(name), value)
            if self._major == "2":
                self._fmu.setupExperiment(startTime=0.0)
                self._fmu.enterInitializationMode()
            else:
                self._fmu.enterInitializationMode(startTime=0.0)
            self._fmu.exitInitializationMode()

    def _begin(self) -> None:
        about = self.description
        if self._living and about.once_per_process:
            self._fmu.reset()
            return
        if self._living:
            free_one = self._fmu.fmi2FreeInstance if self._major == "2" else self._fmu.fmi3FreeInstance
            free_one(self._fmu.component)
        elif about.once_per_process:
            if about.file in _taken:
                raise FmuError(
                    f"{about.file} allows one instance per process, and another robot has it: give each drive a "
                    "process of its own (host: process)"
                )
            _taken.add(about.file)
        if self._major == "2":
            self._fmu.instantiate(callbacks=callbacks_of_fmi2(self._note))
        else:
            self._fmu.instantiate(logMessage=lambda _, status, category, text: self._note(status, text))
        self._living = True

    def step(self, time: float, h: float) -> None:
        """Let `h` [s] pass from `time` [s].

        Raises:
            FmuError: if the FMU fails or wants to end.
        """
        try:
            ended = self._fmu.doStep(time, h)
        except CallFailed as error:
            raise self.failure(f"step from t = {time:g} s to {time + h:g} s", error) from None
        if ended is not None and ended[1]:
            raise FmuError(
                f"{self.description.file} asks to end the simulation between t = {time:g} s and {time + h:g} s: "
                f"see what its parameters and inputs allow{self._said()}"
            )

    def access(self, names: Sequence[str]) -> Access:
        """Quick access to these variables, which must be numbers.

        Raises:
            FmuError: if there is no such variable, or it is no single number.
        """
        return Access(self, self._fmu, [self.description.variable(name) for name in names])

    def _set_parameter(self, variable: FmuVariable, value: Value) -> None:
        kind = variable.type
        number = isinstance(value, int | float) and not isinstance(value, bool)
        fits, expected = {
            "Boolean": (isinstance(value, bool), "true or false"),
            "String": (isinstance(value, str), "text"),
            **dict.fromkeys(_NUMBERS, (number and float(value).is_integer(), "a whole number")),
            **dict.fromkeys(_REALS, (number, "a number")),
        }.get(kind, (False, f"no value: a {kind} cannot be set from here"))
        if not variable.scalar:
            fits, expected = False, "no value: an array cannot be set from here"
        if not fits:
            raise FmuError(f"parameter '{variable.name}' of {self.description.file} is {value!r}, expected {expected}")
        if kind in _NUMBERS and kind not in _REALS:
            value = int(value)  # as a float it would not pass
        getattr(self._fmu, f"set{kind}")([variable.reference], [value])

    def _note(self, status: int, text: bytes) -> None:
        if status > 0:
            self._messages = [*self._messages, text.decode(errors="replace").strip()][-_TOLD:]

    def _said(self) -> str:
        return f"; it said: {' | '.join(self._messages)}" if self._messages else "; it gave no reason"

    @contextlib.contextmanager
    def _failing(self, doing: str) -> Iterator[None]:
        try:
            yield
        except FmuError:
            raise
        except Exception as error:  # fmpy raises Exception itself when an FMU gives no instance
            raise self.failure(doing, error) from None

    def failure(self, doing: str, error: Exception) -> FmuError:
        """The error that says that it failed to do something, and what it has said about that."""
        if isinstance(error, CallFailed):
            status = _STATUS[error.status] if 0 <= error.status < len(_STATUS) else f"status {error.status}"
            what = f"{error.function} returned {status}"
        else:
            what = str(error)
        return FmuError(f"{self.description.file} failed to {doing}: {what}{self._said()}")


class Access:
    """A few variables of an instance: all set, or all got, with one call per type."""

    def __init__(self, instance: FmuInstance, fmu: Any, variables: Sequence[FmuVariable]) -> None:
        self._instance = instance
        self._fmu = fmu
        for variable in variables:
            if variable.type not in _NUMBERS or not variable.scalar:
                raise FmuError(
                    f"variable '{variable.name}' of {instance.description.file} is of type {variable.type}"
                    f"{'' if variable.scalar else ', an array'}, expected a single number"
                )
        kinds = dict.fromkeys(v.type for v in variables)
        self._groups = [
            _Group(kind, [(n, v.reference) for n, v in enumerate(variables) if v.type == kind]) for kind in kinds
        ]
        self._many = len(variables)
        prefix = f"fmi{instance.description.fmi_version[0]}"
        self._setters = [getattr(fmu, f"{prefix}Set{group.type}") for group in self._groups]
        self._getters = [getattr(fmu, f"{prefix}Get{group.type}") for group in self._groups]
        self._counted = prefix == "fmi3"

    def set(self, values: Sequence[float]) -> None:
        """Set all, in the order in which they were named."""
        try:
            for group, setter in zip(self._groups, self._setters, strict=True):
                group.fill(values)
                setter(self._fmu.component, *(group.counted if self._counted else group.plain))
        except CallFailed as error:
            raise self._instance.failure("take its inputs", error) from None

    def get(self) -> list[float]:
        """All values, in the order in which they were named."""
        values = [0.0] * self._many
        try:
            for group, getter in zip(self._groups, self._getters, strict=True):
                getter(self._fmu.component, *(group.counted if self._counted else group.plain))
                for place, value in zip(group.places, group.values, strict=True):
                    values[place] = value
        except CallFailed as error:
            raise self._instance.failure("give its outputs", error) from None
        return values


class _Group:
    """Variables of one type, with the arrays that an FMI call takes."""

    def __init__(self, kind: str, members: list[tuple[int, int]]) -> None:
        self.type = kind
        self.places = [place for place, _ in members]
        n = len(members)
        self.values = (_NUMBERS[kind] * n)()
        references = (ctypes.c_uint32 * n)(*(reference for _, reference in members))
        self.plain = (references, n, self.values)
        self.counted = (*self.plain, n)
        self._whole = kind not in _REALS

    def fill(self, values: Sequence[float]) -> None:
        for k, place in enumerate(self.places):
            self.values[k] = round(values[place]) if self._whole else values[place]
