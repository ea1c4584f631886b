"""Suites in which one part of the paper's corridor changes and all else stays: robot, crowd model, or sensors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from components.crowd.policies import PolicyName
from orchestrator.scenario.shipped import names_in, robots_folder
from orchestrator.suites.frozen import Frozen
from orchestrator.suites.paper import FLOWS, RADIUS, SIZE, START, corridor, people
from orchestrator.suites.placing import place

COUNT = 100
"""people: 0.2 /m2"""
ROOM = 0.5
"""radius of the largest shipped robot [m]"""
NOT_COMPARED = ("generic", "random")
"""policies that avoid nobody"""


def robots() -> Iterator[Frozen]:
    """Every shipped robot in every flow, among the same people."""
    for robot in names_in(robots_folder()):
        for number, (flow, words) in enumerate(FLOWS.items(), 201):
            crowd = people({"policy": "orca", "time_horizon": 1.5, "reactive": True}, flow, _places(number))
            body = corridor(crowd)
            body["robots"]["robot"]["model"] = robot
            about = {"description": f"{robot} among {COUNT} people who walk {words}.", "seed": number}
            yield Frozen(name=f"{robot}_{flow}", comment="Written by `crowdcosim generate robots`.", body=about | body)


def crowds() -> Iterator[Frozen]:
    """Every shipped crowd model in every flow, everybody beginning at the same places."""
    for policy in get_args(PolicyName):
        if policy in NOT_COMPARED:
            continue
        for number, (flow, words) in enumerate(FLOWS.items(), 301):
            crowd = people({"policy": policy, "reactive": True}, flow, _places(number))
            body = {"description": f"{COUNT} people walk {words}: {policy}.", "seed": number} | corridor(crowd)
            yield Frozen(name=f"{policy}_{flow}", comment="Written by `crowdcosim generate crowds`.", body=body)


SENSING: dict[str, dict[str, Any]] = {
    "truth": {"odometry": {"use": "odometry"}},
    "sight": {"odometry": {"use": "odometry"}, "people": {"use": "detections"}},
    "noisy": {
        "odometry": {"use": "odometry"},
        "people": {
            "use": "detections",
            "config": {
                "miss": 0.1,
                "false_alarms": 0.2,
                "position_deviation": 0.1,
                "velocity_deviation": 0.2,
                "correlation_time": 0.5,
            },
        },
    },
    "ahead": {
        "odometry": {"use": "odometry"},
        "people": {"use": "detections", "config": {"field_of_view": 1.5, "range_max": 5.0}},
    },
    "slow": {"odometry": {"use": "odometry"}, "people": {"use": "detections", "config": {"rate": 2.0}}},
}
"""What the robot knows: everything; those in sight, around and up to 10 m; the same with errors, misses and false
alarms; those within 43 degrees of ahead and 5 m; those in sight, twice a second"""


def sensors() -> Iterator[Frozen]:
    """Every way of sensing people in every flow, among the same people."""
    for sensing, components in SENSING.items():
        for number, (flow, words) in enumerate(FLOWS.items(), 401):
            body = corridor(people({"policy": "orca", "time_horizon": 1.5, "reactive": True}, flow, _places(number)))
            body["robots"]["robot"]["sensors"] = components
            about = {"description": f"{COUNT} people walk {words}; the robot's sensing: {sensing}.", "seed": number}
            yield Frozen(
                name=f"{sensing}_{flow}", comment="Written by `crowdcosim generate sensors`.", body=about | body
            )


def _places(number: int) -> NDArray[np.float64]:
    return place(number, COUNT, radius=RADIUS, size=SIZE, keep_free=(*START, ROOM))
