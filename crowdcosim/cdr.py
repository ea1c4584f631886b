"""Messages to bytes and back: CDR with ROS 2's type hashes and schema texts, through rosbags."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from crowdcosim.interfaces.generate import own_messages
from crowdcosim.message import Message, MessageError, field_names
from crowdcosim.messages import MESSAGES


class _Flat:
    """A message as the wire has it: every array one-dimensional."""


@cache
def _flattener(cls: type[Message]) -> Callable[[Message], Any]:
    """What makes a message of type `cls` ready for the encoder."""
    names = field_names(cls)
    tables = [spec.name for spec in cls._ARRAYS if len(spec.shape) > 1]
    if not tables:
        return lambda message: message
    values = attrgetter(*names)

    def flatten(message: Message) -> _Flat:
        flat = _Flat()
        flat.__dict__ = members = dict(zip(names, values(message), strict=True))
        for name in tables:
            members[name] = members[name].reshape(-1)
        return flat

    return flatten


def _maker(cls: type[Message]) -> Callable[..., Message]:
    """Makes a message from decoded fields, in their order; arrays come as views into the bytes and are copied."""
    setters = [getattr(cls, name).__set__ for name in field_names(cls)]
    position = {name: i for i, name in enumerate(field_names(cls))}
    arrays = [(position[a.name], a.name, a.shape, a.shape[1] if len(a.shape) > 1 else 0) for a in cls._ARRAYS]
    sequences = [(position[s.name], s.name, s.size) for s in cls._SEQUENCES]

    def make(*decoded: Any) -> Message:
        values = list(decoded)
        sizes: dict[int | str, int] = {}
        for i, name, shape, columns in arrays:
            array = values[i].copy()
            if columns:
                array = array.reshape(-1, columns)
            array.setflags(write=False)
            values[i] = array
            if sizes.setdefault(shape[0], len(array)) != len(array) and shape[0] != "_":
                raise MessageError(f"{name} has {len(array)} rows, the fields before it {sizes[shape[0]]}")
        for i, name, size in sequences:
            values[i] = tuple(values[i])
            if sizes.setdefault(size, len(values[i])) != len(values[i]) and size != "_":
                raise MessageError(f"{name} has {len(values[i])} items, the fields before it {sizes[size]}")
        message = object.__new__(cls)
        for put, value in zip(setters, values, strict=True):
            put(message, value)
        return message

    return make


@cache
def store() -> Any:
    """The type store: ROS 2 Jazzy's types and ours; decodes into the classes of `crowdcosim.messages`."""
    types = get_typestore(Stores.ROS2_JAZZY)
    for typename, text in own_messages().items():
        types.register(get_types_from_msg(text, typename))
    for typename, cls in MESSAGES.items():
        types.types[typename] = _maker(cls)  # type: ignore[assignment]
    return types


def encode(message: Message) -> bytes:
    """The message as CDR, little-endian, with the 4-byte encapsulation header.

    Raises:
        MessageError: if a field does not fit its type.
    """
    wire = _flattener(type(message))(message)  # type: ignore[arg-type]
    try:
        return bytes(store().serialize_cdr(wire, message.TYPE))
    except Exception as error:
        raise MessageError(f"{message.TYPE} cannot be encoded: {error}") from error


def decode(data: bytes, typename: str) -> Any:
    """The message of type `typename` that `data` holds.

    Raises:
        MessageError: if the bytes are not such a message.
    """
    try:
        message = store().deserialize_cdr(data, typename)
    except Exception as error:
        raise MessageError(f"{len(data)} bytes are not a {typename}: {error or type(error).__name__}") from error
    return message


@cache
def type_hash(typename: str) -> str:
    """The ROS 2 type hash (REP 2016), `RIHS01_...`."""
    return str(store().hash_rihs01(typename))


@cache
def schema_text(typename: str) -> str:
    """The type's definition with all that it depends on, in the `ros2msg` form of MCAP."""
    return str(store().generate_msgdef(typename, ros_version=2)[0])


def seconds(stamp: Any) -> float:
    """A `Time` as seconds [s]."""
    return float(stamp.sec) + float(stamp.nanosec) * 1e-9


__all__ = ["decode", "encode", "schema_text", "seconds", "store", "type_hash"]
assert np.little_endian, "CDR is written little-endian; big-endian machines are not supported"
