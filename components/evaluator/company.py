"""The company the robot keeps: how crowded it is, whose space it enters, what it makes people feel.

Means over the steps, each at its end, until the robot arrives. The time limit changes nothing.
"""

from __future__ import annotations

import math

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, duration, people
from components.evaluator.scene import Step

RANGES = (2.5, 5.0, 10.0)
"""of local densities; as `Look.within` has them [m]"""


class Company:
    """Sums over what is around the robot."""

    def __init__(self) -> None:
        self.within = [0, 0, 0]
        """sums of the people within `RANGES`"""
        self.closest_speed = 0.0
        """sum over the steps in which anybody is there [m/s]"""
        self.accompanied = 0
        """those steps"""
        self.intrusion = 0.0
        self.force = 0.0
        """[m/s2]"""

    def add(self, step: Step) -> None:
        around = step.after.around
        a, b, c = around.within
        self.within[0] += a
        self.within[1] += b
        self.within[2] += c
        if around.closest < math.inf:
            self.accompanied += 1
            self.closest_speed += around.closest_speed
        self.intrusion += around.intrusion
        self.force += around.social_force


def _density(run: Run, company: Company, i: int) -> float:
    return company.within[i] / run.steps / (math.pi * RANGES[i] ** 2)


@metric(symbol="density 2.5 m", unit="1/m2", direction="none", needs=(people, duration))
def density_2_5m(run: Run, company: Company) -> float:
    """People within 2.5 m of the robot per area.

    Mean over time of N / (pi r^2), centres within r, walls or not; as in Robot-SF.
    """
    return _density(run, company, 0)


@metric(symbol="density 5 m", unit="1/m2", direction="none", needs=(people, duration))
def density_5m(run: Run, company: Company) -> float:
    """People within 5 m of the robot per area.

    Mean over time of N / (pi r^2), centres within r, walls or not; as in Robot-SF.
    """
    return _density(run, company, 1)


@metric(symbol="density 10 m", unit="1/m2", direction="none", needs=(people, duration))
def density_10m(run: Run, company: Company) -> float:
    """People within 10 m of the robot per area.

    Mean over time of N / (pi r^2), centres within r, walls or not; as in Robot-SF.
    """
    return _density(run, company, 2)


@metric(symbol="v closest", unit="m/s", direction="none", needs=(people, duration))
def closest_person_speed(company: Company) -> float | Invalid:
    """Mean speed of the person nearest to the robot.

    Biswas et al. 2022, "SocNavBench", section 5: the closest pedestrian.
    """
    if not company.accompanied:
        return Invalid(reason="nobody was there after the start")
    return company.closest_speed / company.accompanied


@metric(symbol="intrusion", unit="1", direction="lower", needs=(people, duration))
def personal_space_intrusion(run: Run, company: Company) -> float:
    """Mean intrusion into personal space.

    Of the asymmetric Gaussian around each person, 1 at his centre, the greatest value at the robot's centre: Kirby
    2010, "Social robot navigation", appendix A; people within 5 m.
    """
    return company.intrusion / run.steps


@metric(symbol="social work", unit="m/s2", direction="lower", needs=(people, duration))
def social_work(run: Run, company: Company) -> float:
    """Mean social force between robot and people.

    sum of |f| on the robot by people within 5 m and of |f| on them by the robot, with the forces of Moussaid et al.
    2009; Perez-Higueras et al. 2023, "HuNavSim", table II. Differs from there: a mean over time and not a sum over
    steps, and without the force of walls.
    """
    return company.force / run.steps
