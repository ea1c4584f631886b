"""How things are, as the module's messages say it: one text each for clock, crowd, odometry and contacts."""

from __future__ import annotations

import math

import numpy as np

from crowdcosim.crowdbot.frame import Frame
from crowdcosim.messages import Contacts, Crowd, RobotState

PARTS = {
    Contacts.NO_PART: "none",
    Contacts.FEET: "feet",
    Contacts.LOWER_LEGS: "lower_legs",
    Contacts.UPPER_LEGS: "upper_legs",
    Contacts.UPPER_BODY: "upper_body",
}


def texts(
    frame: Frame, time: float, state: RobotState, crowd: Crowd | None, contacts: Contacts | None
) -> dict[str, str]:
    """The module's `clock`, `crowd`, `odom` and `report` at a time [s]."""
    clock = f"{time:.6f}"
    pose = (*frame.place(state.position), frame.direction(state.heading))
    rates = (*frame.vector(state.velocity), math.degrees(state.angular_velocity))
    people, touched = [], []
    if crowd is not None:
        people = [
            _group(who, *place) for who, place in zip(crowd.id.tolist(), frame.place(crowd.position), strict=True)
        ]
    if contacts is not None:
        for k in np.flatnonzero(contacts.kind == Contacts.PERSON):
            speed = frame.vector(contacts.relative_velocity[k])
            touched.append(_group(int(contacts.agent[k]), PARTS[int(contacts.body_part[k])], *speed))
    return {
        "clock": clock,
        "crowd": " ".join([clock, str(len(people)), *people]),
        "odom": " ".join([clock, *(str(float(number)) for number in (*pose, *rates))]),
        "report": " ".join([clock, str(len(touched)), *touched]),
    }


def _group(*words: object) -> str:
    return f"({' '.join(str(float(word)) if isinstance(word, float) else str(word) for word in words)})"
