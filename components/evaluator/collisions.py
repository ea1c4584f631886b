"""How often, how long and how hard robot and people collide.

Grzeskowiak et al. 2021, "Crowd against the machine", sections IV-C (Colliding), IV-D and V-B (f_c, Q). Only contacts
with people count. Without any, Colliding is 1, f_c and Q are 0. The time limit changes nothing: all three are per time.
"""

from __future__ import annotations

import numpy as np

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, duration, people
from components.evaluator.scene import Step
from crowdcosim.messages import Contacts

UNREPORTED = Invalid(reason="nobody reports the robot's contacts: connect a component with the output Contacts")


class Collisions:
    """Sums over the robot's contacts with people."""

    def __init__(self) -> None:
        self.reported = True
        """False if a step came without a report"""
        self.steps = 0
        """T_collision / dt: steps in which at least one person touched the robot"""
        self.count = 0
        """N_c: contacts begun"""
        self.energy = 0.0
        """sum of dE over the contacts begun [J]"""

    def add(self, step: Step) -> None:
        if step.contacts is None:
            self.reported = False
            return
        person = step.contacts.kind == Contacts.PERSON
        if person.any():
            self.steps += 1
            begun = person & (step.contacts.duration == 0.0)
            self.count += int(np.count_nonzero(begun))
            self.energy += float(np.add.reduce(step.contacts.energy[begun]))


@metric(symbol="Colliding", unit="1", direction="higher", needs=(people, duration))
def colliding(run: Run, collisions: Collisions) -> float | Invalid:
    """Share of time in which no person touches the robot.

    1 - T_collision / T_scenario, where T_scenario is the robot's own time.
    """
    return 1.0 - collisions.steps / run.steps if collisions.reported else UNREPORTED


@metric(symbol="f_c", unit="1/s", direction="lower", needs=(people, duration))
def collision_rate(run: Run, collisions: Collisions) -> float | Invalid:
    """Collisions with people per time.

    N_c / T. A contact counts once, in the step in which it begins.
    """
    return collisions.count / run.time if collisions.reported else UNREPORTED


@metric(symbol="Q", unit="J/s", direction="lower", needs=(people, duration))
def collision_energy_rate(run: Run, collisions: Collisions) -> float | Invalid:
    """Energy that collisions with people may absorb, per time.

    sum dE / T, with dE = mu v_rel^2 / 2 of each contact when it begins.
    """
    return collisions.energy / run.time if collisions.reported else UNREPORTED
