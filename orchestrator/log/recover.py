"""Makes a complete log of one that was cut off."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from crowdcosim import __version__
from orchestrator.errors import InputError
from orchestrator.log.check import BROKEN
from orchestrator.log.recorder import CHUNK_SIZE, DataHash


@dataclass(frozen=True, kw_only=True)
class Recovered:
    """What could be saved."""

    messages: int
    until: int
    """simulated time of the newest message [ns]"""
    complete: bool
    """the log was not cut off at all"""


def recover(source: Path, target: Path) -> Recovered:
    """Write everything of `source` that is in complete chunks to `target`, with an index.

    Raises:
        InputError: if `source` cannot be read or is no log, or `target` exists or cannot be written.
    """
    if target.exists():
        raise InputError(f"{target} already exists; choose another --out, or remove it first")
    part = target.with_name(f"{target.name}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with source.open("rb") as stream, part.open("wb") as out:
            rescue = _Rescue(Writer(out, chunk_size=CHUNK_SIZE, compression=CompressionType.LZ4))
            complete = rescue.take_all(StreamReader(stream, validate_crcs=True))
            rescue.finish(complete)
        if not rescue.channels:
            part.unlink()
            raise InputError(f"{source} holds no complete chunk: nothing can be recovered")
        os.replace(part, target)
    except OSError as error:
        raise InputError(f"cannot recover {source} to {target}: {error.strerror}") from None
    return Recovered(messages=rescue.messages, until=rescue.until, complete=complete)


class _Rescue:
    """Copies records, under numbers of the new log."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        writer.start(profile="ros2", library=f"crowdcosim {__version__}")
        self._schemas: dict[int, int] = {}
        self._topics: dict[int, str] = {}
        self._hash = DataHash()
        self._outcome: dict[str, str] = {}
        self.channels: dict[int, int] = {}
        self.messages = 0
        self.until = 0

    def take_all(self, reader: StreamReader) -> bool:
        """Copy up to where the log ends or breaks; True if it is complete."""
        try:
            for record in reader.records:
                self._take(record)
        except BROKEN:
            return False
        return True

    def finish(self, complete: bool) -> None:
        """Write how the run ended, as far as is known, and the index."""
        outcome = self._outcome or {"reason": "cut off"}
        if not complete or not self._outcome:
            outcome = outcome | {"recovered": f"{self.messages} messages", "data_hash": self._hash.text()}
        self._writer.add_metadata("outcome", outcome)
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _take(self, record: object) -> None:
        match record:
            case Schema() if record.id not in self._schemas:
                self._schemas[record.id] = self._writer.register_schema(record.name, record.encoding, record.data)
            case Channel() if record.id not in self.channels:
                self._topics[record.id] = record.topic
                self.channels[record.id] = self._writer.register_channel(
                    record.topic, record.message_encoding, self._schemas[record.schema_id], record.metadata
                )
            case Message():
                self._take_message(record)
            case Attachment():
                self._writer.add_attachment(
                    record.create_time, record.log_time, record.name, record.media_type, record.data
                )
            case Metadata() if record.name == "outcome":
                self._outcome = dict(record.metadata)
            case Metadata():
                self._writer.add_metadata(record.name, record.metadata)

    def _take_message(self, message: Message) -> None:
        self._writer.add_message(
            self.channels[message.channel_id],
            message.log_time,
            message.data,
            message.publish_time,
            message.sequence,
        )
        self._hash.add(self._topics[message.channel_id], message.log_time, message.data)
        self.messages += 1
        self.until = max(self.until, message.log_time)
