"""Messages to bytes and back: CDR with ROS 2's type hashes and schema texts, through rosbags."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from crowdcosim.interfaces.generate import own_messages
from crowdcosim.message import Message, MessageError
from crowdcosim.messages import MESSAGES


class _Flat:
    """A message as the wire has it: every array one-dimensional."""

    def __init__(self, message: Message) -> None:
        self.__dict__.update((f.name, getattr(message, f.name)) for f in fields(message))  # type: ignore[arg-type]
        for spec in message._ARRAYS:
            self.__dict__[spec.name] = self.__dict__[spec.name].reshape(-1)


def _maker(cls: type[Message]) -> Any:
    names = [f.name for f in fields(cls)]  # type: ignore[arg-type]

    def make(*values: Any) -> Message:
        return cls(**dict(zip(names, values, strict=True)))

    return make


@cache
def store() -> Any:
    """The type store: ROS 2 Jazzy's types and ours; decodes into the classes of `crowdcosim.messages`."""
    types = get_typestore(Stores.ROS2_JAZZY)
    for typename, text in own_messages().items():
        types.register(get_types_from_msg(text, typename))
    for typename, cls in MESSAGES.items():
        types.types[typename] = _maker(cls)
    return types


def encode(message: Message) -> bytes:
    """The message as CDR, little-endian, with the 4-byte encapsulation header.

    Raises:
        MessageError: if a field does not fit its type.
    """
    wire: Any = _Flat(message) if any(len(spec.shape) > 1 for spec in message._ARRAYS) else message
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
