"""The test vectors of `protocol.md`: messages, and a dump that says what each byte is.

The dump is written by the rules of the page rather than by rosbags, so that the one proves the other.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from crowdcosim.bus import Label
from crowdcosim.cdr import store
from crowdcosim.message import Message
from crowdcosim.messages import (
    Contacts,
    Crowd,
    Done,
    Goal,
    Header,
    LaserScan,
    Metrics,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    RobotState,
    Tick,
    Time,
    Twist,
    TwistWithCovariance,
    Vector3,
)

HEADER = Header(stamp=Time(sec=1, nanosec=500_000_000), frame_id="map")
VECTORS: tuple[tuple[str, Message], ...] = (
    (
        "Begin episode 2",
        Tick(phase=Tick.RESET, episode=2, period=100_000_000, setup='{"alone": false, "reference": null}'),
    ),
    ("Step from tick 15", Tick(phase=Tick.STEP, episode=2, tick=15, period=100_000_000, time=1_500_000_000)),
    ("Done", Done(phase=Tick.RESET, tick=0, ok=True, elapsed=1_234_567)),
    ("Failed", Done(phase=Tick.STEP, tick=15, ok=False, error="no map", elapsed=89)),
    ("A command", Twist(linear=Vector3(x=0.75), angular=Vector3(z=-0.5))),
    (
        "Where a robot is",
        RobotState(
            header=HEADER,
            name="robot",
            position=np.array([6.25, 5.0]),
            heading=0.5,
            velocity=np.array([0.875, 0.5]),
            angular_velocity=-0.25,
            radius=0.177,
        ),
    ),
    (
        "Two people",
        Crowd(
            header=HEADER,
            id=[1, 7],
            group=[0, 1],
            position=[[12.5, 3.0], [0.25, 9.75]],
            velocity=[[-1.25, 0.0], [-1.0, 0.125]],
            heading=[3.140625, -3.0],
            radius=[0.3, 0.25],
            stature=[1.75, 1.625],
            mass=[80.0, 62.5],
            gait_phase=[0.0, 0.75],
            gait_speed=[1.25, 1.0],
        ),
    ),
    ("Nobody", Crowd(header=HEADER)),
    (
        "A line to cross",
        Goal(header=Header(frame_id="map"), robot="robot", position=[45.0, 5.0], direction=[1.0, 0.0], tolerance=0.3),
    ),
    (
        "One contact",
        Contacts(
            header=HEADER,
            robot="robot",
            kind=[Contacts.PERSON],
            agent=[7],
            body_part=[Contacts.LOWER_LEGS],
            robot_part=[Contacts.FRONT],
            striker=[Contacts.BY_BOTH],
            position=[[6.5, 5.0]],
            normal=[[1.0, 0.0]],
            relative_velocity=[[-2.0, 0.25]],
            approach_speed=[2.0],
            robot_closing_speed=[1.0],
            reflected_mass=[13.0],
            energy=[15.75],
            duration=[0.0],
        ),
    ),
    (
        "What the wheels tell",
        Odometry(
            header=Header(stamp=Time(sec=1, nanosec=500_000_000), frame_id="odom"),
            child_frame_id="robot/base_link",
            pose=PoseWithCovariance(
                pose=Pose(position=Point(x=6.25, y=5.0), orientation=Quaternion(z=0.25, w=0.96875))
            ),
            twist=TwistWithCovariance(twist=Twist(linear=Vector3(x=1.0), angular=Vector3(z=-0.25))),
        ),
    ),
    (
        "Three beams, the last of which hits nothing",
        LaserScan(
            header=Header(stamp=Time(sec=1, nanosec=500_000_000), frame_id="robot/lidar"),
            angle_min=-0.5,
            angle_max=0.5,
            angle_increment=0.5,
            range_min=0.125,
            range_max=10.0,
            ranges=[2.5, 0.75, float("inf")],
        ),
    ),
    (
        "Two metrics, one of them without a value",
        Metrics(
            robot=("robot", "robot"),
            name=("T", "T/Tcr"),
            unit=("s", "1"),
            value=[51.5, 0.0],
            valid=[True, False],
            reason=("", "not alone"),
        ),
    ),
)
"""What every test vector is about, and its message; numbers that binary floats hold exactly."""

FORMATS = {
    "float64": "<f8",
    "float32": "<f4",
    "uint64": "<u8",
    "int64": "<i8",
    "uint32": "<u4",
    "int32": "<i4",
    "uint8": "u1",
    "bool": "?",
}
"""type of an interface file -> little-endian number"""


class Dump:
    """CDR written field by field, with what each byte is."""

    def __init__(self) -> None:
        self.lines = [_line("--", b"\0\1\0\0", "CDR, little-endian")]
        self.offset = 0

    def message(self, value: Any, path: str = "") -> None:
        _, fields = store().fielddefs[value.TYPE]
        for name, (node, detail) in fields:
            self._field(node, detail, getattr(value, name), f"{path}.{name}" if path else name)

    def _field(self, node: Nodetype, detail: Any, value: Any, path: str) -> None:
        if node is Nodetype.NAME:
            self.message(value, path)
        elif node is Nodetype.BASE:
            self._base(detail[0], value, path)
        else:
            (item_node, item), _ = detail
            values = np.ravel(value).tolist() if isinstance(value, np.ndarray) else value
            if node is Nodetype.SEQUENCE:
                self._write(4, len(values).to_bytes(4, "little"), f"number of {path}")
            elif len(values) > 9 and not any(values):
                self._zeros(np.dtype(FORMATS[item[0]]).itemsize, len(values), path)
                return
            for index, element in enumerate(values):
                self._field(item_node, item, element, f"{path}[{index}]")

    def _base(self, kind: str, value: Any, path: str) -> None:
        if kind == "string":
            data = value.encode() + b"\0"
            self._write(4, len(data).to_bytes(4, "little"), f"length of {path}, with its NUL")
            self._write(1, data, f"{path} = {json.dumps(value)}")
        else:
            data = np.array(value, FORMATS[kind]).tobytes()
            self._write(len(data), data, f"{path} = {json.dumps(value)}")

    def _zeros(self, size: int, count: int, path: str) -> None:
        self._align(size)
        self.lines.append(f"{self.offset:>4}  {f'00 x {size * count}':<23}  {path}[0..{count - 1}] = 0.0")
        self.offset += size * count

    def _write(self, size: int, data: bytes, note: str) -> None:
        self._align(size)
        for begin in range(0, len(data), 8):
            self.lines.append(_line(self.offset + begin, data[begin : begin + 8], note if begin == 0 else ""))
        self.offset += len(data)

    def _align(self, size: int) -> None:
        if padding := -self.offset % size:
            self.lines.append(_line(self.offset, bytes(padding), "padding"))
            self.offset += padding


def _line(offset: int | str, data: bytes, note: str) -> str:
    return f"{offset:>4}  {data.hex(' '):<23}  {note}".rstrip()


def vectors() -> str:
    """Messages, byte for byte."""
    sections = []
    for title, message in VECTORS:
        dump = Dump()
        dump.message(message)
        sections.append("\n".join([f"{title}, `{message.TYPE}`:", "", "```text", *dump.lines, "```"]))
    return "\n\n".join(sections)


def attachment() -> str:
    """An attachment, byte for byte."""
    label = Label(episode=2, tick=15, time=1_500_000_000, elapsed=345_678)
    data = label.encode()
    lines = [
        _line(8 * i, data[8 * i : 8 * i + 8], f"{name} = {value}")
        for i, (name, value) in enumerate(label._asdict().items())
    ]
    return "\n".join(["```text", *lines, "```"])
