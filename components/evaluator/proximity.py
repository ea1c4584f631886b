"""How close people are to the robot.

Grzeskowiak et al. 2021, "Crowd against the machine", section IV-C: crowd proximity.
"""

from __future__ import annotations

from components.evaluator.metric import metric
from components.evaluator.run import Run, duration, people
from components.evaluator.scene import Step

RANGE = 5.0
"""R: people farther away than this count as this far [m]."""


class Proximity:
    """Sums over the distance to the nearest person."""

    def __init__(self) -> None:
        self.distance = 0.0
        """sum over the steps of the mean of min(d_min, R) during the step [m]"""

    def add(self, step: Step) -> None:
        # The trapezoidal rule: the result depends on the step's length to second order only.
        self.distance += 0.5 * (min(step.before.around.closest, RANGE) + min(step.after.around.closest, RANGE))


@metric(symbol="Prox.", unit="1", direction="none", needs=(people, duration))
def proximity(run: Run, near: Proximity) -> float:
    """Closeness of the nearest person.

    1 - (1/T) integral of d_min/R dt with d_min centre to centre and R = 5 m. 0 if nobody comes within R, 1 if somebody
    stands in the robot all the time. The paper does not say which is better: it rises with density. The time limit
    changes nothing.
    Differs from the paper: its sum over steps is the integral; d_min > R, which it excludes, counts as R.
    """
    return 1.0 - near.distance / (run.steps * RANGE)
