"""Whether a log is well-formed: what other people's tools for MCAP and ROS 2 rely on."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Message,
    Metadata,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader, breakup_chunk

from crowdcosim.cdr import decode, schema_text, type_hash
from crowdcosim.message import MessageError
from crowdcosim.messages import MESSAGES
from orchestrator.errors import InputError

BROKEN = (McapError, EOFError, ValueError, RuntimeError, struct.error)
"""what reading a broken file may raise"""


def faults(path: Path) -> list[str]:
    """Everything that is wrong with a log, each with the byte at which it was found; empty if it is well-formed.

    Raises:
        InputError: if the file cannot be read.
    """
    check = _Check()
    try:
        with path.open("rb") as stream:
            try:
                for offset, record in _records(stream):
                    check.record(offset, record)
            except BROKEN as error:
                check.fault(stream.tell(), f"cannot be read further: {str(error) or type(error).__name__}")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    check.end()
    return check.faults


def _records(stream: Any) -> Iterator[tuple[int, Any]]:
    """Every record of a file and the byte it begins at; chunks as they are."""
    offset = 8  # after the magic bytes
    for record in StreamReader(stream, emit_chunks=True, validate_crcs=True).records:
        yield offset, record
        offset = stream.tell()


class _Check:
    def __init__(self) -> None:
        self.faults: list[str] = []
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._chunks: dict[int, tuple[Chunk, list[Message]]] = {}
        self._indexed: set[int] = set()
        self._summary: set[tuple[str, int]] = set()
        self._seen: Counter[type] = Counter()
        self._messages: Counter[int] = Counter()
        self._times: list[int] = []
        self._statistics: Statistics | None = None
        self._of: dict[type, Callable[[int, Any], None]] = {
            Header: self._header,
            Schema: self._schema,
            Channel: self._channel,
            Chunk: self._chunk,
            Message: self._message,
            ChunkIndex: self._chunk_index,
            Statistics: self._take_statistics,
        }

    def fault(self, offset: int, text: str) -> None:
        self.faults.append(f"byte {offset}: {text}")

    def record(self, offset: int, record: Any) -> None:
        """The next record of the file."""
        if not self._seen and not isinstance(record, Header):
            self.fault(offset, f"the first record is {type(record).__name__}, expected Header")
        self._seen[type(record)] += 1
        examine = self._of.get(type(record))
        if examine is not None:
            examine(offset, record)

    def end(self) -> None:
        """After the last record."""
        for kind in (Header, DataEnd, Footer, Statistics):
            if self._seen[kind] != 1:
                self.faults.append(f"{self._seen[kind]} {kind.__name__} records, expected 1: the log was cut off")
        if self._seen[Footer]:
            self._check_summary()

    def _header(self, offset: int, header: Header) -> None:
        if header.profile != "ros2":
            self.fault(offset, f"the profile is '{header.profile}', expected ros2")
        if not header.library:
            self.fault(offset, "the header names no library")

    def _schema(self, offset: int, schema: Schema) -> None:
        if self._seen[DataEnd]:
            self._summary.add(("schema", schema.id))
        if schema.id == 0:
            self.fault(offset, f"schema {schema.name} has the id 0")
        if self._schemas.setdefault(schema.id, schema) != schema:
            self.fault(offset, f"schema {schema.id} is {schema.name} here and {self._schemas[schema.id].name} before")
        if schema.encoding != "ros2msg":
            self.fault(offset, f"schema {schema.name} is encoded as '{schema.encoding}', expected ros2msg")
        elif schema.name in MESSAGES and schema.data.decode() != schema_text(schema.name):
            self.fault(offset, f"schema {schema.name} is not the definition that this version of crowdcosim has")

    def _channel(self, offset: int, channel: Channel) -> None:
        if self._seen[DataEnd]:
            self._summary.add(("channel", channel.id))
        if self._channels.setdefault(channel.id, channel) != channel:
            self.fault(offset, f"channel {channel.id} is {channel.topic} here and another before")
        if channel.schema_id not in self._schemas:
            self.fault(offset, f"{channel.topic}: its schema {channel.schema_id} does not come before it")
            return
        if channel.message_encoding != "cdr":
            self.fault(offset, f"{channel.topic}: messages are encoded as '{channel.message_encoding}', expected cdr")
        if "offered_qos_profiles" not in channel.metadata:
            self.fault(offset, f"{channel.topic}: the channel has no offered_qos_profiles")
        name = self._schemas[channel.schema_id].name
        if name in MESSAGES and channel.metadata.get("topic_type_hash") != type_hash(name):
            self.fault(offset, f"{channel.topic}: topic_type_hash is not that of {name}")

    def _chunk(self, offset: int, chunk: Chunk) -> None:
        messages = []
        for record in breakup_chunk(chunk, validate_crc=True):
            self.record(offset, record)
            if isinstance(record, Message):
                messages.append(record)
        self._chunks[offset] = chunk, messages
        times = [m.log_time for m in messages]
        span = (min(times), max(times)) if times else (0, 0)
        if span != (chunk.message_start_time, chunk.message_end_time):
            self.fault(offset, "the chunk's times are not those of its messages")

    def _message(self, offset: int, message: Message) -> None:
        self._messages[message.channel_id] += 1
        self._times.append(message.log_time)
        channel = self._channels.get(message.channel_id)
        if channel is None:
            self.fault(offset, f"a message of channel {message.channel_id}, which does not come before it")
            return
        name = self._schemas[channel.schema_id].name
        if name in MESSAGES:
            try:
                decode(message.data, name)
            except MessageError as error:
                self.fault(offset, f"{channel.topic} at {message.log_time} ns: {error}")

    def _chunk_index(self, offset: int, index: ChunkIndex) -> None:
        self._indexed.add(index.chunk_start_offset)
        if index.chunk_start_offset not in self._chunks:
            self.fault(offset, f"a chunk index points to byte {index.chunk_start_offset}, where there is no chunk")
            return
        chunk, messages = self._chunks[index.chunk_start_offset]
        times = (index.message_start_time, index.message_end_time)
        if times != (chunk.message_start_time, chunk.message_end_time):
            self.fault(offset, "a chunk index has other times than its chunk")
        if (index.compressed_size, index.uncompressed_size) != (len(chunk.data), chunk.uncompressed_size):
            self.fault(offset, "a chunk index has other sizes than its chunk")
        if set(index.message_index_offsets) != {m.channel_id for m in messages}:
            self.fault(offset, "a chunk index has other channels than its chunk")

    def _take_statistics(self, offset: int, statistics: Statistics) -> None:
        self._statistics = statistics

    def _check_summary(self) -> None:
        for channel in self._channels:
            if ("channel", channel) not in self._summary:
                self.faults.append(f"channel {self._channels[channel].topic} is missing from the summary")
        for schema in self._schemas:
            if ("schema", schema) not in self._summary:
                self.faults.append(f"schema {self._schemas[schema].name} is missing from the summary")
        for offset in sorted(self._chunks.keys() - self._indexed):
            self.faults.append(f"the chunk at byte {offset} is missing from the index")
        if self._statistics is None:
            return
        expected = {
            "message_count": len(self._times),
            "schema_count": len(self._schemas),
            "channel_count": len(self._channels),
            "attachment_count": self._seen[Attachment],
            "metadata_count": self._seen[Metadata],
            "chunk_count": len(self._chunks),
            "message_start_time": min(self._times, default=0),
            "message_end_time": max(self._times, default=0),
            "channel_message_counts": dict(self._messages),
        }
        for name, value in expected.items():
            found = getattr(self._statistics, name)
            if found != value:
                self.faults.append(f"the statistics' {name} is {found}, expected {value}")
