"""How much room the robot leaves to people: gaps between its disc and theirs, and time until they would touch.

A gap counts at the end of each step; 0 where discs touch. "Near collisions" are the future work of Grzeskowiak et al.
2021, "Crowd against the machine". Shares of time divide by the robot's own time; the time limit changes nothing.
"""

from __future__ import annotations

import math

import numpy as np

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, duration, people
from components.evaluator.scene import Step
from crowdcosim.messages import Contacts

NEAR_COLLISION = 0.5
"""a gap below this without touch is a near collision [m]"""
DANGER = 0.2
"""[m]"""
IMMINENT = 1.5
"""a collision that is less than this away is imminent [s]"""
INTIMATE, PERSONAL, SOCIAL = 0.45, 1.2, 3.6
"""upper ends of Hall's zones [m]"""


class Clearance:
    """Sums over the gap to the nearest person."""

    def __init__(self) -> None:
        self.least = math.inf
        """[m]"""
        self.sum = 0.0
        """of the gaps in the steps where anybody is there [m]"""
        self.steps = 0
        """in which anybody is there"""
        self.near_steps = 0
        """in which the gap is below `NEAR_COLLISION` and nobody touches the robot"""
        self.near_begun = 0
        """spells of such steps"""
        self.danger = 0
        self.zones = [0, 0, 0]
        """steps in the intimate, the personal and the social zone"""
        self.time_to_collision = math.inf
        """the least outside contacts [s]"""
        self.imminent = 0
        self._near = False

    def add(self, step: Step) -> None:
        around = step.after.around
        gap = around.clearance
        if gap == math.inf:
            self._near = False
            return
        touching = gap == 0.0 or _touched(step.contacts)
        self.least = min(self.least, gap)
        self.sum += gap
        self.steps += 1
        near = gap < NEAR_COLLISION and not touching
        self.near_steps += near
        self.near_begun += near and not self._near
        self._near = near
        self.danger += gap < DANGER
        if gap < SOCIAL:
            self.zones[0 if gap < INTIMATE else 1 if gap < PERSONAL else 2] += 1
        if not touching:
            self.time_to_collision = min(self.time_to_collision, around.time_to_collision)
        self.imminent += around.time_to_collision < IMMINENT


def _touched(contacts: Contacts | None) -> bool:
    return contacts is not None and bool(np.count_nonzero(contacts.kind == Contacts.PERSON))


@metric(symbol="d min", unit="m", direction="higher", needs=(people, duration))
def clearance_min(clearance: Clearance) -> float | Invalid:
    """Least gap to a person.

    Francis et al. 2023, table 3: minimum distance to human; from disc to disc.
    """
    return clearance.least if clearance.steps else Invalid(reason="nobody was there after the start")


@metric(symbol="d mean", unit="m", direction="higher", needs=(people, duration))
def clearance_mean(clearance: Clearance) -> float | Invalid:
    """Mean gap to the nearest person.

    (1/K) sum of the gaps, over the steps in which anybody is there.
    """
    return clearance.sum / clearance.steps if clearance.steps else Invalid(reason="nobody was there after the start")


@metric(symbol="N near", unit="1", direction="lower", needs=(people, duration))
def near_collisions(clearance: Clearance) -> float:
    """Near collisions: spells with somebody within 0.5 m and no touch.

    A spell ends when the gap widens or a touch begins. In a dense crowd one may last for long: see the share of time.
    """
    return float(clearance.near_begun)


@metric(symbol="f near", unit="1/s", direction="lower", needs=(people, duration))
def near_collision_rate(run: Run, clearance: Clearance) -> float:
    """Near collisions per time.

    Spells with a gap within 0.5 m and no touch, over T.
    """
    return clearance.near_begun / run.time


@metric(symbol="near", unit="1", direction="lower", needs=(people, duration))
def near_collision_share(run: Run, clearance: Clearance) -> float:
    """Share of time with somebody within 0.5 m and no touch."""
    return clearance.near_steps / run.steps


@metric(symbol="danger", unit="1", direction="lower", needs=(people, duration))
def danger(run: Run, clearance: Clearance) -> float:
    """Share of time in which somebody is within 0.2 m, touches included.

    The discomfort distance of Chen et al. 2019, "Crowd-robot interaction" (CrowdNav).
    """
    return clearance.danger / run.steps


@metric(symbol="TTC min", unit="s", direction="higher", needs=(people, duration))
def time_to_collision_min(clearance: Clearance) -> float | Invalid:
    """Least time to collision outside contacts.

    Until the first discs touch if everybody keeps the velocity: van der Horst 1990; Francis et al. 2023, table 3. No
    value if nobody ever was on a collision course.
    """
    ttc = clearance.time_to_collision
    return ttc if math.isfinite(ttc) else Invalid(reason="nobody was on a collision course")


@metric(symbol="TTC < 1.5 s", unit="1", direction="lower", needs=(people, duration))
def imminent_collision_share(run: Run, clearance: Clearance) -> float:
    """Share of time in which a collision is less than 1.5 s away, contacts included.

    The threshold is that of van der Horst and Hogema 1993, "Time-to-collision and collision avoidance systems".
    """
    return clearance.imminent / run.steps


@metric(symbol="intimate", unit="1", direction="lower", needs=(people, duration))
def intimate_share(run: Run, clearance: Clearance) -> float:
    """Share of time with the nearest person in the intimate zone.

    A gap below 0.45 m, Hall 1966, "The hidden dimension".
    """
    return clearance.zones[0] / run.steps


@metric(symbol="personal", unit="1", direction="lower", needs=(people, duration))
def personal_share(run: Run, clearance: Clearance) -> float:
    """Share of time with the nearest person in the personal zone.

    A gap from 0.45 to 1.2 m, Hall 1966, "The hidden dimension".
    """
    return clearance.zones[1] / run.steps


@metric(symbol="social", unit="1", direction="none", needs=(people, duration))
def social_share(run: Run, clearance: Clearance) -> float:
    """Share of time with the nearest person in the social zone.

    A gap from 1.2 to 3.6 m, Hall 1966, "The hidden dimension".
    """
    return clearance.zones[2] / run.steps
