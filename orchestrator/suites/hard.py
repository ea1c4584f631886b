"""Hard cases: situations that make robots fail, one per file.

Bottleneck, T-junction and crossing are the shipped scenarios; sudden stop, cut-in, queue and a group that does not
split are made of a few people with journeys of their own in an open hall.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from orchestrator.suites.frozen import Frozen

Area = dict[str, list[float]]

HALL = [30.0, 8.0]
"""extent of the hall [m]"""
MIDDLE = 4.0
"""where the robot drives along it [m]"""
FOR_GOOD = 1000.0
"""a wait that nobody sees the end of [s]"""


def hard() -> Iterator[Frozen]:
    """All of them."""
    for name in ("bottleneck", "crossing", "t_junction"):
        yield _frozen(name, {"extends": name, "description": f"The shipped scenario {name}, as a hard case."})
    yield _hall("sudden_stop", "Three people walk ahead of the robot and stop.", *_sudden_stop())
    yield _hall("cut_in", "Somebody overtakes the robot, cuts in and hesitates.", *_cut_in())
    yield _hall("queue", "Ten people queue across the robot's way; there is room at one end.", *_queue())
    yield _hall("group", "Two groups of four come abreast and keep together.", *_group())


def _sudden_stop() -> tuple[dict[str, Area], list[dict[str, Any]], dict[str, Any]]:
    areas = {
        "ahead": {"x": [5.0, 7.0], "y": [3.0, 5.0]},
        "halt": {"x": [14.0, 15.0], "y": [3.0, 5.0]},
        "east": {"x": [28.0, 30.0], "y": [2.0, 6.0]},
    }
    journey = {"start": "ahead", "via": [{"area": "halt", "wait": 15}], "goal": "east", "count": 3}
    return areas, [journey], {"preferred_speed": 1.0}


def _cut_in() -> tuple[dict[str, Area], list[dict[str, Any]], dict[str, Any]]:
    areas = {
        "behind": {"x": [0.5, 1.5], "y": [5.5, 6.5]},
        "before": {"x": [13.5, 14.5], "y": [3.6, 4.4]},
        "east": {"x": [28.0, 30.0], "y": [2.0, 6.0]},
    }
    journey = {"start": "behind", "via": [{"area": "before", "wait": 3}], "goal": "east", "count": 1}
    return areas, [journey], {"preferred_speed": 1.7}


def _queue() -> tuple[dict[str, Area], list[dict[str, Any]], dict[str, Any]]:
    areas: dict[str, Area] = {}
    journeys = []
    for i in range(10):
        y = 0.4 + 0.65 * i
        areas[f"place{i}"] = {"x": [14.6, 15.4], "y": [round(y - 0.32, 2), round(y + 0.32, 2)]}
        stay = [{"area": f"place{i}", "wait": FOR_GOOD}]
        journeys.append({"start": f"place{i}", "via": stay, "goal": f"place{i}", "count": 1})
    return areas, journeys, {}


def _group() -> tuple[dict[str, Area], list[dict[str, Any]], dict[str, Any]]:
    areas = {"east": {"x": [18.0, 28.0], "y": [1.0, 7.0]}, "west": {"x": [0.0, 1.0], "y": [1.0, 7.0]}}
    return areas, [{"start": "east", "goal": "west", "count": 8}], {"groups": [0, 0, 0, 1]}


def _hall(
    name: str, description: str, areas: dict[str, Area], journeys: list[dict[str, Any]], options: dict[str, Any]
) -> Frozen:
    return _frozen(
        name,
        {
            "description": description,
            "seed": 1,
            "dt": 0.1,
            "world": {"size": list(HALL), "boundary": "all"},
            "robots": {
                "robot": {
                    "model": "turtlebot2",
                    "start": {"x": 3.0, "y": MIDDLE, "heading": 0.0},
                    "goal": {"x": 27.0, "y": MIDDLE, "direction": [1.0, 0.0]},
                    "drive": {"use": "kinematic"},
                    "sensors": {"odometry": {"use": "odometry"}},
                    "controller": {"use": "baseline"},
                }
            },
            "crowd": {"use": "crowd", "config": options | {"areas": areas, "journeys": journeys}},
            "evaluator": {"use": "paper"},
            "end": {"time_limit": 90.0, "goal": "all"},
        },
    )


def _frozen(name: str, body: dict[str, Any]) -> Frozen:
    return Frozen(name=name, comment="Written by `crowdcosim generate hard`. Units: m, s, kg, rad.", body=body)
