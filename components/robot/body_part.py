"""Which part of a standing person a robot touches at a given height, and how much of the body's inertia lies behind it.

Joint heights are Winter's (Biomechanics and Motor Control of Human Movement, 4th ed., 2009, fig. 4.1) as fractions of
stature: ankle 0.039, knee 0.039 + 0.246, hip 0.285 + 0.245.
Reflected masses are those of Grzeskowiak et al., "Crowd against the machine", 2021, section "Collision assessment".
Not in the paper: the upper body's reflected mass. A free chain of the same four rigid bodies (Winter's segments, 73 kg,
1.74 m, hinged at ankle, knee and hip), hit at the middle of a segment, gives 3, 10, 24 and 54 kg: the last is used.
"""

from __future__ import annotations

from crowdcosim.messages import Contacts

_TOPS = ((Contacts.FEET, 0.039), (Contacts.LOWER_LEGS, 0.285), (Contacts.UPPER_LEGS, 0.530))

REFLECTED_MASS = {
    Contacts.FEET: 4.0,
    Contacts.LOWER_LEGS: 13.0,
    Contacts.UPPER_LEGS: 24.0,
    Contacts.UPPER_BODY: 54.0,
}
"""body part -> reflected mass [kg]"""


def part_at(height: float, stature: float) -> int:
    """The body part (a constant of `Contacts`) at `height` [m] above the ground of a person of `stature` [m]."""
    for part, top in _TOPS:
        if height <= top * stature:
            return part
    return Contacts.UPPER_BODY
