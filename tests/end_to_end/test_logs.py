"""What one does with a log afterwards: check, save, compare, run again, export, publish."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import yaml
import zenoh
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from crowdcosim.cdr import decode
from crowdcosim.crowdbot.helpers import get_clock, get_crowd, get_odom
from crowdcosim.crowdbot.recorder import load_file_as_list_of_dico
from crowdcosim.messages import RobotState
from orchestrator.log.reader import read_log

SCENARIO = f"""
extends: {Path(__file__).parent / "small.yaml"}
robots: {{robot: {{sensors: {{lidar: {{use: lidar, config: {{beams: 90}}}}}}, controller: {{use: mpc}}}}}}
"""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten seconds of the small corridor, with a LiDAR and an MPC that says its path."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "small.yaml").write_text(SCENARIO)
    command = [sys.executable, "-m", "crowdcosim", "run", "small.yaml", "--host", "inline", "--out", "out", "--quiet"]
    subprocess.run(command, cwd=folder, check=True, stdin=subprocess.DEVNULL)
    return folder / "out"


def test_a_log_is_well_formed_and_a_cut_one_can_be_saved(crowdcosim, log: Path) -> None:
    assert crowdcosim("doctor", str(log)).code == 0
    data = (log / "episode.mcap").read_bytes()
    cut = crowdcosim.folder / "cut.mcap"
    cut.write_bytes(data[: len(data) * 2 // 3])
    bad = crowdcosim("doctor", str(cut))
    assert bad.code == 1
    assert "crowdcosim recover" in bad.stdout
    saved = crowdcosim("recover", str(cut), "--json").json
    assert saved["messages"] > 0
    assert crowdcosim("doctor", saved["log"], "--json").json["well_formed"]
    apart = crowdcosim("diff", str(log), saved["log"], "--json")
    assert apart.code == 1
    assert {d["what"] for d in apart.json["differences"]} == {"only in the first log"}
    assert crowdcosim("diff", str(log), str(log)).code == 0


def test_a_log_shows_everything_without_set_up(log: Path) -> None:
    with (log / "episode.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    shown = {summary.schemas[c.schema_id].name for c in summary.channels.values()}
    for name in ("MarkerArray", "TFMessage", "LaserScan", "Path", "Clock"):
        assert any(name in type_ for type_ in shown), name
    frames = {child for _, tf in read_log(log / "episode.mcap").outputs("", "tf_static") for child in _children(tf)}
    assert {"odom", "robot/lidar"} <= frames


def _children(message) -> set[str]:
    return {t.child_frame_id for t in message.transforms}


def test_a_component_can_be_run_again_alone(crowdcosim, log: Path) -> None:
    for component in ("robot/controller", "crowd"):
        outcome = crowdcosim("rerun", str(log), component)
        assert outcome.code == 0, (component, outcome.stdout, outcome.stderr)
    other = crowdcosim(
        "rerun", str(log), "robot/controller", "--use", "baseline", "--config", '{"speed": 0.5}', "--json"
    )
    assert other.code == 1
    assert other.json["ports"][0]["differing"] > 0
    for arguments, words in (
        (("robot/controler",), "did you mean 'robot/controller'?"),
        (("evaluator",), "crowdcosim evaluate"),
        (("robot/controller", "--use", "dwaa"), "did you mean 'dwa'?"),
        (("robot/controller", "--config", "[1]"), "expected a JSON object"),
    ):
        bad = crowdcosim("rerun", str(log), *arguments)
        assert bad.code == 2
        assert words in bad.stderr


def test_a_log_becomes_a_rosbag2_folder_and_tables(crowdcosim, log: Path) -> None:
    records = read_log(log / "episode.mcap").records
    bag = crowdcosim("export", str(log), "rosbag2", "--out", "bag", "--json")
    assert bag.code == 0, bag.stdout
    folder = crowdcosim.folder / "bag"
    assert yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]["storage_identifier"]
    with AnyReader([folder]) as reader:
        assert sum(1 for _ in reader.messages()) == len(records)
    assert crowdcosim("export", str(log), "rosbag2", "--out", "bag").code == 2

    for form, read in (("csv", pl.read_csv), ("parquet", pl.read_parquet)):
        assert crowdcosim("export", str(log), form, "--out", form).code == 0
        crowd = read(crowdcosim.folder / form / f"crowd.{form}")
        assert crowd.height == 101 * 10
        states = [decode(r.payload, RobotState.TYPE) for r in records if r.topic == "/robot/state"]
        table = read(crowdcosim.folder / form / f"robot_state.{form}")
        np.testing.assert_array_equal(table["position.x"], [s.position[0] for s in states])
        np.testing.assert_array_equal(table["time"], [k / 10 for k in range(101)])
    assert crowdcosim("export", str(log), "crowdbot", "--out", "json").code == 0
    steps = load_file_as_list_of_dico(crowdcosim.folder / "json" / "robot.json")
    assert [get_clock(step) for step in steps] == [k / 10 for k in range(101)]
    assert {get_crowd(step).shape for step in steps} == {(10, 3)}
    # The module's frame begins midway to the goal, 40 m away, and x points back to the start.
    assert get_odom(steps[0])[0] == 20.0
    wrong = crowdcosim("export", str(log), "cvs")
    assert wrong.code == 2
    assert "did you mean 'csv'?" in wrong.stderr


@pytest.mark.slow
def test_a_log_can_be_published_again_under_the_keys_of_the_run(crowdcosim, log: Path) -> None:
    process = crowdcosim.start("replay", str(log), "--realtime", "5", "--listen", "tcp/127.0.0.1:17447", "--wait", "8")
    config = zenoh.Config()
    for key, value in (
        ("mode", "client"),
        ("connect/endpoints", ["tcp/127.0.0.1:17447"]),
        ("scouting/multicast/enabled", False),
    ):
        config.insert_json5(key, json.dumps(value))
    session = _open(config)
    subscriber = session.declare_subscriber("small/robot/state", zenoh.handlers.FifoChannel(1024))
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stdout + stderr
    got = []
    while (sample := subscriber.try_recv()) is not None:
        got.append(sample.payload.to_bytes())
    session.close()
    assert got == [r.payload for r in read_log(log / "episode.mcap").records if r.topic == "/robot/state"]


def _open(config: zenoh.Config) -> zenoh.Session:
    until = time.monotonic() + 20
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)


def test_the_foxglove_layout_shows_topics_that_logs_have(log: Path) -> None:
    layout = json.loads((Path(__file__).parents[2] / "docs" / "foxglove_layout.json").read_text())
    topics = set(read_log(log / "episode.mcap").types)
    panels = layout["configById"].values()
    shown = {topic for panel in panels for topic in panel.get("topics", {})}
    plotted = {path["value"].partition(".")[0] for panel in panels for path in panel.get("paths", [])}
    assert shown | plotted
    assert shown | plotted <= topics
