"""The log of an episode: one MCAP file, profile ros2, written in a thread of its own."""

from __future__ import annotations

import hashlib
import json
import queue
import struct
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from mcap.writer import CompressionType, Writer

from crowdcosim import __version__
from crowdcosim.cdr import encode, schema_text, type_hash
from crowdcosim.message import Message
from orchestrator.errors import RunError

CHUNK_SIZE = 256 * 1024
"""With LZ4 the size that stalls the writer least [bytes]."""

FLUSH_PERIOD = 1.0
"""A killed run leaves at least what was written this long before [s]."""

SWITCH_INTERVAL = 0.0005
"""The writing thread gives way to the step loop within this time [s]; Python's default is ten times longer."""

BATCH = 32
"""Ticks that are handed to the writing thread at once: one waking instead of many, and warm caches."""

BACKLOG = 16
"""Batches that may wait for the disk before the run does."""

_QOS = """- history: keep_last
  depth: {depth}
  reliability: reliable
  durability: {durability}
  deadline: {{sec: 9223372036, nsec: 854775807}}
  lifespan: {{sec: 9223372036, nsec: 854775807}}
  liveliness: automatic
  liveliness_lease_duration: {{sec: 9223372036, nsec: 854775807}}
  avoid_ros_namespace_conventions: false
"""


class Channel(NamedTuple):
    """What one topic of the log holds."""

    topic: str
    type: str
    """ROS 2 type name"""
    component: str
    port: str
    latched: bool = False
    """holds for the whole run: whoever subscribes late gets it too (ROS 2's `transient_local`)"""

    @property
    def qos(self) -> str:
        """The `offered_qos_profiles` of rosbag2."""
        return _QOS.format(
            depth=1 if self.latched else 10, durability="transient_local" if self.latched else "volatile"
        )


class Record(NamedTuple):
    """One message of the log."""

    topic: str
    time: int
    """simulated time [ns]"""
    payload: bytes


def topic_of(component: str, port: str) -> str:
    """The topic of an output: `/component/port`, or `/component` where both bear the same name."""
    return f"/{component}" if component.rpartition("/")[2] == port else f"/{component}/{port}"


class DataHash:
    """SHA-256 over all data of a log, in the order in which it was committed."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, topic: str, time_ns: int, payload: bytes) -> None:
        self._hash.update(topic.encode() + struct.pack("<qQ", time_ns, len(payload)))
        self._hash.update(payload)

    def text(self) -> str:
        return self._hash.hexdigest()


class Recorder:
    """Writes what is committed; `close` is needed to get a complete file, whatever happened to the run."""

    def __init__(
        self,
        path: Path,
        channels: tuple[Channel, ...],
        *,
        attachments: Mapping[str, bytes],
        metadata: Mapping[str, Mapping[str, str]],
    ) -> None:
        self.path = path
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK_SIZE, compression=CompressionType.LZ4)
        self._writer.start(profile="ros2", library=f"crowdcosim {__version__}")
        self._channels = {channel.topic: self._register(channel) for channel in channels}
        for name, data in attachments.items():
            media = "application/json" if name.endswith(".json") else "application/octet-stream"
            self._writer.add_attachment(create_time=0, log_time=0, name=name, media_type=media, data=data)
        for name, values in metadata.items():
            self._writer.add_metadata(name, dict(values))
        self._sequence = dict.fromkeys(self._channels, 0)
        self._hash = DataHash()
        self._queue: queue.Queue[list[Record] | None] = queue.Queue(maxsize=BACKLOG)
        sys.setswitchinterval(SWITCH_INTERVAL)
        self._failure: BaseException | None = None
        self._flushed = self._handed = time.monotonic()
        self._batch: list[Record] = []
        self._ticks = 0
        self._thread = threading.Thread(target=self._write_all, daemon=True)
        self._thread.start()

    def add(self, records: list[Record]) -> None:
        """Hand over what was committed in one tick, in its order.

        Raises:
            RunError: if an earlier batch could not be written.
        """
        if self._failure is not None:
            raise RunError(None, None, f"cannot write {self.path}: {self._failure}")
        self._batch += records
        self._ticks += 1
        if self._ticks >= BATCH or time.monotonic() - self._handed > FLUSH_PERIOD:
            self._hand_over()

    def close(self, metadata: Mapping[str, Mapping[str, str]]) -> str:
        """Write the rest, `metadata` by name, and the index; return the data hash."""
        self._hand_over()
        self._queue.put(None)
        self._thread.join()
        data_hash = self._hash.text()
        try:
            for name, values in metadata.items():
                self._writer.add_metadata(
                    name, {**values, "data_hash": data_hash} if name == "outcome" else dict(values)
                )
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()
        except OSError as error:
            raise RunError(None, None, f"cannot write {self.path}: {error}") from None
        return data_hash

    def _hand_over(self) -> None:
        self._queue.put(self._batch)
        self._batch, self._ticks, self._handed = [], 0, time.monotonic()

    def _register(self, channel: Channel) -> int:
        schema = self._writer.register_schema(channel.type, "ros2msg", schema_text(channel.type).encode())
        return self._writer.register_channel(
            topic=channel.topic,
            message_encoding="cdr",
            schema_id=schema,
            metadata={
                "component": channel.component,
                "port": channel.port,
                "offered_qos_profiles": channel.qos,
                "topic_type_hash": type_hash(channel.type),
            },
        )

    def _write_all(self) -> None:
        while (records := self._queue.get()) is not None:
            if self._failure is None:
                try:
                    self._write(records)
                except Exception as error:
                    self._failure = error

    def _write(self, records: list[Record]) -> None:
        for topic, time_ns, payload in records:
            self._sequence[topic] += 1
            self._writer.add_message(
                channel_id=self._channels[topic],
                log_time=time_ns,
                publish_time=time_ns,
                data=payload,
                sequence=self._sequence[topic],
            )
            self._hash.add(topic, time_ns, payload)
        if time.monotonic() - self._flushed > FLUSH_PERIOD:
            self._file.flush()
            self._flushed = time.monotonic()


def as_json(data: Any) -> bytes:
    """Plain data as readable JSON bytes."""
    return json.dumps(data, indent=1, sort_keys=False).encode()


def record(topic: str, time_ns: int, message: Message) -> Record:
    """A message of the orchestrator's own."""
    return Record(topic, time_ns, encode(message))
