"""Any co-simulation FMU as a controller or a sensor: its variables are fields of messages, its ports follow from them.

In every tick k the FMU is given the fields that are its inputs, lets one time step pass, from t_k to t_k + dt, and its
outputs then are the messages of tick k; what no variable fills keeps its default, a header says time and component.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from components.robot.fmu_file import FmuError, describe
from components.robot.fmu_instance import FmuInstance
from components.robot.message_field import MessageField, made_of, message_field
from crowdcosim.component import Component, Controller, Sensor
from crowdcosim.messages import Header
from crowdcosim.setup import Setup, time_of


@dataclass(frozen=True, kw_only=True)
class Link:
    """The field of a message that a variable stands for."""

    field: str
    """such as `odometry.twist.twist.linear.x` or `goal.position[0]`: a message's type in snake_case, then its fields"""
    factor: float = 1.0
    """units of the field per unit of the variable: 0.0174533 where the variable is in degrees"""

    def __post_init__(self) -> None:
        message_field(self.field)
        if self.factor == 0.0:
            raise ValueError("factor is 0.0, expected the units of the field per unit of the variable")


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of an FMU as a component."""

    file: str
    """the FMU, `./controller.fmu`"""
    inputs: Mapping[str, str | Link] = field(default_factory=dict)
    """variable -> field that it is given; without inputs and outputs, those are linked that are called like fields"""
    outputs: Mapping[str, str | Link] = field(default_factory=dict)
    """variable -> field that it gives"""
    parameters: Mapping[str, float | bool | str] = field(default_factory=dict)
    """start values of the FMU's own variables, in its units"""

    def __post_init__(self) -> None:
        if not self.file.startswith(("./", "../", "/")):
            raise ValueError(f"file is '{self.file}', expected a path that begins with ./, ../ or /")
        for place, links in (("inputs", self.inputs), ("outputs", self.outputs)):
            for variable, link in links.items():
                if isinstance(link, str):
                    try:
                        message_field(link)
                    except ValueError as error:
                        raise ValueError(f"{place}: variable '{variable}': {error}") from None
        if self.inputs and not self.outputs:
            raise ValueError("outputs is empty, expected the variables that give something, beside inputs")


class _Linked(NamedTuple):
    """A variable and its field."""

    variable: str
    field: MessageField
    factor: float


class _Links(NamedTuple):
    inputs: list[_Linked]
    outputs: list[_Linked]


class _Fmu(Component):
    """What both kinds have in common."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._links = _links(config)
        self._instance: FmuInstance | None = None

    @classmethod
    def with_options(cls, config: Config) -> type[Component]:
        links = _links(config)

        def step(self: Any, **messages: Any) -> Any:
            return self._advance(messages)

        outputs = {link.field.port: link.field.type for link in links.outputs}
        result = NamedTuple("Result", list(outputs.items())) if len(outputs) > 1 else next(iter(outputs.values()))  # type: ignore[misc]
        step.__annotations__ = {link.field.port: link.field.type for link in links.inputs} | {"return": result}
        return type(cls.__name__, (cls,), {"step": step, "__doc__": cls.__doc__, "_result": result})

    def step(self) -> None:
        raise NotImplementedError("made anew with the ports of its FMU, see with_options")

    def reset(self, setup: Setup) -> None:
        """A new instance at t = 0.

        Raises:
            FmuError: if the FMU cannot be used, or has no such variables.
        """
        if self._instance is None:
            self._instance = FmuInstance(Path(self._config.file), setup.component)
            self._check(self._instance, setup.dt)
            self._give = self._instance.access([link.variable for link in self._links.inputs])
            self._take = self._instance.access([link.variable for link in self._links.outputs])
        self._instance.start(self._config.parameters)
        self._setup = setup
        self._steps = 0

    def _advance(self, messages: Mapping[str, Any]) -> Any:
        assert self._instance is not None, "step before reset"
        setup = self._setup
        try:
            given = [link.field.read(messages[link.field.port]) / link.factor for link in self._links.inputs]
        except ValueError as error:
            raise FmuError(f"{self._config.file} cannot be given its inputs at step {self._steps}: {error}") from None
        self._give.set(given)
        self._instance.step(self._steps * setup.dt, setup.dt)
        header = Header(stamp=time_of(self._steps * setup.period), frame_id=setup.component)
        self._steps += 1
        taken = [value * link.factor for value, link in zip(self._take.get(), self._links.outputs, strict=True)]
        found: dict[str, dict[MessageField, float]] = {}
        for link, value in zip(self._links.outputs, taken, strict=True):
            found.setdefault(link.field.port, {})[link.field] = value
        made = [made_of(next(iter(values)).type, values, header) for values in found.values()]
        return made[0] if len(made) == 1 else self._result(*made)  # type: ignore[attr-defined]

    def _check(self, instance: FmuInstance, dt: float) -> None:
        about = instance.description
        for link in self._links.inputs:
            known = about.variable(link.variable)
            if known.causality != "input":
                inputs = ", ".join(v.name for v in about.variables if v.causality == "input") or "it has none"
                raise FmuError(
                    f"inputs: '{known.name}' of {about.file} is of causality {known.causality}, expected an input: "
                    f"{inputs}"
                )
        fixed = about.fixed_step
        if fixed is not None and abs(dt / fixed - round(dt / fixed)) > 1e-6:
            raise FmuError(f"{about.file} advances in steps of {fixed:g} s, expected one that goes into {dt:g} s")


class FmuController(_Fmu, Controller):
    """An FMU that decides: its variables are fields of observations, and of a command."""


class FmuSensor(_Fmu, Sensor):
    """An FMU that observes: its variables are fields of the state, and of an observation."""


def _links(config: Config) -> _Links:
    """What the options say, or what the names of the FMU's variables say.

    Raises:
        FmuError: if they say nothing, or the FMU cannot be read.
    """
    if config.inputs or config.outputs:
        return _Links(*([_linked(v, link) for v, link in links.items()] for links in (config.inputs, config.outputs)))
    links = _Links([], [])
    for variable in describe(Path(config.file)).variables:
        side = {"input": links.inputs, "output": links.outputs}.get(variable.causality)
        try:
            if side is not None:
                side.append(_linked(variable.name, variable.name))
        except ValueError:
            continue
    if not links.outputs:
        raise FmuError(
            f"{config.file} has no output that is called like a field of a message (twist.linear.x): say under "
            f"`inputs` and `outputs` which of its variables stand for which; list them: crowdcosim fmu inspect "
            f"{config.file}"
        )
    return links


def _linked(variable: str, link: str | Link) -> _Linked:
    if isinstance(link, str):
        link = Link(field=link)
    return _Linked(variable, message_field(link.field), link.factor)
