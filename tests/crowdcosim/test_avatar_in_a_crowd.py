"""The walking body in real crowds, whose people swerve and brake: their feet slip little there, too."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.crowd.crowd import CrowdModel
from crowdcosim.avatar import pose
from crowdcosim.body import SEGMENTS
from crowdcosim.component import make
from crowdcosim.setup import Setup
from crowdcosim.world import World

FEET = [SEGMENTS.index("left foot"), SEGMENTS.index("right foot")]
SIZE = np.array([50.0, 10.0])
DT = 0.1


def slip(flow: str, count: int, policy: str, begin: float, end: float) -> float:
    """Mean speed of heels and balls that stay on the floor, from `begin` to `end` [s], over that of the people."""
    crowd = make(CrowdModel, {"flow": flow, "count": count, "policy": policy})
    world = World(size=(50.0, 10.0), periodic=(True, True))
    crowd.reset(Setup(component="crowd", period=100_000_000, seed=1, world=world))
    speeds, slips, before = [], [], None
    for k in range(math.ceil(end / DT)):
        people = crowd.step(())
        feet = pose(people.position, people.velocity, people.heading, people.stature, people.gait_phase)[:, FEET]
        down = feet[..., [2, 5]] - feet[..., 6:] < 1e-6
        place = np.stack([feet[..., 0:2], feet[..., 3:5]], axis=-2)
        if before is not None and k * DT > begin:
            way = place - before[1]
            way -= np.rint(way / SIZE) * SIZE
            slips.append(np.linalg.norm(way, axis=-1)[down & before[0]] / DT)
            speeds.append(np.hypot(*people.velocity.T).mean())
        before = down, place
    return float(np.concatenate(slips).mean() / np.mean(speeds))


@pytest.mark.parametrize(
    ("flow", "count", "policy", "begin", "end", "measured"),
    [
        ("1d-", 100, "orca", 4.0, 8.0, 0.001),  # steady walk
        ("1dx", 100, "orca", 4.0, 8.0, 0.02),
        ("1dx", 350, "orca", 0.5, 3.0, 0.076),  # two flows run into each other
        ("1dx", 350, "orca", 4.0, 15.0, 0.037),  # and have made lanes
        ("1dx", 350, "social_force", 4.0, 15.0, 0.038),
    ],
)
def test_feet_slip_little_when_people_make_way_for_each_other(flow, count, policy, begin, end, measured):
    """Another crowd slips otherwise: half as much again is no fault of the body."""
    assert slip(flow, count, policy, begin, end) < 1.5 * measured
