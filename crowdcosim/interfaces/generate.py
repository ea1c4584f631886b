"""Write `crowdcosim/messages.py` from the `.msg` files: `python crowdcosim/interfaces/generate.py`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

PACKAGE = "crowdcosim_msgs"
MSG_DIR = Path(__file__).parent / "msg"
TARGET = Path(__file__).parent.parent / "messages.py"

STANDARD = (
    "builtin_interfaces/msg/Time",
    "std_msgs/msg/Header",
    "geometry_msgs/msg/Vector3",
    "geometry_msgs/msg/Point",
    "geometry_msgs/msg/Quaternion",
    "geometry_msgs/msg/Pose",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovariance",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped",
    "geometry_msgs/msg/TwistWithCovariance",
    "geometry_msgs/msg/Transform",
    "geometry_msgs/msg/TransformStamped",
    "nav_msgs/msg/Odometry",
    "nav_msgs/msg/Path",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/RegionOfInterest",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/PointField",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/Range",
    "tf2_msgs/msg/TFMessage",
)
"""Standard ROS 2 (Jazzy) types, in order of dependency."""

MAY_BE_INFINITE = {"LaserScan": ("ranges",), "Range": ("range",)}
"""Fields in which infinity has a meaning (REP 117: no return within range). NaN never has one."""

HEADER = '''"""The messages that components exchange: typed, frozen, checked when made.

Generated from `crowdcosim/interfaces/msg/*.msg` by `python crowdcosim/interfaces/generate.py`; do not edit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from crowdcosim.message import ArrayField, CoercedMessage, Message, SequenceField
'''

PYTHON_SCALARS = {"float32": "float", "float64": "float", "bool": "bool", "string": "str"}
DEFAULTS = {"float": "0.0", "int": "0", "bool": "False", "str": '""'}


class Note(NamedTuple):
    """What a field's comment says: its shape, if any, and its words."""

    shape: tuple[str, ...]
    words: str


def comments(text: str) -> tuple[str, dict[str, Note]]:
    """The leading comment of a `.msg` text and the note on each field."""
    lines = text.splitlines()
    summary = " ".join(line.lstrip("# ").rstrip() for line in lines if line.startswith("#"))
    notes = {}
    for line in lines:
        if match := re.match(r"[\w/\[\]]+\s+(\w+)\s*(?:#\s*(.*))?$", line):
            words = match[2] or ""
            shape = re.match(r"\(([^)]*)\)", words)
            symbols = tuple(s.strip() for s in shape[1].split(",") if s.strip()) if shape else ()
            notes[match[1]] = Note(symbols, words)
    return summary, notes


def python_class(typename: str, text: str | None) -> str:
    """The source of one message class."""
    name = typename.rsplit("/", 1)[1]
    summary, notes = comments(text) if text else (f"The standard ROS 2 message `{typename}`.", {})
    constants, fields = STORE.fielddefs[typename]
    detail: Any
    body = [f'    """{summary}"""', "", f'    TYPE: ClassVar[str] = "{typename}"']
    body += [f"    {c}: ClassVar[int] = {value}" for c, _, value in constants]
    arrays, sequences, narrow, declared = [], [], [], []
    may_be_infinite = MAY_BE_INFINITE.get(name, ())
    for field_name, (node, detail) in fields:
        note = notes.get(field_name, Note((), ""))
        annotation, default = field_type(node, detail)
        if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            (item_node, item), count = detail
            if item_node is Nodetype.BASE and item[0] != "string":
                shape = note.shape or ((str(count),) if node is Nodetype.ARRAY else ("_",))
                arrays.append(array_field(field_name, item[0], shape, field_name in may_be_infinite))
            else:
                sequences.append(f'SequenceField("{field_name}", "{note.shape[0] if note.shape else "_"}")')
        elif node is Nodetype.BASE and detail[0] == "float32":
            narrow.append(f'"{field_name}"')
        declared.append(f"    {field_name}: {annotation} = {default}")
        if note.words:
            declared.append(f'    """{note.words}"""')
    body += [f"    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = {tuple_source(arrays)}"] if arrays else []
    body += [f"    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = {tuple_source(sequences)}"] if sequences else []
    body += [f"    _NARROW: ClassVar[tuple[str, ...]] = {tuple_source(narrow)}"] if narrow else []
    infinite = [f'"{f}"' for f, (node, _) in fields if node is Nodetype.BASE and f in may_be_infinite]
    body += [f"    _MAY_BE_INFINITE: ClassVar[tuple[str, ...]] = {tuple_source(infinite)}"] if infinite else []
    decorator = "@dataclass(frozen=True, kw_only=True, eq=False, slots=True)"
    base = "CoercedMessage" if arrays or sequences or narrow else "Message"
    return "\n".join([decorator, f"class {name}({base}):", *body, "", *declared])


def tuple_source(items: list[str]) -> str:
    return "(\n" + "".join(f"        {item},\n" for item in items) + "    )"


def array_field(name: str, dtype: str, shape: tuple[str, ...], infinite: bool) -> str:
    sizes = ", ".join(s if s.isdigit() else f'"{s}"' for s in shape) + ("," if len(shape) == 1 else "")
    kind = "bool_" if dtype == "bool" else dtype
    flag = ", may_be_infinite=True" if infinite else ""
    return f'ArrayField("{name}", np.dtype(np.{kind}), ({sizes}){flag})'


def field_type(node: Nodetype, detail: Any) -> tuple[str, str]:
    """The Python annotation and default of one field."""
    if node is Nodetype.BASE:
        python = PYTHON_SCALARS.get(detail[0], "int")
        return python, DEFAULTS[python]
    if node is Nodetype.NAME:
        name = str(detail).rsplit("/", 1)[1]
        return name, f"field(default_factory={name})"
    (item_node, item), count = detail
    if item_node is Nodetype.NAME:
        return f"tuple[{item.rsplit('/', 1)[1]}, ...]", "()"
    if item[0] == "string":
        return "tuple[str, ...]", "()"
    kind = "bool_" if item[0] == "bool" else item[0]
    size = count if node is Nodetype.ARRAY else 0
    return f"NDArray[np.{kind}]", f"field(default_factory=lambda: np.zeros({size}, np.{kind}))"


def own_messages() -> dict[str, str]:
    """Type name -> `.msg` text of every message of ours, by name."""
    return {f"{PACKAGE}/msg/{path.stem}": path.read_text() for path in sorted(MSG_DIR.glob("*.msg"))}


STORE = get_typestore(Stores.ROS2_JAZZY)
for _typename, _text in own_messages().items():
    STORE.register(get_types_from_msg(_text, _typename))


def generate() -> str:
    """The source text of `crowdcosim/messages.py`."""
    own = own_messages()
    classes = [python_class(t, None) for t in STANDARD] + [python_class(t, text) for t, text in own.items()]
    names = [t.rsplit("/", 1)[1] for t in (*STANDARD, *own)]
    table = "MESSAGES: dict[str, type[Message]] = {\n"
    table += "".join(f"    {name}.TYPE: {name},\n" for name in names) + "}\n"
    table += '"""Every type that may cross a port, by its ROS 2 name."""\n'
    return HEADER + "\n\n" + "\n\n\n".join(classes) + "\n\n\n" + table


if __name__ == "__main__":
    TARGET.write_text(generate())
