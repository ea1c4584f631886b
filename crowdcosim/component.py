"""The contract of a component: a typed config, `reset(setup)`, and `step(...)` whose types are its ports."""

from __future__ import annotations

import dataclasses
import json
import re
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from pydantic import ConfigDict, TypeAdapter, ValidationError

from crowdcosim.message import Message
from crowdcosim.messages import Metrics
from crowdcosim.setup import Setup

Kind = Literal["reactor", "mover", "observer"]


class ComponentError(Exception):
    """A component's class or config breaks the contract; the message says where and how."""


@dataclass(frozen=True, kw_only=True)
class NoConfig:
    """The config of a component that has none."""


class Component:
    """Base of all components. A subclass defines `step` with keyword arguments, one per input, and typed results.

    Inputs are message types: `Crowd` must be there, `Crowd | None` may be missing, `tuple[RobotState, ...]` takes
    all there are. The result is one message, a `NamedTuple` of messages, or None. An output port bears the tuple's
    field name, or the message's name in snake_case.

    The annotation of `config` in `__init__` is a frozen, keyword-only dataclass: the component's options.
    """

    kind: ClassVar[Kind] = "reactor"

    step: Callable[..., Any]

    @classmethod
    def with_options(cls, config: Any) -> type[Component]:
        """The class whose `step` has the ports that these options ask for: this one, unless ports depend on them."""
        return cls

    def reset(self, setup: Setup) -> Any:
        """Begin an episode. Called before the first step, and again for every further episode."""


class Sensor(Component):
    """Observes the committed state of its tick; what it says is of that tick, or of an earlier one if it is late.

    If its config has a method `frames(model: RobotModel) -> Mapping[str, Mount]`, these frames are in `/tf_static`: the
    key "" is the frame that is called as the component is, others are called `<component>/<key>`.
    """


class Controller(Component):
    """Turns this tick's observations into this tick's command, usually a `Twist` in the robot's frame."""


class Mover(Component):
    """Owns a part of the state: `reset` returns the state at t = 0, `step` turns the state at t into that at t + dt."""

    kind: ClassVar[Kind] = "mover"


class Evaluator(Component):
    """Observes what was committed and judges it; nothing flows back. `step` returns None."""

    kind: ClassVar[Kind] = "observer"

    def finish(self) -> Metrics:
        """The verdict, asked for once after the last step."""
        raise NotImplementedError(f"{type(self).__name__} must define finish()")


@dataclass(frozen=True, kw_only=True)
class Input:
    """An input port, as the signature of `step` declares it."""

    name: str
    type: type[Message]
    optional: bool = False
    """may be left unconnected; `step` then gets None"""
    many: bool = False
    """takes every source of its type, as a tuple in the scenario's order"""


@dataclass(frozen=True, kw_only=True)
class Output:
    """An output port, as the return type of `step` declares it."""

    name: str
    type: type[Message]


@dataclass(frozen=True, kw_only=True)
class Ports:
    """What a component takes and gives."""

    kind: Kind
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]


def snake_case(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def ports_of(cls: type[Component]) -> Ports:
    """Read a component class's ports from the signature of its `step`.

    Raises:
        ComponentError: if the signature is not made of message types.
    """
    step = getattr(cls, "step", None)
    if step is None:
        raise ComponentError(f"{cls.__name__} has no step(): define `def step(self, ...) -> ...` with message types")
    hints = _hints(step, cls)
    returns = hints.pop("return", types.NoneType)
    inputs = tuple(_input(cls, name, hint) for name, hint in hints.items())
    outputs = _outputs(cls, returns)
    if cls.kind == "observer":
        if outputs:
            raise ComponentError(f"{cls.__name__}.step must return None: nothing flows back from an evaluator")
        outputs = (Output(name="metrics", type=Metrics),)
    return Ports(kind=cls.kind, inputs=inputs, outputs=outputs)


def _hints(function: Any, cls: type) -> dict[str, Any]:
    try:
        return typing.get_type_hints(function)
    except NameError as error:
        raise ComponentError(f"{cls.__name__}.{function.__name__}: {error}; import every type it names") from None


def _input(cls: type, name: str, hint: Any) -> Input:
    optional = many = False
    arguments = typing.get_args(hint)
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        optional, hint = True, next((a for a in arguments if a is not types.NoneType), hint)
    elif typing.get_origin(hint) is tuple and len(arguments) == 2 and arguments[1] is Ellipsis:
        many, hint = True, arguments[0]
    if not (isinstance(hint, type) and issubclass(hint, Message)):
        raise ComponentError(
            f"{cls.__name__}.step: input '{name}' is {hint!r}, expected a message type of crowdcosim.messages, "
            "such a type `| None`, or `tuple[..., ...]` of one"
        )
    return Input(name=name, type=hint, optional=optional, many=many)


def _outputs(cls: type, returns: Any) -> tuple[Output, ...]:
    if returns is types.NoneType:
        return ()
    if isinstance(returns, type) and issubclass(returns, Message):
        return (Output(name=snake_case(returns.__name__), type=returns),)
    if isinstance(returns, type) and issubclass(returns, tuple) and hasattr(returns, "_fields"):
        fields = _hints(returns, cls)
        if all(isinstance(t, type) and issubclass(t, Message) for t in fields.values()):
            return tuple(Output(name=name, type=fields[name]) for name in returns._fields)
    raise ComponentError(
        f"{cls.__name__}.step returns {returns!r}, expected a message type, a NamedTuple of message types, or None"
    )


def by_port(ports: Ports, result: Any) -> dict[str, Message]:
    """What `step` or `reset` returned, as output port -> message.

    Raises:
        ComponentError: if it is not what the signature promises.
    """
    values = tuple(result) if isinstance(result, tuple) else () if result is None else (result,)
    if len(values) != len(ports.outputs):
        raise ComponentError(f"returned {len(values)} messages where its signature promises {len(ports.outputs)}")
    for output, value in zip(ports.outputs, values, strict=True):
        if type(value) is not output.type:
            raise ComponentError(
                f"returned {type(value).__name__} on port '{output.name}' where its signature promises "
                f"{output.type.__name__}"
            )
    return {output.name: value for output, value in zip(ports.outputs, values, strict=True)}


def config_type(cls: type[Component]) -> type:
    """The config dataclass of a component class: the annotation of `config` in its `__init__`.

    Raises:
        ComponentError: if there is an `__init__` whose `config` is not annotated with a frozen dataclass.
    """
    if cls.__init__ is object.__init__:
        return NoConfig
    hint = _hints(cls.__init__, cls).get("config")
    if hint is None or not dataclasses.is_dataclass(hint) or not isinstance(hint, type):
        raise ComponentError(
            f"{cls.__name__}.__init__ must take `config: Config`, where Config is a frozen, keyword-only dataclass"
        )
    return hint


def config_adapter(cls: type[Component]) -> TypeAdapter[Any]:
    """Validator and JSON Schema of a component's config; unknown keys and lossy conversions are refused."""
    config = config_type(cls)
    if not hasattr(config, "__pydantic_config__"):
        setattr(config, "__pydantic_config__", ConfigDict(extra="forbid", allow_inf_nan=False))  # noqa: B010
    return TypeAdapter(config)


def make(cls: type[Component], options: Mapping[str, Any]) -> Component:
    """A component from its class and the options of the scenario.

    Raises:
        pydantic.ValidationError: if the options do not fit the config.
    """
    config = _config(cls, options)
    if cls.__init__ is object.__init__:
        return cls()
    return cls.with_options(config)(config=config)  # type: ignore[call-arg]


def ports_with(cls: type[Component], options: Mapping[str, Any]) -> Ports:
    """The ports of a component of this class with the options of the scenario.

    Raises:
        ComponentError: if the signature is not made of message types, or the options lead to none.
        pydantic.ValidationError: if the options do not fit the config.
    """
    if cls.with_options.__func__ is Component.with_options.__func__:  # type: ignore[attr-defined]
        return ports_of(cls)
    return ports_of(cls.with_options(_config(cls, options)))


def _config(cls: type[Component], options: Mapping[str, Any]) -> Any:
    # As JSON, strictly: lists become tuples, but "3" is no number.
    return config_adapter(cls).validate_json(json.dumps(dict(options)), strict=True)


__all__ = [
    "Component",
    "ComponentError",
    "Controller",
    "Evaluator",
    "Input",
    "Mover",
    "Output",
    "Ports",
    "Sensor",
    "ValidationError",
    "by_port",
    "config_adapter",
    "config_type",
    "make",
    "ports_of",
    "ports_with",
    "snake_case",
]
