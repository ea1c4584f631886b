"""ROS 2 nodes see the scenario as topics and drive its robot, with an independent implementation of rmw_zenoh."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_typestore

from crowdcosim.cdr import type_hash
from orchestrator.ros2.node import dds_type, gid_of

PEER = Path(__file__).parent / "ros2_peer.py"
SCENARIO = "robots: {robot: {sensors: {lidar: {use: lidar, config: {beams: 90}}}}}\nend: {time_limit: 5}"


@pytest.fixture
def port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def run(crowdcosim, path: str, port: int, *arguments: str) -> tuple[dict, dict]:
    """What crowdcosim and the peer say about an episode."""
    ours = crowdcosim.start("ros2", path, "--endpoint", f"tcp/127.0.0.1:{port}", "--json", *arguments)
    try:
        assert ours.stderr is not None
        said = ours.stderr.readline()
        assert "waits for commands" in said  # then the router listens
        peer = subprocess.run(
            [sys.executable, str(PEER), str(port), "60"], capture_output=True, text=True, timeout=120, check=False
        )
        stdout, stderr = ours.communicate(timeout=60)
    except BaseException:
        ours.kill()
        ours.communicate()
        raise
    assert ours.returncode == 0, stdout + stderr
    assert peer.returncode == 0, peer.stderr
    return json.loads(stdout), json.loads(peer.stdout)


def test_a_ros_node_drives_in_lockstep(crowdcosim, scenario: Callable[[str], str], port: int) -> None:
    result, seen = run(crowdcosim, scenario(SCENARIO), port)
    assert result["ticks"] == 50
    # Every tick waited for the command that answers its clock, so that nothing was lost; the first may be repeated.
    clock = seen["clock"]
    assert clock == sorted(clock)
    assert sorted(set(clock)) == [k * 100_000_000 for k in range(51)]
    assert len(seen["odom"]) >= 51
    assert set(seen["scan"]) == {90}
    # 0.8 m/s for 5 s, less the ramp of 0.16 s and what it covers: 5 m/s2 up to 0.8 m/s.
    assert seen["odom"][-1][0] - 5.0 == pytest.approx(0.8 * 5.0 - 0.5 * 0.8**2 / 5.0)
    assert seen["odom"][0][1] == "robot/base_link"
    topics = dict(seen["graph"])
    for topic, typename in (
        ("/clock", "rosgraph_msgs/msg/Clock"),
        ("/cmd_vel", "geometry_msgs/msg/Twist"),
        ("/people", "people_msgs/msg/People"),
        ("/markers/people", "visualization_msgs/msg/MarkerArray"),
        ("/tf_static", "tf2_msgs/msg/TFMessage"),
        ("/crowd", "crowdcosim_msgs/msg/Crowd"),
    ):
        assert typename in str(topics[topic])


def test_at_a_pace_nobody_is_waited_for(crowdcosim, scenario: Callable[[str], str], port: int) -> None:
    path = scenario("end: {time_limit: 2}")
    outcome = crowdcosim("ros2", path, "--endpoint", f"tcp/127.0.0.1:{port}", "--realtime", "4", "--json")
    assert outcome.code == 0, outcome.stderr
    assert outcome.json["ticks"] == 20
    assert outcome.json["real_time_factor"] < 4.4


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("--first", "0.5"), 1, "no command on /cmd_vel within 0.5 s"),
        (("--domain", "300"), 2, "expected a ROS_DOMAIN_ID from 0 to 232"),
        (("--robot", "robbot"), 2, "did you mean 'robot'?"),
        (("--realtime", "0"), 2, "expected a positive number"),
    ],
)
def test_what_cannot_work_is_said_in_words(
    crowdcosim, scenario: Callable[[str], str], port: int, arguments: tuple[str, ...], code: int, words: str
) -> None:
    outcome = crowdcosim("ros2", scenario(), "--endpoint", f"tcp/127.0.0.1:{port}", *arguments)
    assert outcome.code == code
    assert words in outcome.stderr.replace("\n", " ")


def test_types_are_named_and_hashed_as_in_ros_2_jazzy() -> None:
    assert dds_type("geometry_msgs/msg/Twist") == "geometry_msgs::msg::dds_::Twist_"
    # std_msgs/String of Jazzy, as `ros2 topic info --verbose` prints it.
    string = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    assert get_typestore(Stores.ROS2_JAZZY).hash_rihs01("std_msgs/msg/String") == string
    assert type_hash("geometry_msgs/msg/Twist") == get_typestore(Stores.ROS2_JAZZY).hash_rihs01(
        "geometry_msgs/msg/Twist"
    )


def test_a_gid_is_sixteen_bytes_of_the_token() -> None:
    assert len(gid_of("@ros2_lv/0/1/0/1/MP")) == 16
    assert gid_of("a") != gid_of("b")
    # XXH3-128 of the empty input, from its reference implementation: 99aa06d3014798d86001c324468d497f.
    assert gid_of("")[::-1].hex() == "99aa06d3014798d86001c324468d497f"
