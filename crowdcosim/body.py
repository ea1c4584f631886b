"""What a human body is made of: 17 capsules, with the lengths, thicknesses and masses of its segments.

Lengths and masses after Winter, Biomechanics and Motor Control of Human Movement, 4th ed., 2009, fig. 4.1 and table
4.1; lengths are fractions of the stature H, masses of the body's mass.
Not in the book: thicknesses, and where the foot's joints are.
"""

from __future__ import annotations

import numpy as np

from crowdcosim.gait import HIP
from crowdcosim.messages import Contacts

THIGH, SHANK, ANKLE = 0.245, 0.246, 0.039
"""hip to knee, knee to ankle, ankle to sole"""
FOOT = 0.152
"""length of the foot, from its heel's back to its toes' tip"""
UPPER_ARM, FOREARM, HAND = 0.186, 0.146, 0.108
SHOULDER = HIP + 0.288
"""height of the shoulders' top: the trunk stands on the hips"""
HIPS, SHOULDERS = 0.191, 0.259
"""widths across the hips and across the shoulders"""
HEAD = 0.130

SIDES = ("left", "right")
SEGMENTS = (
    *(f"{side} {part}" for part in ("foot", "shank", "thigh") for side in SIDES),
    "pelvis",
    *(f"{side} trunk" for side in SIDES),
    "neck",
    "head",
    *(f"{side} {part}" for part in ("upper arm", "forearm", "hand") for side in SIDES),
)
"""the capsules of a body, in the order of `avatar.pose`"""

_RADIUS = {
    "foot": 0.022,
    "shank": 0.028,
    "thigh": 0.042,
    "pelvis": 0.060,
    "trunk": 0.058,
    "neck": 0.036,
    "head": 0.048,
    "upper arm": 0.026,
    "forearm": 0.021,
    "hand": 0.019,
}
# The head and neck of the book, 0.081, by volume; its thorax and abdomen, 0.355, half to each side.
_MASS = {
    "foot": 0.0145,
    "shank": 0.0465,
    "thigh": 0.100,
    "pelvis": 0.142,
    "trunk": 0.1775,
    "neck": 0.014,
    "head": 0.067,
    "upper arm": 0.028,
    "forearm": 0.016,
    "hand": 0.006,
}
_PART = {"foot": Contacts.FEET, "shank": Contacts.LOWER_LEGS, "thigh": Contacts.UPPER_LEGS}


def _segment(capsule: str) -> str:
    """The capsule's name without its side."""
    side, _, rest = capsule.partition(" ")
    return rest if side in SIDES else capsule


RADIUS = np.array([_RADIUS[_segment(capsule)] for capsule in SEGMENTS])
"""(17,) radii of the capsules over stature"""
MASS = np.array([_MASS[_segment(capsule)] for capsule in SEGMENTS])
"""(17,) masses of the capsules over the body's"""
BODY_PART = np.array([_PART.get(_segment(capsule), Contacts.UPPER_BODY) for capsule in SEGMENTS], np.uint8)
"""(17,) the part of the body that a capsule belongs to, as in `Contacts` and `BeamAgents`"""
