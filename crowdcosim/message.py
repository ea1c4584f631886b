"""What every message has in common: arrays of the declared type and shape, read-only, and a check that they are finite."""

from __future__ import annotations

import math
from dataclasses import fields
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
    """Base of all messages. Arrays are coerced to the declared dtype and shape and made read-only.

    Scalars that the wire holds as float32 are rounded when the message is made, so that a message that never
    crossed a wire holds the same values as one that did.

    Raises:
        MessageError: if an array cannot have the declared dtype and shape.
    """

    __slots__ = ()
    TYPE: ClassVar[str]
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = ()
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = ()
    _NARROW: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        sizes: dict[str, int] = {}
        for spec in self._ARRAYS:
            value = self._coerced(spec, getattr(self, spec.name))
            object.__setattr__(self, spec.name, value)
            symbol = spec.shape[0]
            if isinstance(symbol, str) and symbol != "_":
                self._agree(sizes, symbol, len(value), spec.name)
        for sequence in self._SEQUENCES:
            items = tuple(getattr(self, sequence.name))
            object.__setattr__(self, sequence.name, items)
            if sequence.size != "_":
                self._agree(sizes, sequence.size, len(items), sequence.name)
        for name in self._NARROW:
            object.__setattr__(self, name, float(np.float32(getattr(self, name))))

    def _agree(self, sizes: dict[str, int], symbol: str, size: int, name: str) -> None:
        if sizes.setdefault(symbol, size) != size:
            raise MessageError(
                f"{type(self).__name__}.{name} has {size} rows where the fields before it have {sizes[symbol]}: "
                f"all fields over {symbol} must have the same length"
            )

    def _coerced(self, spec: ArrayField, value: Any) -> np.ndarray[Any, Any]:
        if (
            type(value) is np.ndarray
            and value.dtype == spec.dtype
            and value.ndim == len(spec.shape)
            and not value.flags.writeable
            and value.flags.aligned
            and value.flags.c_contiguous
            and (len(spec.shape) == 1 or value.shape[1:] == spec.shape[1:])
            and (type(spec.shape[0]) is str or value.shape[0] == spec.shape[0])
        ):
            return value
        try:
            array = np.asarray(value)
            if array.dtype != spec.dtype and spec.dtype.kind in "ui" and array.size:
                _check_integers(array, spec.dtype)
            array = np.array(array, spec.dtype, order="C")
            array = array.reshape(tuple(-1 if isinstance(s, str) else s for s in spec.shape))
        except (TypeError, ValueError, OverflowError) as error:
            expected = ", ".join(str(s) for s in spec.shape)
            raise MessageError(
                f"{type(self).__name__}.{spec.name}: expected {spec.dtype} of shape ({expected}), "
                f"found {_describe(value)} ({error})"
            ) from None
        array.flags.writeable = False
        return array

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))  # type: ignore[arg-type]

    __hash__ = None  # type: ignore[assignment]


def check_finite(message: Any, where: str = "") -> None:
    """Raise `MessageError` that names the first field holding NaN, or infinity where that has no meaning."""
    path = where or type(message).__name__
    for spec in message._ARRAYS:
        if spec.dtype.kind != "f":
            continue
        array = getattr(message, spec.name)
        bad = np.isnan(array) if spec.may_be_infinite else ~np.isfinite(array)
        if bad.any():
            index = tuple(int(i) for i in np.argwhere(bad)[0])
            raise MessageError(f"{path}.{spec.name}{list(index)} is {array[index]}: outputs must be finite")
    for item in fields(message):
        value = getattr(message, item.name)
        if isinstance(value, float):
            if not math.isfinite(value):
                raise MessageError(f"{path}.{item.name} is {value}: outputs must be finite")
        elif isinstance(value, Message):
            check_finite(value, f"{path}.{item.name}")
        elif isinstance(value, tuple):
            for number, element in enumerate(value):
                if isinstance(element, Message):
                    check_finite(element, f"{path}.{item.name}[{number}]")


def _check_integers(array: np.ndarray[Any, Any], dtype: np.dtype[Any]) -> None:
    """Raise where a conversion would lose something without a word."""
    if array.dtype.kind == "f":
        raise TypeError("fractions would be lost")
    limits = np.iinfo(dtype)
    if array.dtype.kind in "ui" and not (limits.min <= array.min() and array.max() <= limits.max):
        raise OverflowError(f"out of {limits.min} to {limits.max}")


def _describe(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype} of shape {value.shape}"
    return f"{type(value).__name__} {str(value)[:60]}"


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b)
    return bool(a == b)
