"""Single numbers of messages by name, `odometry.twist.twist.linear.x` or `goal.position[0]`: read, and written anew."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from crowdcosim.component import snake_case
from crowdcosim.message import Message, field_names
from crowdcosim.messages import MESSAGES, Header

_TYPES = {snake_case(cls.__name__): cls for cls in MESSAGES.values()}


@dataclass(frozen=True, kw_only=True)
class MessageField:
    """One number of a message; its first part is the message's type in snake_case, which is also the port's name."""

    port: str
    type: type[Message]
    path: tuple[str | int, ...]
    """names of fields and, last, indices of an array"""

    def read(self, message: Message) -> float:
        """The number.

        Raises:
            ValueError: if the array is too short.
        """
        value: Any = message
        for part in self.path:
            if isinstance(part, int):
                if part >= len(value):
                    raise ValueError(f"{self} is asked for, but there are {len(value)}")
                value = value[part]
            else:
                value = getattr(value, part)
        return float(value)

    def __str__(self) -> str:
        return self.port + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in self.path)


def message_field(text: str) -> MessageField:
    """The field of that name.

    Raises:
        ValueError: if there is no such message or field, or if it is not a single number.
    """
    port, *names = text.split(".")
    if port not in _TYPES:
        raise ValueError(f"'{text}' begins with '{port}', expected a message: {', '.join(sorted(_TYPES))}")
    path: list[str | int] = []
    value: Any = _TYPES[port]()
    for part in names:
        match = re.fullmatch(r"(\w+)((?:\[\d+\])*)", part)
        if match is None or not isinstance(value, Message) or match[1] not in field_names(type(value)):
            known = ", ".join(field_names(type(value))) if isinstance(value, Message) else "none"
            raise ValueError(f"'{text}' has no '{part}', expected one of the fields there: {known}")
        value = getattr(value, match[1])
        path.append(match[1])
        indices = [int(index) for index in re.findall(r"\d+", match[2])]
        if isinstance(value, np.ndarray):
            if len(indices) != value.ndim:
                raise ValueError(f"'{text}' is an array, expected {value.ndim} indices: {part}{'[0]' * value.ndim}")
            value = value.dtype.type()
        elif indices:
            raise ValueError(f"'{text}' has indices, but '{match[1]}' is no array of numbers")
        path.extend(indices)
    if not isinstance(value, int | float | np.number | np.bool_):
        raise ValueError(f"'{text}' is a {type(value).__name__}, expected a single number")
    return MessageField(port=port, type=_TYPES[port], path=tuple(path))


def made_of(kind: type[Message], values: Mapping[MessageField, float], header: Header) -> Message:
    """A message with these fields, `header` if it has one, and all else at its default."""
    tree: dict[str | int, Any] = {}
    for field, value in values.items():
        branch = tree
        for part in field.path[:-1]:
            branch = branch.setdefault(part, {})
        branch[field.path[-1]] = value
    message = _filled(kind(), tree)
    if "header" in field_names(kind):
        message = replace(message, header=header)  # type: ignore[type-var]
    return message


def _filled(message: Message, tree: Mapping[str | int, Any]) -> Message:
    changes = {str(name): _value(getattr(message, str(name)), new) for name, new in tree.items()}
    return replace(message, **changes)  # type: ignore[type-var]


def _value(default: Any, new: Any) -> Any:
    if isinstance(default, Message):
        return _filled(default, new)
    if isinstance(default, np.ndarray):
        rows = max(len(default), *(row + 1 for row in new))
        array = np.zeros((rows, *default.shape[1:]), default.dtype)
        array[: len(default)] = default
        for row, value in new.items():
            for place, number in _places(row, value):
                array[place] = round(number) if default.dtype.kind in "iub" else number
        return array
    return type(default)(round(new)) if isinstance(default, int) else float(new)


def _places(row: int, value: Any) -> list[tuple[tuple[int, ...], float]]:
    """Indices and numbers of a row that is a number itself, or has some by column."""
    return (
        [((row, column), number) for column, number in value.items()] if isinstance(value, dict) else [((row,), value)]
    )
