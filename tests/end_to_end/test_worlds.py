"""The shipped worlds: people come and go, sensors and controllers cope, and a run repeats to the byte."""

from __future__ import annotations

import numpy as np
import pytest

from crowdcosim import Session
from crowdcosim.messages import BeamAgents

WORLDS = ("crossing", "bottleneck", "t_junction", "square", "circle")


@pytest.mark.parametrize("name", WORLDS)
def test_a_robot_drives_among_the_people_of_every_world(name: str) -> None:
    with Session(name, {"reference": False, "end.time_limit": 6.0}) as session:
        world = session.scenario.world
        ids = set(session.view.crowd.id.tolist())
        while not session.over:
            crowd = session.step().crowd
            ids |= set(crowd.id.tolist())
            assert not world.obstructed(crowd.position).any()
            # Whom the LiDAR hit is somebody who is there.
            beams = session.view.robot.sensors["lidar/agents"]
            assert set(beams.agent[beams.kind == BeamAgents.PERSON].tolist()) <= set(crowd.id.tolist())
        start = session.scenario.robots[0].start
        assert np.hypot(*session.view.robot.state.position - (start.x, start.y)) > 1.0
        assert ids == set(range(1, max(ids) + 1))


def test_comings_and_goings_are_the_same_bytes_inline_and_in_processes(crowdcosim) -> None:
    hashes = []
    for host in ("inline", "process"):
        settings = ("--set", "end.time_limit=6", "--set", "reference=false", "--host", host)
        outcome = crowdcosim("run", "crossing", *settings, "--out", host, "--json")
        assert outcome.code == 0, outcome.stderr
        hashes.append(outcome.json["data_hash"])
    assert hashes[0] == hashes[1]


def test_a_world_runs_without_a_robot(crowdcosim) -> None:
    settings = ("--set", "robots=null", "--set", "end.goal=none", "--set", "end.time_limit=3", "--host", "inline")
    outcome = crowdcosim("run", "t_junction", *settings, "--out", "alone", "--json")
    assert outcome.code == 0, outcome.stderr
    assert outcome.json["ticks"] == 30
