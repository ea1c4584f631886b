"""What a user does all day, through the command line and with real processes."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
COMMANDS = ("run", "validate", "schema", "list", "check", "inspect", "evaluate")


def run(crowdcosim, path: str, *arguments: str, out: str = "out") -> dict:
    outcome = crowdcosim("run", path, "--out", out, "--json", *arguments)
    assert outcome.code == 0, outcome.stdout + outcome.stderr
    return outcome.json


def test_the_same_scenario_and_seed_give_the_same_bytes_wherever_components_live(crowdcosim, scenario) -> None:
    path = scenario("robots: {robot: {sensors: {lidar: {use: lidar}}, controller: {use: dwa}}}")
    results = [
        run(crowdcosim, path, out="processes"),
        run(crowdcosim, path, out="again"),
        run(crowdcosim, path, "--host", "inline", out="inline"),
        run(
            crowdcosim, path, "--set", "crowd.host=inline", "--set", "robots.robot.controller.host=inline", out="mixed"
        ),
        run(crowdcosim, path, "--host", "inline", "--set", "robots.robot.drive.host=process", out="other"),
    ]
    assert len({result["data_hash"] for result in results}) == 1
    assert len({json.dumps(result["metrics"]) for result in results}) == 1
    assert run(crowdcosim, path, "--seed", "9", "--host", "inline", out="seed")["data_hash"] != results[0]["data_hash"]


def test_a_run_leaves_a_log_a_report_and_a_result(crowdcosim, scenario) -> None:
    result = run(crowdcosim, scenario(), "--host", "inline")
    out = crowdcosim.folder / "out"
    assert sorted(p.name for p in out.iterdir()) == ["episode.mcap", "report.html", "result.json"]
    assert "<svg" in (out / "report.html").read_text()
    assert json.loads((out / "result.json").read_text())["data_hash"] == result["data_hash"]
    assert result["outcome"] == "time_limit"
    assert result["ticks"] == 100
    assert result["simulated_time"] == pytest.approx(10.0)


def test_a_person_reads_the_outcome_and_a_table(crowdcosim, scenario) -> None:
    outcome = crowdcosim("run", scenario(), "--host", "inline", "--out", "out")
    assert outcome.code == 0
    for word in ("hit the time limit", "T/Tcr", "Colliding", "f_c", "episode.mcap", "report.html"):
        assert word in outcome.stdout


def test_inspect_sums_up_what_run_did(crowdcosim, scenario) -> None:
    result = run(crowdcosim, scenario(), "--host", "inline")
    summary = crowdcosim("inspect", "out", "--json").json
    assert summary["complete"]
    assert summary["intact"]
    assert summary["data_hash"] == result["data_hash"]
    assert summary["metrics"] == result["metrics"]
    assert summary["run"]["seed"] == "1"
    topics = {topic["name"]: topic for topic in summary["topics"]}
    assert topics["/crowd"]["count"] == 101
    assert topics["/crowd"]["rate"] == pytest.approx(10.0)
    assert topics["/robot/controller/twist"]["count"] == 100
    assert topics["/robot/odometry"]["type"] == "nav_msgs/msg/Odometry"
    assert "robot/state" in crowdcosim("inspect", "out").stdout


def test_evaluate_gives_the_metrics_of_the_run_again(crowdcosim, scenario) -> None:
    result = run(crowdcosim, scenario(), "--host", "inline")
    evaluated = crowdcosim("evaluate", "out", "--json").json
    assert evaluated["metrics"] == result["metrics"]
    assert evaluated["equal_to_run"]


def test_a_log_is_opened_by_mcaps_and_rosbags_own_readers(crowdcosim, scenario) -> None:
    run(crowdcosim, scenario("robots: {robot: {sensors: {lidar: {use: lidar}}}}"), "--host", "inline")
    log = crowdcosim.folder / "out" / "episode.mcap"
    with log.open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        times = [message.log_time for _, _, message in reader.iter_messages(topics=["/clock"])]
        assert times == [k * 100_000_000 for k in range(101)]
    with AnyReader([log], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        scans = [c for c in reader.connections if c.topic == "/robot/lidar/scan"]
        _, stamp, data = next(reader.messages(scans))
        scan = reader.deserialize(data, scans[0].msgtype)
        assert stamp == 0
        assert len(scan.ranges) == 720
        frames = [c for c in reader.connections if c.topic == "/tf_static"]
        _, _, data = next(reader.messages(frames))
        transforms = reader.deserialize(data, frames[0].msgtype).transforms
        assert [(t.header.frame_id, t.child_frame_id) for t in transforms] == [
            ("map", "odom"),
            ("robot/base_link", scan.header.frame_id),
        ]
        crowds = [c for c in reader.connections if c.topic == "/crowd"]
        _, _, data = next(reader.messages(crowds))
        crowd = reader.deserialize(data, crowds[0].msgtype)
        assert len(crowd.position) == 20
        assert np.isfinite(crowd.position).all()


def test_baseline_drives_straight_until_it_is_there(crowdcosim, scenario) -> None:
    result = run(crowdcosim, scenario("crowd: {config: {count: 0}}\nend: {time_limit: 60}"), "--host", "inline")
    assert result["outcome"] == "goal"
    assert result["arrived"] == ["robot"]
    # 40 m at 1 m/s and 0.1 s for getting up to speed, on a grid of 0.1 s.
    assert result["simulated_time"] == pytest.approx(40.1, abs=0.11)
    metrics = {m["name"]: m["value"] for m in result["metrics"]}
    assert metrics["path_length"] == pytest.approx(40.0, abs=0.11)


def test_two_robots_drive_see_each_other_and_are_judged_each(crowdcosim) -> None:
    arguments = ["--set", "crowd.config.count=5", "--set", "end.time_limit=5"]
    result = run(crowdcosim, "two_robots", *arguments, out="processes")
    assert (
        run(crowdcosim, "two_robots", *arguments, "--host", "inline", out="inline")["data_hash"] == result["data_hash"]
    )
    assert {m["robot"] for m in result["metrics"]} == {"left", "right"}
    wiring = crowdcosim("validate", "two_robots", "--json").json["wiring"]
    assert wiring["left/lidar"]["others"] == ["right.state"]
    assert wiring["crowd"]["robots"] == ["left.state", "right.state"]


def test_an_episode_ends_at_the_first_collision_if_asked_to(crowdcosim, scenario) -> None:
    ahead = (
        "crowd: {config: {count: null, positions: [[7.0, 5.0]], flow: 1d-, reactive: false}}\nend: {collision: true}"
    )
    result = run(crowdcosim, scenario(ahead), "--host", "inline")
    assert result["outcome"] == "collision"
    # They meet in the middle: 2 m less both radii, closing at 1 + at most 1.8 m/s.
    assert 0.4 < result["simulated_time"] < 2.0


def test_slower_components_hold_their_last_word(crowdcosim, scenario) -> None:
    path = scenario("robots: {robot: {controller: {use: dwa, every: 5}, sensors: {lidar: {use: lidar, every: 2}}}}")
    result = run(crowdcosim, path, out="processes")
    assert run(crowdcosim, path, "--host", "inline", out="inline")["data_hash"] == result["data_hash"]
    topics = {t["name"]: t for t in crowdcosim("inspect", "inline", "--json").json["topics"]}
    assert topics["/robot/controller/twist"]["count"] == 20
    assert topics["/robot/lidar/scan"]["count"] == 50


def test_a_run_can_be_paced(crowdcosim, scenario) -> None:
    path = scenario("end: {time_limit: 4}\nreference: false")
    result = run(crowdcosim, path, "--host", "inline", "--realtime", "4")
    assert 0.9 < result["wall_time"] < 5.0
    assert result["real_time_factor"] < 4.5


def test_a_component_attaches_from_outside(crowdcosim, scenario) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    path = scenario("robots: {robot: {controller: {use: baseline, host: external}}}")
    with crowdcosim.start("run", path, "--out", "out", "--json", "--listen", endpoint) as process:
        node = subprocess.run(
            [
                *(sys.executable, "-m", "crowdcosim.node", "components.controllers.baseline:Baseline"),
                *("--endpoint", endpoint, "--run", "small", "--component", "robot/controller"),
            ],
            env=crowdcosim.environment,
            cwd=crowdcosim.folder,
            timeout=60,
            check=False,
        )
        stdout, stderr = process.communicate(timeout=60)
    assert node.returncode == 0
    assert process.returncode == 0, stderr
    inline = run(crowdcosim, scenario(), "--host", "inline", out="inline")
    assert json.loads(stdout)["data_hash"] == inline["data_hash"]


def test_a_controller_without_crowdcosim_drives_the_robot(crowdcosim) -> None:
    command = json.dumps([sys.executable, str(EXAMPLES / "plain_controller.py")])
    path = crowdcosim.folder / "plain.yaml"
    path.write_text(f"extends: {HERE / 'small.yaml'}\nrobots: {{robot: {{controller: {{exec: {command}}}}}}}\n")
    result = run(crowdcosim, str(path))
    assert result["ticks"] == 100
    lengths = [m["value"] for m in result["metrics"] if m["name"] == "path_length"]
    assert lengths[0] > 5.0


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_helps_with_an_example(crowdcosim, command) -> None:
    outcome = crowdcosim(command, "--help")
    assert outcome.code == 0
    assert "Example:" in outcome.stdout
    assert f"crowdcosim {command}" in " ".join(outcome.stdout.split())


def test_list_and_schema_tell_what_is_there(crowdcosim) -> None:
    shipped = crowdcosim("list", "--json").json
    assert {"corridor", "two_robots"} <= {entry["name"] for entry in shipped["scenarios"]}
    assert "turtlebot2" in {entry["name"] for entry in shipped["robots"]}
    assert {"baseline", "dwa", "rvo"} <= {entry["name"] for entry in shipped["controller"]}
    assert all(entry["description"] for group in shipped.values() for entry in group)
    schema = json.loads(crowdcosim("schema").stdout)
    assert schema["$schema"].startswith("https://json-schema.org")


@pytest.mark.parametrize(
    ("write", "words"),
    [
        (lambda path: None, "No such file"),
        (lambda path: path.write_bytes(b""), "is not an MCAP log"),
        (lambda path: path.write_bytes(b"hello world, this is no log at all"), "is not an MCAP log"),
    ],
)
def test_what_is_no_log_is_refused(crowdcosim, write, words) -> None:
    write(crowdcosim.folder / "x.mcap")
    for command in ("inspect", "evaluate"):
        outcome = crowdcosim(command, "x.mcap")
        assert outcome.code == 2
        assert words in outcome.stderr
        assert "Traceback" not in outcome.stderr


def test_a_log_that_was_cut_off_gives_back_every_complete_chunk(crowdcosim, scenario) -> None:
    path = scenario("robots: {robot: {sensors: {lidar: {use: lidar}}}}")
    run(crowdcosim, path, "--host", "inline")
    whole = (crowdcosim.folder / "out" / "episode.mcap").read_bytes()
    (crowdcosim.folder / "cut.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    summary = crowdcosim("inspect", "cut.mcap", "--json").json
    assert not summary["complete"]
    assert 3.0 < summary["duration"] < 10.0
    assert crowdcosim("evaluate", "cut.mcap").code == 2


def test_the_progress_of_a_run_is_told_on_a_terminal_only(crowdcosim, scenario) -> None:
    outcome = crowdcosim("run", scenario(), "--host", "inline", "--out", "out", "-q")
    assert outcome.code == 0
    assert outcome.stdout == ""
