"""Who runs into whom: collisions that are the robot's doing against those that are people's.

Perez-Higueras et al. 2023, "HuNavSim", table II. A collision is the robot's doing if, when they met, the robot moved
towards the person faster than the person towards the robot, along the line of their centres.
"""

from __future__ import annotations

import numpy as np

from components.evaluator.collisions import UNREPORTED
from components.evaluator.metric import metric
from components.evaluator.run import Invalid, duration, people
from components.evaluator.scene import Step
from crowdcosim.messages import Contacts


class Strikes:
    """Sums over collisions by who caused them."""

    def __init__(self) -> None:
        self.reported = True
        """False if a step came without a report"""
        self.walls = 0
        """contacts begun with walls and obstacles"""
        self.robots = 0
        """contacts begun with other robots"""
        self.by_robot = 0
        self.by_person = 0
        self.energy = 0.0
        """sum of dE [J]"""
        self.energy_max = 0.0
        """[J]"""

    def add(self, step: Step) -> None:
        contacts = step.contacts
        if contacts is None:
            self.reported = False
            return
        if not len(contacts.kind):
            return
        new = contacts.duration == 0.0
        self.walls += int(np.count_nonzero(new & (contacts.kind == Contacts.WALL)))
        self.robots += int(np.count_nonzero(new & (contacts.kind == Contacts.ROBOT)))
        begun = new & (contacts.kind == Contacts.PERSON)
        if not begun.any():
            return
        robots_share = contacts.robot_closing_speed[begun]
        robots_doing = int(np.count_nonzero(robots_share > contacts.approach_speed[begun] - robots_share))
        self.by_robot += robots_doing
        self.by_person += int(np.count_nonzero(begun)) - robots_doing
        self.energy += float(np.add.reduce(contacts.energy[begun]))
        self.energy_max = max(self.energy_max, float(contacts.energy[begun].max()))


@metric(symbol="N_c", unit="1", direction="lower", needs=(people, duration))
def collisions(strikes: Strikes) -> float | Invalid:
    """Collisions with people.

    N_c of Grzeskowiak et al. 2021, section V-B. A contact counts once, in the step in which it begins.
    """
    return float(strikes.by_robot + strikes.by_person) if strikes.reported else UNREPORTED


@metric(symbol="robot on person", unit="1", direction="lower", needs=(people, duration))
def robot_on_person(strikes: Strikes) -> float | Invalid:
    """Collisions in which the robot moved towards the person the faster of the two."""
    return float(strikes.by_robot) if strikes.reported else UNREPORTED


@metric(symbol="person on robot", unit="1", direction="lower", needs=(people, duration))
def person_on_robot(strikes: Strikes) -> float | Invalid:
    """Collisions in which the person was at least as fast towards the robot."""
    return float(strikes.by_person) if strikes.reported else UNREPORTED


@metric(symbol="sum dE", unit="J", direction="lower", needs=(people, duration))
def collision_energy(strikes: Strikes) -> float | Invalid:
    """Energy that collisions with people may absorb.

    sum dE of Grzeskowiak et al. 2021, section IV-D, dE = mu v_rel^2 / 2 of each contact when it begins.
    """
    return strikes.energy if strikes.reported else UNREPORTED


@metric(symbol="max dE", unit="J", direction="lower", needs=(people, duration))
def collision_energy_max(strikes: Strikes) -> float | Invalid:
    """Energy of the hardest collision with a person, 0 without any.

    max dE, Grzeskowiak et al. 2021, section IV-D.
    """
    return strikes.energy_max if strikes.reported else UNREPORTED


@metric(symbol="wall hits", unit="1", direction="lower")
def wall_collisions(strikes: Strikes) -> float | Invalid:
    """Collisions with walls and obstacles.

    Francis et al. 2023, "Principles and guidelines for evaluating social robot navigation algorithms", table 3. A
    contact counts once, in the step in which it begins.
    """
    return float(strikes.walls) if strikes.reported else UNREPORTED


@metric(symbol="robot hits", unit="1", direction="lower")
def robot_collisions(strikes: Strikes) -> float | Invalid:
    """Collisions with other robots.

    Francis et al. 2023, table 3: agent collision. A contact counts once, in the step in which it begins.
    """
    return float(strikes.robots) if strikes.reported else UNREPORTED
