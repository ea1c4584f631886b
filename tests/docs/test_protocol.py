"""What `docs/protocol.md` says is what the code does, byte for byte."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh
from pydantic import TypeAdapter

from crowdcosim.bus import PROTOCOL, Label
from crowdcosim.cdr import decode, encode, type_hash
from crowdcosim.message import Message
from crowdcosim.messages import MESSAGES, Goal, Odometry, Point, Pose, PoseWithCovariance, Quaternion
from crowdcosim.setup import Setup

ROOT = Path(__file__).parent.parent.parent
PAGE = (ROOT / "docs" / "protocol.md").read_text()
ROW = re.compile(r" *(?P<offset>--|\d+)  (?P<bytes>00 x \d+|[0-9a-f]{2}(?: [0-9a-f]{2})*)(?: +(?P<note>.*))?")


def part(name: str) -> str:
    """A generated part of the page."""
    (text,) = re.findall(rf"<!-- generated: {name} -->\n(.*?)\n<!-- end -->", PAGE, re.DOTALL)
    return text


def read(dump: str) -> tuple[bytes, dict[str, Any]]:
    """The bytes of a dump, and the values by path; a path that begins with # is the number of items."""
    data, values, header = b"", {}, 0
    for line in dump.splitlines():
        row = ROW.fullmatch(line)
        assert row, line
        if row["offset"] == "--":
            header = 4
        else:
            assert int(row["offset"]) == len(data) - header
        data += bytes(int(row["bytes"][5:])) if " x " in row["bytes"] else bytes.fromhex(row["bytes"])
        if value := re.fullmatch(r"(\S+) = (.*)", row["note"] or ""):
            values[value[1]] = json.loads(value[2])
        elif number := re.fullmatch(r"number of (\S+)", row["note"] or ""):
            values[f"#{number[1]}"] = int.from_bytes(bytes.fromhex(row["bytes"]), "little")
    return data, values


def message_of(cls: type[Message], values: dict[str, Any], path: str = "") -> Message:
    """The message of a class with the values of a dump."""
    made = {}
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        at = f"{path}.{field.name}".removeprefix(".")
        default = getattr(cls(), field.name)
        if isinstance(default, Message):
            made[field.name] = message_of(type(default), values, at)
        elif f"{at}[0..{np.size(default) - 1}]" in values:
            made[field.name] = default
        elif isinstance(default, np.ndarray | tuple):
            made[field.name] = [values[f"{at}[{i}]"] for i in range(values.get(f"#{at}", np.size(default)))]
        else:
            made[field.name] = values[at]
    return cls(**made)


VECTORS = re.findall(r"^(\w[^\n]*), `(\S+)`:\n\n```text\n(.*?)\n```", part("vectors"), re.DOTALL | re.MULTILINE)


@pytest.fixture
def scripts(monkeypatch) -> None:
    for folder in ("docs", "examples"):
        monkeypatch.syspath_prepend(ROOT / folder)


# --- the page --------------------------------------------------------------------------------------------------------


def test_regenerating_the_page_changes_nothing(scripts) -> None:
    import generate_protocol

    assert generate_protocol.regenerated(PAGE) == PAGE, "run: python docs/generate_protocol.py"


def test_the_version_is_the_one_that_is_spoken() -> None:
    assert PAGE.startswith(f"# The wire protocol, version {PROTOCOL}\n")
    assert json.loads(part("hello answer").strip("`json\n"))["protocol"] == PROTOCOL


def test_zenoh_takes_the_settings_of_the_session() -> None:
    settings = PAGE.partition("## The session")[2].partition("```json\n")[2].partition("```")[0]
    config = zenoh.Config.from_json5(settings)
    assert json.loads(config.get_json("mode")) == "client"
    assert not json.loads(config.get_json("scouting/multicast/enabled"))


# --- bytes -----------------------------------------------------------------------------------------------------------


def test_there_is_a_vector_of_every_message_that_the_protocol_needs() -> None:
    types = {typename.rpartition("/")[2] for _, typename, _ in VECTORS}
    assert types >= {
        "Tick",
        "Done",
        "Twist",
        "RobotState",
        "Crowd",
        "Goal",
        "Contacts",
        "Odometry",
        "LaserScan",
        "Metrics",
    }


@pytest.mark.parametrize(("typename", "dump"), [v[1:] for v in VECTORS], ids=[v[0] for v in VECTORS])
def test_every_vector_is_what_our_codec_writes_and_reads(typename: str, dump: str) -> None:
    data, values = read(dump)
    message = message_of(MESSAGES[typename], values)
    assert encode(message) == data
    assert decode(data, typename) == message


def test_the_attachment_is_what_our_codec_writes_and_reads() -> None:
    data, values = read(part("attachment").removeprefix("```text\n").removesuffix("\n```"))
    assert Label(**values).encode() == data
    assert Label.decode(data) == Label(**values)


def test_the_table_of_types_has_every_type_and_its_hash() -> None:
    table = dict(re.findall(r"^\| \[?([\w/]+)\S* \| `(\w+)` \|$", part("types"), re.MULTILINE))
    assert table == {name: type_hash(name) for name in MESSAGES}


def test_the_hashes_in_components_without_crowdcosim_are_of_this_version() -> None:
    for path in ("examples/plain_controller.py", "tests/end_to_end/raw_component.py"):
        found = re.findall(r"RIHS01_[0-9a-f]{64}", (ROOT / path).read_text())
        assert found
        assert set(found) <= set(map(type_hash, MESSAGES))


# --- JSON ------------------------------------------------------------------------------------------------------------


def test_seeds_follow_from_the_rule_on_the_page() -> None:
    rows = re.findall(r"^\| (\d+) \| `(\S+)` \| (\d+) \|$", part("seeds"), re.MULTILINE)
    assert rows
    for seed, component, expected in rows:
        digest = hashlib.sha256(f"{seed}/{component}".encode()).digest()
        assert int.from_bytes(digest[:8], "little") == int(expected)


def test_every_key_of_the_setup_is_explained() -> None:
    setup = json.loads(part("configure request").strip("`json\n"))["setup"]
    assert TypeAdapter(Setup).dump_python(TypeAdapter(Setup).validate_python(setup), mode="json") == setup
    explained = set(re.findall(r"^\| `(\w+)` \|", part("setup"), re.MULTILINE))
    for robot in setup["robots"]:
        robot["model"]["mounts"] = list(robot["model"]["mounts"].values())  # whose keys are names
    assert keys(setup) <= explained


def keys(value: Any) -> set[str]:
    if isinstance(value, dict):
        return set(value).union(*map(keys, value.values()))
    return set().union(*map(keys, value)) if isinstance(value, list) else set()


# --- the example -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("goal", "heading", "forward", "turn"),
    [
        (Goal(position=[45, 5], direction=[1, 0]), 0.0, 0.8, 0.0),
        (Goal(position=[45, 5], direction=[1, 0]), 0.5, 0.8 * np.cos(0.5), -1.0),
        (Goal(position=[2, 7], tolerance=0.5), 0.0, 0.0, 2.0),
        (Goal(position=[2, 5.4], tolerance=0.5), 0.0, 0.0, 0.0),
    ],
    ids=["line ahead", "line aside", "disc to the left", "arrived"],
)
def test_the_plain_controller_turns_to_the_goal_and_drives(scripts, goal, heading, forward, turn) -> None:
    import plain_controller

    pose = Pose(position=Point(x=2.0, y=5.0), orientation=Quaternion(z=np.sin(heading / 2), w=np.cos(heading / 2)))
    odometry = Odometry(child_frame_id="robot/base_link", pose=PoseWithCovariance(pose=pose))
    twist = decode(plain_controller.command(encode(odometry), encode(goal), 0.8, 2.0), "geometry_msgs/msg/Twist")
    # cos(pi / 2) is not quite zero
    assert (twist.linear.x, twist.angular.z) == pytest.approx((forward, turn), abs=1e-15)


def test_the_plain_controller_takes_less_than_150_lines() -> None:
    assert len((ROOT / "examples" / "plain_controller.py").read_text().splitlines()) < 150
    assert len((ROOT / "examples" / "my_controller.py").read_text().splitlines()) < 30


def test_the_plain_controller_imports_nothing_but_zenoh_and_the_standard_library() -> None:
    source = (ROOT / "examples" / "plain_controller.py").read_text()
    imported = set(re.findall(r"^\s*(?:import|from) (\w+)", source, re.MULTILINE))
    assert imported - sys.stdlib_module_names == {"zenoh"}
