"""The hundred scenarios of "Crowd against the machine" (Grzeskowiak et al. 2021), section IV, and what goes with them.

Five behaviours x four densities x five flows. The sixth behaviour, social forces that do not react to the robot, and
the robot alone are outside the hundred: suite `paper-extra`.

Not in the paper: where the people stand (its scenario files are not published), how many radii and speeds there are;
see `docs/benchmark.md`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orchestrator.suites.frozen import Frozen
from orchestrator.suites.placing import place

SIZE = (50.0, 10.0)
"""the corridor [m]"""
START, GOAL = (5.0, 5.0), (45.0, 5.0)
"""40 m along the corridor [m]"""
RADIUS = 0.3
"""of people [m]"""

TURTLEBOT2 = {
    "radius": 0.177,
    "height": 0.42,
    "mass": 20.0,
    "max_speed": 1.0,
    "min_speed": -0.2,
    "max_acceleration": 5.0,
    "max_angular_velocity": 3.1415927,
    "max_angular_acceleration": 10.0,
}
"""as in `scenarios/robots/turtlebot2.yaml`, frozen"""


_FROZEN = "Frozen: written by `crowdcosim generate {suite}`. Units: m, s, kg, rad."


class Behaviour(NamedTuple):
    """How people behave."""

    name: str
    words: str
    config: Mapping[str, Any]


BEHAVIOURS = (
    Behaviour(
        "rvo05-reactive",
        "RVO with a horizon of 0.5 s, reactive",
        {"policy": "orca", "time_horizon": 0.5, "reactive": True},
    ),
    Behaviour(
        "rvo05-nonreactive",
        "RVO with a horizon of 0.5 s, not reactive",
        {"policy": "orca", "time_horizon": 0.5, "reactive": False},
    ),
    Behaviour(
        "rvo15-reactive",
        "RVO with a horizon of 1.5 s, reactive",
        {"policy": "orca", "time_horizon": 1.5, "reactive": True},
    ),
    Behaviour(
        "rvo15-nonreactive",
        "RVO with a horizon of 1.5 s, not reactive",
        {"policy": "orca", "time_horizon": 1.5, "reactive": False},
    ),
    Behaviour("sf-reactive", "social forces, reactive", {"policy": "social_force", "reactive": True}),
)
"""RVO is ORCA's reciprocal planes with that horizon, as in the authors' code"""
SIXTH = Behaviour("sf-nonreactive", "social forces, not reactive", {"policy": "social_force", "reactive": False})

DENSITIES = (50, 100, 200, 350)
"""people in the corridor: 0.1, 0.2, 0.4 and 0.7 /m2"""

FLOWS = {
    "1d+": "with the robot",
    "1d-": "against the robot",
    "1dx": "along the corridor both ways",
    "2d": "across the robot's path one way",
    "2dx": "across the robot's path both ways",
}


def paper() -> Iterator[Frozen]:
    """The hundred."""
    yield from _scenarios(BEHAVIOURS, first=1)


def paper_extra() -> Iterator[Frozen]:
    """The sixth behaviour, and the robot alone."""
    yield from _scenarios((SIXTH,), first=101)
    yield Frozen(
        name="alone",
        comment="The paper's corridor without people. " + _FROZEN.format(suite="paper-extra"),
        body={"description": "The robot alone drives 40 m along the corridor.", "seed": 1} | corridor({"count": 0}),
    )


def _scenarios(behaviours: tuple[Behaviour, ...], first: int) -> Iterator[Frozen]:
    for number, (behaviour, count, flow) in enumerate(product(behaviours, DENSITIES, FLOWS), first):
        outside = number > 100
        title = "Outside the hundred" if outside else f"Scenario {number} of the hundred"
        density = count / (SIZE[0] * SIZE[1])
        places = place(number, count, radius=RADIUS, size=SIZE, keep_free=(*START, float(TURTLEBOT2["radius"])))
        yield Frozen(
            name=f"{behaviour.name}_{flow}_{count:03d}",
            comment=f'{title} of "Crowd against the machine" (Grzeskowiak et al. 2021).\n'
            + _FROZEN.format(suite="paper-extra" if outside else "paper"),
            body={
                "description": f"{count} people ({density:.1f} /m2) walk {FLOWS[flow]}: {behaviour.words}.",
                "seed": number,
            }
            | corridor(people(behaviour.config, flow, places)),
        )


def people(behaviour: Mapping[str, Any], flow: str, places: NDArray[np.float64]) -> dict[str, Any]:
    """The options of a crowd that stands at `places` (N, 2) [m], with nothing left to defaults that may change."""
    return dict(behaviour) | {
        "flow": flow,
        "radius": RADIUS,
        "preferred_speed": {"normal": {"mean": 1.3, "deviation": 0.2, "limits": [0.8, 1.8]}},
        "max_speed": 1.8,
        "max_acceleration": 5.0,
        "positions": places.tolist(),
    }


def corridor(crowd: Mapping[str, Any]) -> dict[str, Any]:
    """The corridor, its robot, its crowd with the options `crowd`, and its end."""
    return {
        "dt": 0.1,
        "world": {"size": list(SIZE), "periodic": [True, True], "boundary": "robots"},
        "robots": {
            "robot": {
                "model": dict(TURTLEBOT2),
                "start": {"x": START[0], "y": START[1], "heading": 0.0},
                "goal": {"x": GOAL[0], "y": GOAL[1], "direction": [1.0, 0.0]},
                "drive": {"use": "kinematic"},
                "sensors": {"odometry": {"use": "odometry"}},
                "controller": {"use": "baseline"},
            }
        },
        "crowd": {"use": "crowd", "config": dict(crowd)},
        "evaluator": {"use": "paper"},
        "end": {"time_limit": 180.0, "goal": "all"},
    }
