"""Two logs differ where their messages do, and the difference is told by field."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from crowdcosim.cdr import encode
from crowdcosim.messages import Clock, PoseStamped, RobotState, Time, Twist, Vector3
from crowdcosim.messages import Path as Route
from orchestrator.log.diff import differences, field_difference
from orchestrator.log.reader import Log
from orchestrator.log.recorder import Record

TYPES = {"/clock": Clock.TYPE, "/a/twist": Twist.TYPE, "/b": "some_msgs/msg/Unknown"}


def log(speeds: list[float], **changes: Any) -> Log:
    records = []
    for k, speed in enumerate(speeds):
        time = k * 100_000_000
        records.append(Record("/clock", time, encode(Clock(clock=Time(nanosec=time)))))
        records.append(Record("/a/twist", time, encode(Twist(linear=Vector3(x=speed)))))
        records.append(Record("/b", time, b"1234"))
    made = Log(path=Path("x"), records=records, types=TYPES, attachments={"scenario.json": b'{"dt": 0.1}'})
    return dataclasses.replace(made, **changes)


def test_equal_logs_do_not_differ() -> None:
    assert differences(log([1.0, 2.0]), log([1.0, 2.0])) == []


def test_the_first_difference_is_told_with_tick_channel_field_and_values() -> None:
    (found,) = differences(log([1.0, 2.0, 3.0, 3.0]), log([1.0, 2.0, 2.5, 2.5]))
    assert (found.topic, found.tick, found.time) == ("/a/twist", 2, 200_000_000)
    assert found.what == "linear.x: 3.0 and 2.5"
    assert (found.differing, found.messages) == (2, 4)


def test_the_shorter_log_lacks_what_the_longer_has() -> None:
    found = differences(log([1.0, 2.0]), log([1.0]))
    assert [d.topic for d in found] == ["/clock", "/a/twist", "/b"]
    assert {d.what for d in found} == {"only in the first log"}
    assert {d.what for d in differences(log([1.0]), log([1.0, 2.0]))} == {"only in the second log"}


def test_messages_of_types_that_we_do_not_know_differ_by_byte() -> None:
    a, b = log([1.0]), log([1.0])
    b.records[2] = Record("/b", 0, b"1294")
    assert differences(a, b)[0].what == "byte 2"
    b.records[2] = Record("/b", 0, b"12345")
    assert differences(a, b)[0].what == "length: 4 and 5 bytes"


@given(st.floats(-1e9, 1e9), st.integers(0, 1))
def test_a_changed_number_in_an_array_is_found(value: float, index: int) -> None:
    position = [1.5, 2.5]
    position[index] = value
    a, b = RobotState(position=[1.5, 2.5]), RobotState(position=position)
    expected = None if position == [1.5, 2.5] else f"position[{index}]: {a.position[index]} and {b.position[index]}"
    assert field_difference(a, b) == expected


def test_lists_of_messages_differ_by_length_and_by_item() -> None:
    one, two = Route(poses=(PoseStamped(),)), Route(poses=(PoseStamped(), PoseStamped()))
    assert field_difference(one, two) == "poses: 1 and 2 items"
    late = PoseStamped(header=dataclasses.replace(PoseStamped().header, frame_id="odom"))
    assert field_difference(one, Route(poses=(late,))) == "poses[0].header.frame_id: '' and 'odom'"
