"""How the robot moved: speeds, accelerations, jerk, turning, standing still.

Velocity is that along the robot's heading, of each state; acceleration and jerk are its first and second difference
over the step, so that a change within one step counts as spread over it. Francis et al. 2023, "Principles and
guidelines for evaluating social robot navigation algorithms", table 3, unless said otherwise. The time limit changes
nothing: what was driven counts.
"""

from __future__ import annotations

import math

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, duration
from components.evaluator.scene import Step
from components.evaluator.travel import Travel

STILL_SPEED = 0.01
"""slower than this [m/s]"""
STILL_TURN_RATE = 0.02
"""and turning slower than this, a robot does not move [rad/s]"""


class Motion:
    """Sums over the robot's velocity and its changes."""

    def __init__(self) -> None:
        self.speed = 0.0
        """sum of |v| [m/s]"""
        self.speed_squared = 0.0
        """sum of v^2 dt [m2/s]"""
        self.turn = 0.0
        """sum of the heading's changes, absolute, the short way round [rad]"""
        self.still = 0
        """steps at whose end it does not move"""
        self.acceleration = 0.0
        """sum of |a| [m/s2]"""
        self.acceleration_max = 0.0
        self.jerk = 0.0
        """sum of |j| over all steps but the first [m/s3]"""
        self.jerk_max = 0.0
        self._last: float | None = None

    def add(self, step: Step) -> None:
        before, after, dt = step.before.robot, step.after.robot, step.dt
        v = _forward(after.velocity.tolist(), after.heading)
        acceleration = (v - _forward(before.velocity.tolist(), before.heading)) / dt
        self.speed += abs(v)
        self.speed_squared += v * v * dt
        self.turn += abs(math.remainder(after.heading - before.heading, 2 * math.pi))
        self.still += abs(v) < STILL_SPEED and abs(after.angular_velocity) < STILL_TURN_RATE
        self.acceleration += abs(acceleration)
        self.acceleration_max = max(self.acceleration_max, abs(acceleration))
        if self._last is not None:
            jerk = abs(acceleration - self._last) / dt
            self.jerk += jerk
            self.jerk_max = max(self.jerk_max, jerk)
        self._last = acceleration


def _forward(velocity: list[float], heading: float) -> float:
    return velocity[0] * math.cos(heading) + velocity[1] * math.sin(heading)


def two_steps(run: Run) -> Invalid | None:
    """A jerk takes three states."""
    return None if run.steps > 1 else Invalid(reason="the run has fewer than two steps")


@metric(symbol="v", unit="m/s", direction="higher", needs=(duration,))
def speed(run: Run, motion: Motion) -> float:
    """Mean speed.

    (1/K) sum |v_k|, standing still included.
    """
    return motion.speed / run.steps


@metric(symbol="a", unit="m/s2", direction="lower", needs=(duration,))
def acceleration(run: Run, motion: Motion) -> float:
    """Mean absolute acceleration.

    (1/K) sum |v_k - v_(k-1)| / dt.
    """
    return motion.acceleration / run.steps


@metric(symbol="a max", unit="m/s2", direction="lower", needs=(duration,))
def acceleration_max(motion: Motion) -> float:
    """Greatest absolute acceleration.

    max |v_k - v_(k-1)| / dt.
    """
    return motion.acceleration_max


@metric(symbol="jerk", unit="m/s3", direction="lower", needs=(two_steps,))
def jerk(run: Run, motion: Motion) -> float:
    """Mean absolute jerk.

    1/(K-1) sum |a_k - a_(k-1)| / dt.
    """
    return motion.jerk / (run.steps - 1)


@metric(symbol="jerk max", unit="m/s3", direction="lower", needs=(two_steps,))
def jerk_max(motion: Motion) -> float:
    """Greatest absolute jerk.

    max |a_k - a_(k-1)| / dt.
    """
    return motion.jerk_max


@metric(symbol="E", unit="m2/s", direction="lower")
def motion_energy(motion: Motion) -> float:
    """Energy of motion per mass.

    sum v_k^2 dt, Biswas et al. 2022, "SocNavBench", section 5. At the time limit it is that of the unfinished journey.
    """
    return motion.speed_squared


@metric(symbol="still", unit="s", direction="lower")
def time_not_moving(run: Run, motion: Motion) -> float:
    """Time in which the robot does not move.

    |v| < 0.01 m/s and |w| < 0.02 rad/s at the end of the step, Perez-Higueras et al. 2023, "HuNavSim", table II.
    """
    return motion.still * run.time / run.steps if run.steps else 0.0


@metric(symbol="turning", unit="rad", direction="lower")
def heading_change(motion: Motion) -> float:
    """Cumulative change of heading.

    sum |theta_k - theta_(k-1)|, the short way round. Perez-Higueras et al. 2023, "HuNavSim", table II. At the time
    limit it is that of the unfinished journey.
    """
    return motion.turn


@metric(symbol="irregularity", unit="rad/m", direction="lower")
def path_irregularity(motion: Motion, travel: Travel) -> float | Invalid:
    """Turning per length of path.

    sum |theta_k - theta_(k-1)| / L, Guzzi et al. 2013, "Human-friendly robot navigation in dynamic environments".
    Differs from the paper: all turning is unnecessary; there, what the way itself asks for is not counted.
    """
    return motion.turn / travel.length if travel.length > 0 else Invalid(reason="the robot did not move")
