"""Reads the log of an episode, also one that was cut off."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Footer, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from crowdcosim.cdr import decode
from crowdcosim.host import Source
from orchestrator.errors import InputError
from orchestrator.log.recorder import DataHash, Record


@dataclass(frozen=True, kw_only=True)
class Topic:
    """One topic of a log."""

    name: str
    type: str
    component: str
    port: str
    count: int
    first: int
    """log time of its first message [ns]"""
    last: int
    """log time of its last message [ns]"""

    @property
    def rate(self) -> float | None:
        """Messages per simulated second [Hz], None with fewer than two."""
        return (self.count - 1) / ((self.last - self.first) * 1e-9) if self.last > self.first else None


@dataclass(kw_only=True)
class Log:
    """Everything in a log, messages in the order in which they were committed."""

    path: Path
    records: list[Record] = field(default_factory=list)
    types: dict[str, str] = field(default_factory=dict)
    """topic -> ROS 2 type"""
    places: dict[str, tuple[str, str]] = field(default_factory=dict)
    """topic -> (component, port)"""
    latched: set[str] = field(default_factory=set)
    """topics of which whoever subscribes late gets the last message too"""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    complete: bool = False
    """False: the run or the disk ended before the log did"""

    def topics(self) -> list[Topic]:
        """What each topic holds, in the order of their first messages."""
        spans: dict[str, list[int]] = {}
        for record in self.records:
            spans.setdefault(record.topic, []).append(record.time)
        return [
            Topic(
                name=name,
                type=self.types[name],
                component=self.places[name][0],
                port=self.places[name][1],
                count=len(times),
                first=times[0],
                last=times[-1],
            )
            for name, times in spans.items()
        ]

    def data_hash(self) -> str:
        """SHA-256 over all data, as `run` gave it."""
        data_hash = DataHash()
        for record in self.records:
            data_hash.add(*record)
        return data_hash.text()

    def outputs(self, component: str, port: str) -> Iterator[tuple[int, Any]]:
        """(log time [ns], message) of everything that an output gave."""
        topics = {topic for topic, place in self.places.items() if place == (component, port)}
        for record in self.records:
            if record.topic in topics:
                yield record.time, decode(record.payload, self.types[record.topic])

    def scenario(self) -> dict[str, Any]:
        """The resolved scenario.

        Raises:
            InputError: if the log has none: it was not written by `crowdcosim run`.
        """
        return dict(self._json("scenario.json"))

    def wiring(self) -> dict[str, dict[str, tuple[Source, ...]]]:
        """Component -> input port -> its sources."""
        return {
            component: {port: tuple(Source(**s) for s in sources) for port, sources in ports.items()}
            for component, ports in self._json("wiring.json").items()
        }

    def _json(self, name: str) -> Any:
        if name not in self.attachments:
            raise InputError(f"{self.path} has no attachment '{name}': it is not the log of a crowdcosim run")
        return json.loads(self.attachments[name])


def read_log(path: Path) -> Log:
    """Read a log; of one that was cut off, every complete chunk.

    Raises:
        InputError: if there is no such file, or it is not an MCAP file.
    """
    log = Log(path=path)
    channels: dict[int, Channel] = {}
    schemas: dict[int, Schema] = {}
    try:
        with path.open("rb") as stream:
            for item in StreamReader(stream).records:
                _take(log, item, channels, schemas)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except (McapError, EOFError, ValueError, RuntimeError, struct.error) as error:
        if not channels:
            raise InputError(f"{path} is not an MCAP log: {error or type(error).__name__}") from None
    return log


def _take(log: Log, item: Any, channels: dict[int, Channel], schemas: dict[int, Schema]) -> None:
    match item:
        case Schema():
            schemas[item.id] = item
        case Channel():
            channels[item.id] = item
            log.types[item.topic] = schemas[item.schema_id].name
            log.places[item.topic] = (item.metadata.get("component", ""), item.metadata.get("port", ""))
            if "transient_local" in item.metadata.get("offered_qos_profiles", ""):
                log.latched.add(item.topic)
        case Message():
            log.records.append(Record(channels[item.channel_id].topic, item.log_time, item.data))
        case Attachment():
            log.attachments[item.name] = item.data
        case Metadata():
            log.metadata[item.name] = item.metadata
        case Footer():
            log.complete = True
