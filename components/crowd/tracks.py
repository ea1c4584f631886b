"""Files of recorded tracks: where people were at which time, in the forms in which data sets are published.

    obsmat   ETH and UCY (Pellegrini, Ess, Schindler and van Gool 2009, "You'll never walk alone"): columns frame, id,
             x, z, y, and velocities, which are not used; metres; the file does not say its frame rate
    petrack  PeTrack and JuPedSim: columns id, frame, x, y, and others; comments say `framerate: 16` and `x/cm` or `x/m`
    csv      a header with id, t [s], x, y, among others, in any order

Lines that begin with # are comments everywhere.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Form = Literal["obsmat", "petrack", "csv"]
Unit = Literal["m", "cm", "mm"]

T = TypeVar("T", float, str)

METRES: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}
COLUMNS = ("id", "t", "x", "y")


class TrackError(ValueError):
    """What is wrong with a file of tracks, and where."""


@dataclass(frozen=True, kw_only=True)
class Tracks:
    """P people with S samples together, by id, and for each by time."""

    id: NDArray[np.int64]
    """(P,) as in the file"""
    first: NDArray[np.int64]
    """(P + 1,) person p has the samples first[p] to first[p + 1]"""
    time: Array
    """(S,) since the first sample of all [s]"""
    position: Array
    """(S, 2) [m]"""


def read_tracks(path: Path, *, form: Form | None, frame_rate: float | None, unit: Unit | None) -> Tracks:
    """The tracks in a file.

    Args:
        path: where it is
        form: of the file; None: as its content looks
        frame_rate: frames per second, where the file does not say it
        unit: of positions, where the file does not say it

    Raises:
        TrackError: with the line, what was found and what was expected.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise TrackError(f"{path}: {error.strerror}; write './name' for a file beside the scenario") from None
    except UnicodeDecodeError:
        raise TrackError(f"{path}: not a text file") from None
    rows = [
        (number, text) for number, text in enumerate(lines, 1) if text.strip() and not text.lstrip().startswith("#")
    ]
    if not rows:
        raise TrackError(f"{path}: no line with data")
    comments = "\n".join(text for text in lines if text.lstrip().startswith("#"))
    form = form or _form(path, rows[0], comments)
    rate = _said(path, "frame_rate", _rate_in(comments) if form == "petrack" else None, frame_rate)
    length = _said(path, "unit", _unit_in(comments) if form == "petrack" else None, unit)
    if form == "csv":
        table = list(_csv(path, rows))
        if rate is not None:
            raise TrackError(f"{path}: a csv file has times in seconds, expected no `frame_rate`")
        rate = 1.0
    else:
        columns = (1, 0, 2, 4) if form == "obsmat" else (0, 1, 2, 3)
        table = list(_numbers(path, rows, columns, separator=None))
        if rate is None:
            raise TrackError(f"{path}: the file does not say its frame rate; give `frame_rate`{_HINTS[form]}")
        if length is None and form == "petrack":
            raise TrackError(f"{path}: no comment says the unit (such as 'x/m'); give `unit`: m, cm or mm")
    return _tracks(path, np.array(table), float(rate), METRES[length or "m"])


_HINTS = {"obsmat": ", such as 15 for ETH's seq_eth, 25 for seq_hotel and UCY", "petrack": ""}


def _form(path: Path, row: tuple[int, str], comments: str) -> Form:
    """What the file looks like, from its first line of data."""
    number, text = row
    if "," in text:
        return "csv"
    columns = len(text.split())
    if columns == 8 and not comments:
        return "obsmat"
    if columns >= 4 and _rate_in(comments) is not None:
        return "petrack"
    raise TrackError(
        f"{path}:{number}: found {columns} columns, expected a header with {', '.join(COLUMNS)} (csv), 8 columns "
        "(obsmat), or 4 and more with a comment '# framerate: ...' (petrack); or give `format`"
    )


def _rate_in(comments: str) -> float | None:
    found = re.search(r"frame\s*rate\s*[:=]?\s*(\d+(?:\.\d+)?)", comments, re.IGNORECASE)
    return float(found[1]) if found else None


def _unit_in(comments: str) -> str | None:
    found = re.search(r"\bx\s*/\s*(cm|mm|m)\b|\bin\s+(cm|mm|m)\b", comments, re.IGNORECASE)
    return (found[1] or found[2]).lower() if found else None


def _said(path: Path, option: str, by_file: T | None, given: T | None) -> T | None:
    """What the file says or, where it says nothing, what was given."""
    if by_file is not None and given is not None and by_file != given:
        raise TrackError(f"{path}: the file says {by_file}, but `{option}` is {given}; leave it out")
    return given if by_file is None else by_file


def _csv(path: Path, rows: list[tuple[int, str]]) -> Iterator[tuple[float, ...]]:
    number, header = rows[0]
    names = [name.strip() for name in header.split(",")]
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise TrackError(
            f"{path}:{number}: no column {' and '.join(missing)} in the header, found {', '.join(names)}; "
            f"expected {', '.join(COLUMNS)}"
        )
    yield from _numbers(path, rows[1:], tuple(names.index(name) for name in COLUMNS), separator=",")


def _numbers(
    path: Path, rows: list[tuple[int, str]], columns: tuple[int, ...], separator: str | None
) -> Iterator[tuple[float, ...]]:
    """Line number, id, frame or time, x and y of each row."""
    for number, text in rows:
        cells = text.split(separator)
        if len(cells) <= max(columns):
            raise TrackError(f"{path}:{number}: found {len(cells)} columns, expected at least {max(columns) + 1}")
        values = []
        for column, name in zip(columns, ("id", "time or frame", "x", "y"), strict=True):
            try:
                value = float(cells[column])
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise TrackError(f"{path}:{number}: found '{cells[column].strip()}' as {name}, expected a number")
            values.append(value)
        if values[0] < 0 or values[0] != int(values[0]):
            raise TrackError(f"{path}:{number}: id is {values[0]:g}, expected a whole number, zero or more")
        yield (number, *values)


def _tracks(path: Path, table: Array, rate: float, metres: float) -> Tracks:
    """Tracks of rows (S, 5): line, id, frame, x, y."""
    if not len(table):
        raise TrackError(f"{path}: no line with data after the header")
    line, who, frame = table[:, 0], table[:, 1].astype(np.int64), table[:, 2]
    order = np.lexsort((frame, who))
    who, frame = who[order], frame[order]
    twice = (np.diff(who) == 0) & (np.diff(frame) == 0)
    if twice.any():
        k = int(twice.argmax())
        a, b = sorted(line[order[k : k + 2]].astype(int))
        raise TrackError(f"{path}:{b}: id {who[k]} is there a second time at the time of line {a}")
    number, first = np.unique(who, return_index=True)
    return Tracks(
        id=number,
        first=np.append(first, len(who)).astype(np.int64),
        time=(frame - frame.min()) / rate,
        position=np.ascontiguousarray(table[order, 3:5]) * metres,
    )
