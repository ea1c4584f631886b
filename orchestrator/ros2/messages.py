"""Our messages as ROS 2 nodes expect them: `people_msgs`, which has no package of its own on most machines."""

from __future__ import annotations

from functools import cache
from typing import Any

from rosbags.typesys import get_types_from_msg

from crowdcosim.cdr import store
from crowdcosim.messages import Crowd, Point

PEOPLE_TYPE = "people_msgs/msg/People"
_PERSON_TYPE = "people_msgs/msg/Person"
_DEFINITIONS = {
    _PERSON_TYPE: """string name
geometry_msgs/Point position
geometry_msgs/Point velocity
float64 reliability
string[] tagnames
string[] tags
""",
    PEOPLE_TYPE: """std_msgs/Header header
people_msgs/Person[] people
""",
}


@cache
def types() -> Any:
    """The type store with `people_msgs` added."""
    known = store()
    for name, text in _DEFINITIONS.items():
        known.register(get_types_from_msg(text, name))
    return known


def people(crowd: Crowd) -> bytes:
    """The crowd as `people_msgs/People`, CDR: the truth, hence of reliability 1."""
    known = types().types
    person = known[_PERSON_TYPE]
    rows = zip(crowd.id.tolist(), crowd.position.tolist(), crowd.velocity.tolist(), strict=True)
    listed = [
        person(
            name=str(number),
            position=Point(x=x, y=y),
            velocity=Point(x=vx, y=vy),
            reliability=1.0,
            tagnames=[],
            tags=[],
        )
        for number, (x, y), (vx, vy) in rows
    ]
    message = known[PEOPLE_TYPE](header=crowd.header, people=listed)
    return bytes(types().serialize_cdr(message, PEOPLE_TYPE))
