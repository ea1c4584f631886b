"""Checks where robots start and what they are asked to reach, before anything moves."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from crowdcosim import goal
from crowdcosim.messages import Goal
from crowdcosim.obstacles import HEIGHT
from crowdcosim.robots import Robot, Target
from crowdcosim.world import Wall, World
from orchestrator.scenario.file import WorldEntry
from orchestrator.scenario.problems import Problem, key_path
from orchestrator.scenario.yaml_tree import Node

Array = NDArray[np.float64]

_UNIT = 1e-6
"""how far a direction's length may be from 1: seven written digits reach it"""


def world_of(entry: WorldEntry) -> World:
    """The world with the walls that its boundary stands for, after its own."""
    walls = entry.walls + boundary(entry)
    return World(
        size=entry.size,
        periodic=entry.periodic,
        walls=walls,
        obstacles=entry.obstacles,
        mesh=entry.mesh,
        ceiling=entry.ceiling,
    )


def boundary(entry: WorldEntry) -> tuple[Wall, ...]:
    """Walls along the edges, up to the ceiling; people pass periodic ones, and those that stop robots only."""
    if entry.boundary == "none":
        return ()
    x, y = entry.size
    height = entry.ceiling or HEIGHT
    stops_x, stops_y = (entry.boundary == "all" and not periodic for periodic in entry.periodic)
    return (
        Wall(start=(0.0, 0.0), end=(x, 0.0), stops_people=stops_y, height=height),
        Wall(start=(x, 0.0), end=(x, y), stops_people=stops_x, height=height),
        Wall(start=(x, y), end=(0.0, y), stops_people=stops_y, height=height),
        Wall(start=(0.0, y), end=(0.0, 0.0), stops_people=stops_x, height=height),
    )


def placement_problems(world: World, robots: tuple[Robot, ...], tree: Node) -> list[Problem]:
    """All that is wrong with the walls, the robots' starts and their goals; `tree` says where they are written."""

    def problem(text: str, *path: str | int) -> Problem:
        return Problem(tree.nearest(*path).place, key_path(path), text)

    problems = [
        problem(f"starts and ends at {list(wall.start)}, expected two different points", "world", "walls", index)
        for index, wall in enumerate(world.walls)
        if wall.start == wall.end
    ]
    for robot in robots:
        problems += [problem(text, "robots", robot.name, "start") for text in _start_problems(world, robot)]
        goal_problems = list(_goal_problems(world, robot.goal)) or list(_task_problems(robot))
        problems += [problem(text, "robots", robot.name, "goal", *key) for text, *key in goal_problems]
    for first, second in combinations(robots, 2):
        gap = np.hypot(first.start.x - second.start.x, first.start.y - second.start.y)
        if gap < first.model.radius + second.model.radius:
            other = f"'{first.name}' ({tree.nearest('robots', first.name, 'start').place})"
            least = first.model.radius + second.model.radius
            text = f"the robot stands in {other}: centres {gap:.3g} m apart, expected at least {least:.3g} m"
            problems.append(problem(text, "robots", second.name, "start"))
    return problems


def _start_problems(world: World, robot: Robot) -> Iterator[str]:
    x, y = robot.start.x, robot.start.y
    if not (0 <= x <= world.size[0] and 0 <= y <= world.size[1]):
        width, depth = world.size
        yield f"found ({x:g}, {y:g}), expected a point in the world: x from 0 to {width:g}, y from 0 to {depth:g}"
        return
    if world.obstructed(np.array([[x, y]]))[0]:
        yield f"found ({x:g}, {y:g}), which is inside an obstacle, expected a free place"
        return
    for start, end in world.segments:
        gap = _distance(start, end, np.array([x, y]))
        if gap < robot.model.radius:
            yield (
                f"the robot stands in the wall from {start.tolist()} to {end.tolist()}: it is {gap:.3g} m from "
                f"({x:g}, {y:g}), expected at least the robot's radius, {robot.model.radius:g} m"
            )


def _goal_problems(world: World, target: Target) -> Iterator[tuple[str, ...]]:
    length = float(np.hypot(*target.direction))
    if target.direction == (0.0, 0.0):
        if not target.tolerance > 0:
            yield f"found {target.tolerance:g}, expected more than 0", "tolerance"
        if world.obstructed(np.array([[target.x, target.y]]))[0]:
            yield (f"found ({target.x:g}, {target.y:g}), which is inside an obstacle, expected a free place",)
    elif abs(length - 1.0) > _UNIT:
        unit = [round(component / length, 7) for component in target.direction]
        yield f"found a vector of length {length:.7g}, expected a unit vector such as {unit}, or [0, 0]", "direction"


def _task_problems(robot: Robot) -> Iterator[tuple[str, ...]]:
    target = robot.goal
    message = Goal(position=(target.x, target.y), direction=target.direction, tolerance=target.tolerance)  # type: ignore[arg-type]
    if goal.reached(message, np.array([robot.start.x, robot.start.y])):
        yield (f"the robot has reached it where it starts, at ({robot.start.x:g}, {robot.start.y:g})",)


def _distance(start: Array, end: Array, point: Array) -> float:
    """From a point (2,) to a wall between two others [m]."""
    along = end - start
    share = np.clip((point - start) @ along / max(float(along @ along), np.finfo(float).tiny), 0.0, 1.0)
    return float(np.hypot(*(start + share * along - point)))
