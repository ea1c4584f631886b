"""What all messages have in common: arrays of the declared type and shape, and a check that they are finite."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import cache
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np


class MessageError(ValueError):
    """A message does not hold what its type declares."""


class ArrayField(NamedTuple):
    """An array of primitives: dtype and shape, where a letter is a size shared with the other fields and "_" is any."""

    name: str
    dtype: np.dtype[Any]
    shape: tuple[int | str, ...]
    may_be_infinite: bool = False


class SequenceField(NamedTuple):
    """A tuple of strings or messages; `size` as in `ArrayField.shape`."""

    name: str
    size: str


class Message:
    """Base of all messages: frozen data classes that know their ROS 2 type."""

    __slots__ = ()
    TYPE: ClassVar[str]
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = ()
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = ()
    _NARROW: ClassVar[tuple[str, ...]] = ()
    _MAY_BE_INFINITE: ClassVar[tuple[str, ...]] = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(getattr(self, name), getattr(other, name)) for name in field_names(type(self)))

    __hash__ = None  # type: ignore[assignment]


class CoercedMessage(Message):
    """A message with arrays, sequences or 32-bit numbers, brought into the declared form when it is made.

    Arrays are copied, get the declared dtype and shape, and become read-only. Scalars that the wire holds as
    float32 are rounded, so that a message that never crossed a wire holds the same values as one that did.

    Raises:
        MessageError: if an array cannot have the declared dtype and shape.
    """

    __slots__ = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        sizes: dict[str, int] = {}
        for spec in self._ARRAYS:
            array = _coerced(self, spec, getattr(self, spec.name))
            put(self, spec.name, array)
            symbol = spec.shape[0]
            if sizes.setdefault(symbol, len(array)) != len(array) and symbol != "_":  # type: ignore[arg-type]
                self._disagree(spec.name, len(array), sizes[symbol])  # type: ignore[index]
        for name, symbol in self._SEQUENCES:
            items = tuple(getattr(self, name))
            put(self, name, items)
            if sizes.setdefault(symbol, len(items)) != len(items) and symbol != "_":
                self._disagree(name, len(items), sizes[symbol])
        for name in self._NARROW:
            put(self, name, float(np.float32(getattr(self, name))))

    def _disagree(self, name: str, size: int, others: int) -> None:
        raise MessageError(
            f"{type(self).__name__}.{name} has {size} rows where the fields before it have {others}: "
            "all fields over one letter must have the same length"
        )


def field_names(cls: type[Message]) -> tuple[str, ...]:
    """The fields of a message type, in the order of its definition."""
    return _field_names(cls)  # type: ignore[arg-type]  # a class is hashable, its instances are not


@cache
def _field_names(cls: type[Message]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(cls))  # type: ignore[arg-type]


def _coerced(message: Message, spec: ArrayField, value: Any) -> np.ndarray[Any, Any]:
    shape = spec.shape
    if (
        type(value) is np.ndarray
        and value.dtype is spec.dtype
        and value.ndim == len(shape)
        and (value.ndim == 1 or value.shape[1] == shape[1])
        and (type(shape[0]) is str or value.shape[0] == shape[0])
    ):
        array = value.copy(order="C")
    else:
        array = _converted(message, spec, value)
    array.setflags(write=False)
    return array


def _converted(message: Message, spec: ArrayField, value: Any) -> np.ndarray[Any, Any]:
    try:
        array = np.asarray(value)
        if array.dtype != spec.dtype and spec.dtype.kind in "ui" and array.size:
            _check_integers(array, spec.dtype)
        array = np.array(array, spec.dtype, order="C")
        return array.reshape(tuple(-1 if isinstance(s, str) else s for s in spec.shape))
    except (TypeError, ValueError, OverflowError) as error:
        expected = ", ".join(str(s) for s in spec.shape)
        raise MessageError(
            f"{type(message).__name__}.{spec.name}: expected {spec.dtype} of shape ({expected}), "
            f"found {_describe(value)} ({error})"
        ) from None


def _check_integers(array: np.ndarray[Any, Any], dtype: np.dtype[Any]) -> None:
    """Raise where a conversion would lose something without a word."""
    if array.dtype.kind == "f":
        raise TypeError("fractions would be lost")
    limits = np.iinfo(dtype)
    if array.dtype.kind in "ui" and not (limits.min <= array.min() and array.max() <= limits.max):
        raise OverflowError(f"out of {limits.min} to {limits.max}")


def check_finite(message: Message) -> None:
    """Raise `MessageError` that names the first field holding NaN, or infinity where that has no meaning."""
    if not _looks_finite(type(message))(message):  # type: ignore[arg-type]
        for path, value, may_be_infinite in _numbers(message, type(message).__name__):
            bad = np.isnan(value) if may_be_infinite else ~np.isfinite(value)
            if bad.any():
                index = [int(i) for i in np.argwhere(bad)[0]]
                place = f"{path}{index}" if index else path
                raise MessageError(f"{place} is {value[tuple(index)]}: outputs must be finite")


@cache
def _looks_finite(cls: type[Message]) -> Callable[[Message], bool]:
    """A quick test: False where a closer look is due. A sum of squares is finite only if every term is."""
    found = _paths(cls, "")
    get_scalars = _getter(found.scalars)
    get_infinite_scalars = _getter(found.infinite_scalars)
    getters = [attrgetter(path) for path in found.arrays]
    infinite_getters = [attrgetter(path) for path in found.infinite_arrays]
    sequence_getters = [attrgetter(path) for path in found.sequences]

    def looks_finite(message: Message) -> bool:
        if get_scalars is not None and not math.isfinite(sum(get_scalars(message)[:-1])):
            return False
        if get_infinite_scalars is not None and math.isnan(sum(get_infinite_scalars(message)[:-1])):
            return False
        for get in getters:
            flat = get(message).reshape(-1)
            if not math.isfinite(flat.dot(flat)):
                return False
        for get in infinite_getters:
            flat = get(message).reshape(-1)
            if math.isnan(flat.dot(flat)):
                return False
        return not any(isinstance(item, Message) for get in sequence_getters for item in get(message))

    return looks_finite


def _getter(paths: list[str]) -> attrgetter[tuple[Any, ...]] | None:
    """Gets all of these and one more, so that there always is a tuple."""
    return attrgetter(*paths, "TYPE") if paths else None


class _Paths(NamedTuple):
    """Where a message type has floats, by what the check does with them, and sequences."""

    scalars: list[str]
    infinite_scalars: list[str]
    arrays: list[str]
    infinite_arrays: list[str]
    sequences: list[str]


def _paths(cls: type[Message], prefix: str) -> _Paths:
    example = cls()
    found = _Paths(
        [],
        [],
        [prefix + a.name for a in cls._ARRAYS if a.dtype.kind == "f" and not a.may_be_infinite],
        [prefix + a.name for a in cls._ARRAYS if a.dtype.kind == "f" and a.may_be_infinite],
        [prefix + s.name for s in cls._SEQUENCES],
    )
    for name in field_names(cls):
        value = getattr(example, name)
        if isinstance(value, float):
            (found.infinite_scalars if name in cls._MAY_BE_INFINITE else found.scalars).append(prefix + name)
        elif isinstance(value, Message):
            for mine, inner in zip(found, _paths(type(value), f"{prefix}{name}."), strict=True):
                mine.extend(inner)
    return found


def _numbers(message: Message, path: str) -> Iterator[tuple[str, np.ndarray[Any, Any], bool]]:
    """Every float of a message: path, value as an array, and whether it may be infinite."""
    infinite = {spec.name for spec in message._ARRAYS if spec.may_be_infinite} | set(message._MAY_BE_INFINITE)
    for name in field_names(type(message)):
        value = getattr(message, name)
        if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
            yield f"{path}.{name}", np.asarray(value), name in infinite
        elif isinstance(value, Message):
            yield from _numbers(value, f"{path}.{name}")
        elif isinstance(value, tuple):
            for index, element in enumerate(value):
                if isinstance(element, Message):
                    yield from _numbers(element, f"{path}.{name}[{index}]")


def _describe(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype} of shape {value.shape}"
    return f"{type(value).__name__} {str(value)[:60]}"


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b)
    return bool(a == b)
