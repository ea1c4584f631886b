"""Writes each topic of a log as a table, for pandas, polars, R or a spreadsheet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
import polars as pl

from crowdcosim.cdr import decode, seconds
from crowdcosim.message import Message, field_names
from crowdcosim.messages import MESSAGES, Header, Image, PointCloud2
from orchestrator.log.folder import make_folder
from orchestrator.log.reader import Log

Form = Literal["csv", "parquet"]

_PICTURES = (Image.TYPE, PointCloud2.TYPE)
"""what no table holds well"""
_AXES = {2: ("x", "y"), 3: ("x", "y", "z")}
"""names of the columns of an array of vectors"""


def to_tables(log: Log, folder: Path, form: Form) -> list[Path]:
    """A new folder with a file per topic whose type we know, and the files.

    A row is a message, or one item of its arrays, such as one person of a `Crowd` or one beam of a `LaserScan`. The
    first column is `time`, the simulated time [s]; units are those of the messages.

    Raises:
        InputError: if the folder exists or cannot be written.
    """
    make_folder(folder)
    written = []
    for topic, name in log.types.items():
        if name in MESSAGES and name not in _PICTURES:
            table = topic_table(log, topic)
            if table.height:
                path = folder / f"{topic.strip('/').replace('/', '_')}.{form}"
                table.write_csv(path) if form == "csv" else table.write_parquet(path)
                written.append(path)
    return written


def topic_table(log: Log, topic: str) -> pl.DataFrame:
    """All messages of a topic, one below the other."""
    name = log.types[topic]
    messages = [(record.time / 1e9, decode(record.payload, name)) for record in log.records if record.topic == topic]
    tables = [table for time, message in messages if (table := _table(time, message)).height]
    return pl.concat(tables, how="vertical") if tables else pl.DataFrame()


def _table(time: float, message: Message) -> pl.DataFrame:
    items = [getattr(message, name) for name in field_names(type(message))]
    nested = [item for value in items if isinstance(value, tuple) for item in value if isinstance(item, Message)]
    if nested:
        return pl.concat([_table(time, item) for item in nested], how="vertical")
    scalars: dict[str, Any] = {"time": time}
    columns: dict[str, Any] = {}
    for name, value in _columns(message, ""):
        (columns if isinstance(value, np.ndarray | tuple) else scalars)[name] = value
    rows = max((len(column) for column in columns.values()), default=1)
    # Arrays that a message leaves empty, as a LaserScan its intensities, are no columns.
    columns = {name: column for name, column in columns.items() if len(column) == rows}
    return pl.DataFrame({name: [value] * rows for name, value in scalars.items()} | columns)


def _columns(message: Message, prefix: str) -> Iterator[tuple[str, Any]]:
    """Every field as a value, or as a column of its own where the message has many items."""
    fixed = {spec.name: spec.shape for spec in message._ARRAYS}
    for name in field_names(type(message)):
        value = getattr(message, name)
        path = f"{prefix}{name}"
        if isinstance(value, Header):
            yield f"{path}.frame_id", value.frame_id
            yield f"{path}.stamp", seconds(value.stamp)
        elif isinstance(value, Message):
            yield from _columns(value, f"{path}.")
        elif isinstance(value, np.ndarray):
            yield from _array_columns(path, value, fixed[name])
        else:
            yield path, value


def _array_columns(path: str, array: np.ndarray[Any, Any], shape: tuple[int | str, ...]) -> Iterator[tuple[str, Any]]:
    if isinstance(shape[0], int):
        parts = _AXES.get(shape[0], tuple(str(i) for i in range(shape[0])))
        for part, value in zip(parts, array.tolist(), strict=True):
            yield f"{path}.{part}", value
    elif len(shape) > 1:
        parts = _AXES.get(array.shape[1], tuple(str(i) for i in range(array.shape[1])))
        for i, part in enumerate(parts):
            yield f"{path}.{part}", array[:, i]
    else:
        yield path, array
