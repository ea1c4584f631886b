"""Logs that other tools stumble over are found out, and what can be read of a cut log is saved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from crowdcosim.cdr import encode, schema_text, type_hash
from crowdcosim.messages import Clock, Time
from orchestrator.errors import InputError
from orchestrator.log.check import faults
from orchestrator.log.reader import read_log
from orchestrator.log.recorder import Channel, Record, Recorder
from orchestrator.log.recover import recover

TOPIC = Channel("/clock", Clock.TYPE, "", "clock")
CLOCKS = [Record("/clock", k * 100, encode(Clock(clock=Time(nanosec=k * 100)))) for k in range(40_000)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A log of several chunks."""
    path = tmp_path_factory.mktemp("logs") / "whole.mcap"
    recorder = Recorder(path, (TOPIC,), attachments={"scenario.json": b"{}"}, metadata={"run": {"seed": "1"}})
    for i in range(0, len(CLOCKS), 1000):
        recorder.add(CLOCKS[i : i + 1000])
    recorder.close({"outcome": {"reason": "goal", "ticks": "1"}})
    return path.read_bytes()


def test_what_the_recorder_writes_is_well_formed(whole: bytes, tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(whole)
    assert faults(tmp_path / "x.mcap") == []


def other(path: Path, change: Callable[[Writer], None], *, profile: str = "ros2", library: str = "test") -> list[str]:
    """The faults of a log that somebody else wrote."""
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(profile=profile, library=library)
        change(writer)
        writer.finish()
    return faults(path)


def channel(writer: Writer, *, encoding: str = "cdr", text: str | None = None, **metadata: str) -> int:
    schema = writer.register_schema(Clock.TYPE, "ros2msg", (schema_text(Clock.TYPE) if text is None else text).encode())
    good = {"offered_qos_profiles": "", "topic_type_hash": type_hash(Clock.TYPE)}
    return writer.register_channel("/clock", encoding, schema, good | metadata)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda w: channel(w, encoding="json"), "'json', expected cdr"),
        (lambda w: channel(w, text="int32 x"), "not the definition"),
        (lambda w: channel(w, topic_type_hash="RIHS01_0"), "topic_type_hash is not that of"),
        (lambda w: w.register_channel("/x", "cdr", 0, {}), "schema 0 does not come before it"),
        (lambda w: w.add_message(channel(w), 0, b"\0\1\0\0", 0), "/clock at 0 ns: 4 bytes are not a"),
        (lambda w: w.add_message(channel(w), 0, CLOCKS[0].payload, 0), None),
    ],
)
def test_a_fault_is_named(change: Callable[[Writer], None], words: str | None, tmp_path: Path) -> None:
    found = other(tmp_path / "x.mcap", change)
    assert (words is None and found == []) or (words is not None and any(words in fault for fault in found)), found


def test_profile_and_library_must_be_there(tmp_path: Path) -> None:
    assert any("profile is ''" in fault for fault in other(tmp_path / "a", lambda w: None, profile=""))


@settings(max_examples=10, deadline=None)
@given(share=st.floats(0.0, 1.0))
def test_of_a_log_that_is_cut_anywhere_every_complete_chunk_is_saved(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, share: float
) -> None:
    folder = tmp_path_factory.mktemp("cut")
    cut, saved = folder / "cut.mcap", folder / "saved.mcap"
    length = int(share * (len(whole) - 1))
    cut.write_bytes(whole[:length])
    assert faults(cut)
    try:
        result = recover(cut, saved)
    except InputError as error:
        assert "nothing can be recovered" in str(error)
        assert not saved.exists()
        assert not list(folder.glob("*.part"))
        return
    assert faults(saved) == []
    log = read_log(saved)
    assert log.records == CLOCKS[: result.messages]
    assert log.data_hash() == log.metadata["outcome"]["data_hash"]
    # A chunk holds 256 KiB, 4,369 of these messages of 60 bytes; three more are in the writer's hands at most.
    assert result.messages >= min(len(CLOCKS), int(share * len(CLOCKS)) - 3 * 4_369)


@settings(max_examples=20, deadline=None)
@given(place=st.floats(0.0, 1.0, exclude_max=True), flip=st.integers(1, 255))
def test_a_log_with_a_broken_byte_is_read_without_a_crash(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, place: float, flip: int
) -> None:
    broken = bytearray(whole)
    broken[int(place * len(broken))] ^= flip
    path = tmp_path_factory.mktemp("broken") / "x.mcap"
    path.write_bytes(broken)
    assert isinstance(faults(path), list)


def test_nothing_is_written_over(whole: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(whole)
    (tmp_path / "b.mcap").write_bytes(b"mine")
    with pytest.raises(InputError, match="already exists"):
        recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert (tmp_path / "b.mcap").read_bytes() == b"mine"
    with pytest.raises(InputError, match="No such file"):
        recover(tmp_path / "none.mcap", tmp_path / "c.mcap")


def test_a_log_that_is_whole_is_copied_as_it_is(whole: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(whole)
    result = recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    a, b = read_log(tmp_path / "a.mcap"), read_log(tmp_path / "b.mcap")
    assert result.complete
    assert (a.records, a.metadata, a.attachments, a.places) == (b.records, b.metadata, b.attachments, b.places)
