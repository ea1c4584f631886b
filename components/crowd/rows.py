"""Frozen dataclasses of arrays with one row for each person: some of the people, or those of two joined."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Rows = TypeVar("Rows")


def select(rows: Rows, which: NDArray[Any]) -> Rows:
    """The rows of `which`: indices, or a mask (N,)."""
    columns = {field.name: getattr(rows, field.name) for field in fields(rows)}  # type: ignore[arg-type]
    return type(rows)(**{name: select(v, which) if is_dataclass(v) else v[which] for name, v in columns.items()})


def join(first: Rows, second: Rows) -> Rows:
    """The rows of `first`, then those of `second`."""
    columns = {}
    for field in fields(first):  # type: ignore[arg-type]
        a, b = getattr(first, field.name), getattr(second, field.name)
        columns[field.name] = join(a, b) if is_dataclass(a) else np.concatenate([a, b])
    return type(first)(**columns)
