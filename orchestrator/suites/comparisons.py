"""Suites in which one part of the paper's corridor changes and all else stays: the robot, or the crowd's model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from components.crowd.policies import PolicyName
from orchestrator.shipped import names_in, robots_folder
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


def _places(number: int) -> NDArray[np.float64]:
    return place(number, COUNT, radius=RADIUS, size=SIZE, keep_free=(*START, ROOM))
