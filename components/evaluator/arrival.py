"""Whether and how well the robot did what it was asked to."""

from __future__ import annotations

from components.evaluator.metric import metric
from components.evaluator.run import Invalid, Run, duration, reference
from components.evaluator.travel import Travel


@metric(symbol="S", unit="1", direction="higher")
def success(run: Run) -> float:
    """1 if the robot reached its goal in time, else 0.

    Francis et al. 2023, "Principles and guidelines for evaluating social robot navigation algorithms", table 3.
    """
    return float(run.arrived)


@metric(symbol="timeout", unit="1", direction="lower")
def timeout(run: Run) -> float:
    """1 if the episode ended before the robot reached its goal, else 0.

    Francis et al. 2023, table 3.
    """
    return float(not run.arrived)


@metric(symbol="SPL", unit="1", direction="higher", needs=(reference,))
def path_weighted_success(run: Run, travel: Travel) -> float | Invalid:
    """Success weighted by the length of the path.

    S L* / max(L, L*), Anderson et al. 2018, "On evaluation of embodied navigation agents", with L* that of the robot
    alone. 0 at the time limit.
    """
    return _weighted(run, "path_length", travel.length)


@metric(symbol="STL", unit="1", direction="higher", needs=(reference, duration))
def time_weighted_success(run: Run) -> float | Invalid:
    """Success weighted by the time to the goal.

    S T* / max(T, T*), Francis et al. 2023, table 3, with T* that of the robot alone. 0 at the time limit.
    """
    return _weighted(run, "time", run.time)


@metric(symbol="goal dist.", unit="m", direction="lower")
def goal_distance(run: Run) -> float:
    """What was left to the goal at the end.

    0 once it has been reached. Francis et al. 2023, table 3.
    """
    return run.goal_distance


def _weighted(run: Run, name: str, value: float) -> float | Invalid:
    best = (run.reference or {}).get(name)
    if best is None:
        return Invalid(reason=f"the reference run has no '{name}'")
    return best / max(value, best) if run.arrived else 0.0
