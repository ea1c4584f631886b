"""What is handed to the recorder is in the file, in that order, and the hash knows every byte of it."""

import time
from pathlib import Path

import pytest
from mcap.reader import make_reader

from crowdcosim.cdr import encode
from crowdcosim.messages import Clock, Time, Twist, Vector3
from orchestrator.errors import InputError, RunError
from orchestrator.log.reader import read_log
from orchestrator.log.recorder import Channel, Record, Recorder, topic_of

CHANNELS = (Channel("/clock", Clock.TYPE, "", "clock"), Channel("/a/twist", Twist.TYPE, "a", "twist"))


def records(tick: int) -> list[Record]:
    return [
        Record("/clock", tick * 100, encode(Clock(clock=Time(nanosec=tick * 100)))),
        Record("/a/twist", tick * 100, encode(Twist(linear=Vector3(x=float(tick))))),
    ]


def write(path: Path, ticks: int) -> str:
    recorder = Recorder(path, CHANNELS, attachments={"scenario.json": b"{}"}, metadata={"run": {"seed": "1"}})
    for tick in range(ticks):
        recorder.add(records(tick))
    return recorder.close({"outcome": {"reason": "goal"}})


def test_a_log_gives_back_what_was_written_in_its_order(tmp_path: Path) -> None:
    data_hash = write(tmp_path / "x.mcap", 50)
    log = read_log(tmp_path / "x.mcap")
    assert log.records == [record for tick in range(50) for record in records(tick)]
    assert log.complete
    assert log.data_hash() == data_hash == log.metadata["outcome"]["data_hash"]
    assert log.attachments == {"scenario.json": b"{}"}
    assert [m.linear.x for _, m in log.outputs("a", "twist")] == [float(t) for t in range(50)]


def test_a_log_is_well_formed_for_mcaps_own_reader(tmp_path: Path) -> None:
    write(tmp_path / "x.mcap", 3000)
    with (tmp_path / "x.mcap").open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 6000
        assert len(summary.chunk_indexes) > 1
        for channel in summary.channels.values():
            assert channel.message_encoding == "cdr"
            assert summary.schemas[channel.schema_id].encoding == "ros2msg"
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
            assert "reliability" in channel.metadata["offered_qos_profiles"]


def test_the_hash_knows_order_time_topic_and_bytes(tmp_path: Path) -> None:
    hashes = {write(tmp_path / f"{n}.mcap", n) for n in (1, 2, 3)}
    recorder = Recorder(tmp_path / "y.mcap", CHANNELS, attachments={}, metadata={})
    recorder.add(list(reversed(records(0))))
    hashes.add(recorder.close({}))
    assert len(hashes) == 4


def test_the_hash_leaves_out_what_is_no_data(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "y.mcap", CHANNELS, attachments={"other": b"x"}, metadata={"run": {"host": "b"}})
    for tick in range(5):
        recorder.add(records(tick))
    assert recorder.close({"outcome": {"wall": "3"}}) == write(tmp_path / "x.mcap", 5)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_a_log_cut_anywhere_gives_back_complete_chunks(tmp_path: Path, share: float) -> None:
    write(tmp_path / "x.mcap", 6000)
    whole = (tmp_path / "x.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: int(len(whole) * share)])
    try:
        log = read_log(tmp_path / "cut.mcap")
    except InputError:
        assert share == 0.1  # not even the first chunk
        return
    assert not log.complete
    assert log.records == [record for tick in range(6000) for record in records(tick)][: len(log.records)]


def test_what_cannot_be_written_is_told_at_the_next_tick(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "x.mcap", CHANNELS, attachments={}, metadata={})
    recorder.add([Record("/unknown", 0, b"")])
    until = time.monotonic() + 10.0
    with pytest.raises(RunError, match="cannot write"):
        while time.monotonic() < until:
            recorder.add(records(0))


def test_a_topic_names_component_and_port_once() -> None:
    assert topic_of("crowd", "crowd") == "/crowd"
    assert topic_of("robot/odometry", "odometry") == "/robot/odometry"
    assert topic_of("robot/lidar", "scan") == "/robot/lidar/scan"
