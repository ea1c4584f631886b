"""Where two logs, or two runs of one component, begin to differ."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import numpy as np

from crowdcosim.cdr import decode
from crowdcosim.message import Message, field_names
from crowdcosim.messages import MESSAGES
from orchestrator.log.reader import Log
from orchestrator.log.recorder import Record


@dataclass(frozen=True, kw_only=True)
class Difference:
    """The first difference between two logs on one topic."""

    topic: str
    time: int
    """simulated time [ns]"""
    tick: int | None
    """that time in steps of the first log's scenario, None if it has none"""
    what: str
    """which field, and both values"""
    differing: int
    """messages of the topic that differ, from here to the end"""
    messages: int
    """messages of the topic in the longer log"""


def differences(a: Log, b: Log) -> list[Difference]:
    """What differs, topic by topic, the earliest first; empty if both hold the same data."""
    ours, theirs = _by_topic(a), _by_topic(b)
    period = _period(a)
    found = []
    for topic in dict.fromkeys((*ours, *theirs)):
        pairs = list(zip_longest(ours.get(topic, []), theirs.get(topic, [])))
        apart = [(x, y) for x, y in pairs if x != y]
        if apart:
            first, second = apart[0]
            time = min(r.time for r in apart[0] if r is not None)
            found.append(
                Difference(
                    topic=topic,
                    time=time,
                    tick=round(time / period) if period else None,
                    what=_what(first, second, (a.types | b.types)[topic]),
                    differing=len(apart),
                    messages=len(pairs),
                )
            )
    order = {record.topic: i for i, record in reversed(list(enumerate(a.records)))}
    return sorted(found, key=lambda d: (d.time, order.get(d.topic, len(a.records))))


def field_difference(a: Message, b: Message) -> str | None:
    """The first field in which two messages of one type differ, with both values; None if they are equal."""
    return next(_fields(a, b, ""), None)


def _by_topic(log: Log) -> dict[str, list[Record]]:
    records: dict[str, list[Record]] = {}
    for record in log.records:
        records.setdefault(record.topic, []).append(record)
    return records


def _period(log: Log) -> float | None:
    """The time step of the log's scenario [ns]."""
    return log.scenario()["dt"] * 1e9 if "scenario.json" in log.attachments else None


def _what(a: Record | None, b: Record | None, typename: str) -> str:
    if a is None or b is None:
        return f"only in the {'second' if a is None else 'first'} log"
    if a.time != b.time:
        return f"time: {a.time * 1e-9:g} s and {b.time * 1e-9:g} s"
    if typename not in MESSAGES:
        byte = next((i for i, (x, y) in enumerate(zip(a.payload, b.payload, strict=False)) if x != y), None)
        return f"length: {len(a.payload)} and {len(b.payload)} bytes" if byte is None else f"byte {byte}"
    return field_difference(decode(a.payload, typename), decode(b.payload, typename)) or "encoding"


def _fields(a: Any, b: Any, path: str) -> Iterator[str]:
    if isinstance(a, Message):
        for name in field_names(type(a)):
            yield from _fields(getattr(a, name), getattr(b, name), f"{path}.{name}" if path else name)
    elif isinstance(a, tuple):
        if len(a) != len(b):
            yield f"{path}: {len(a)} and {len(b)} items"
        for i, (x, y) in enumerate(zip(a, b, strict=False)):
            yield from _fields(x, y, f"{path}[{i}]")
    elif isinstance(a, np.ndarray):
        if a.shape != b.shape:
            yield f"{path}: {len(a)} and {len(b)} rows"
        elif not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
            index = tuple(int(i) for i in np.argwhere(a != b)[0])
            yield f"{path}{list(index)}: {a[index]} and {b[index]}"
    elif a != b:
        yield f"{path}: {a!r} and {b!r}"
