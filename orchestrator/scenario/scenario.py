"""A scenario, checked and complete: what a run needs to know before it starts."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

from crowdcosim.credentials import Admission
from crowdcosim.mesh import triangles
from crowdcosim.robots import Robot, RobotModel
from crowdcosim.world import World
from orchestrator.attach import admission_of
from orchestrator.pictures.cameras import Camera
from orchestrator.scenario import extends
from orchestrator.scenario.component_specs import ComponentSpec, component_specs
from orchestrator.scenario.file import NOT_ROBOTS, NOT_SENSORS, Deadlines, Ending, ScenarioFile, adapter
from orchestrator.scenario.mounts import mount_problems
from orchestrator.scenario.placement import placement_problems, world_of
from orchestrator.scenario.presets import with_presets
from orchestrator.scenario.problems import Place, Problem, ScenarioError, key_path, near_miss
from orchestrator.scenario.validation import check
from orchestrator.scenario.yaml_tree import Node, from_python

_LONGEST = 2**31
"""seconds that a ROS 2 `Time` can hold"""
_ANY_ROBOT = dict.fromkeys((f.name for f in fields(RobotModel) if f.default is f.default_factory is MISSING), 1e-9)
"""a model that gives rise to no problem of its own"""


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One experiment."""

    name: str
    description: str
    seed: int
    period: int
    """time step [ns]"""
    world: World
    robots: tuple[Robot, ...]
    components: tuple[ComponentSpec, ...]
    """in canonical order: the crowd; of each robot its drive, sensors, controller; the evaluator"""
    reference: bool
    """run the robots without people first"""
    ending: Ending
    deadlines: Deadlines
    admission: Admission | None
    """who may attach from other machines; `resolved` has nothing of it"""
    cameras: Mapping[str, Camera]
    """those of its own, for `crowdcosim render`"""
    resolved: Mapping[str, Any]
    """this scenario as plain data with nothing left out; `load` makes the same scenario of it, in any folder"""

    @property
    def last_tick(self) -> int:
        """The tick at which the time limit ends the run: the first that is not before it."""
        return -(-int(_nanoseconds(self.ending.time_limit)) // self.period)

    @property
    def repeatable(self) -> bool:
        """False if computing times, which differ from run to run, have a say in what happens."""
        return all(component.latency != "measured" for component in self.components)

    def component(self, name: str) -> ComponentSpec:
        """The component of that name.

        Raises:
            KeyError: if there is none.
        """
        for component in self.components:
            if component.name == name:
                return component
        raise KeyError(f"no component '{name}'{near_miss(name, (c.name for c in self.components))}")


def load(reference: str | Path | Mapping[str, Any], settings: Sequence[str] = ()) -> Scenario:
    """The scenario of a file, of a shipped name or of plain data, with each `key.path=value` laid over it.

    Raises:
        ScenarioError: with every problem found, each with its file, line and key.
    """
    return _checked(extends.with_settings(_tree(reference), settings))


def from_resolved(resolved: Mapping[str, Any]) -> Scenario:
    """The scenario that a log carries; its components are not imported, for they may be on another machine.

    Raises:
        ScenarioError: if it is not what `Scenario.resolved` holds.
    """
    return _checked(from_python(resolved, Place("the log's scenario", folder=Path.cwd())), trust=True)


def _checked(tree: Node, *, trust: bool = False) -> Scenario:
    problems: list[Problem] = []
    tree = with_presets(_with_robot_models(tree, problems), problems)
    file = check(adapter(), tree, "", problems)
    problems.extend(_name_problems(tree))
    components = component_specs(tree, file.host if file else "process", problems, trust=trust)
    if file is None:
        raise ScenarioError(problems)
    problems.extend(_time_problems(file, tree))
    file = _with_mesh_found(file, tree, trust, problems)
    admission = admission_of(file.attach, tree, problems)
    world, robots = world_of(file.world), _robots(file)
    problems.extend(placement_problems(world, robots, tree))
    if not (trust or problems):
        problems.extend(mount_problems(components, robots))
    if not robots:
        file = replace(file, end=_without_goal(file.end, tree, problems))
    if problems:
        raise ScenarioError(problems)
    return Scenario(
        name=file.name,
        description=file.description,
        seed=file.seed,
        period=int(_nanoseconds(file.dt)),
        world=world,
        robots=robots,
        components=components,
        reference=file.reference,
        ending=file.end,
        deadlines=file.deadlines,
        admission=admission,
        cameras=file.cameras,
        resolved=_resolved(file, components),
    )


def _tree(reference: str | Path | Mapping[str, Any]) -> Node:
    if isinstance(reference, Mapping):
        return extends.extended(from_python(reference, Place("scenario", folder=Path.cwd())), extends.scenarios())
    place = Place(str(reference), folder=Path.cwd())
    tree = extends.read(reference, extends.scenarios(), place)
    if isinstance(tree.value, dict) and "name" not in tree.value:
        name = extends.find(str(reference), extends.scenarios(), place).stem
        tree = replace(tree, value={"name": Node(name, tree.place)} | tree.value)
    return tree


def _with_robot_models(tree: Node, problems: list[Problem]) -> Node:
    """The tree with each robot's `model` as a mapping, read from the file that it names."""
    robots = tree.child("robots")
    if robots is None or not isinstance(robots.value, dict):
        return tree
    assert isinstance(tree.value, dict)
    entries = {
        name: _with_model(robot, key_path(("robots", name, "model")), problems) for name, robot in robots.items()
    }
    return replace(tree, value=tree.value | {"robots": replace(robots, value=entries)})


def _with_model(robot: Node, key: str, problems: list[Problem]) -> Node:
    model = robot.child("model")
    if model is None:
        return robot
    assert isinstance(robot.value, dict)
    try:
        if isinstance(model.value, str):
            model = extends.read(model.value, extends.robots(), model.place, key)
        else:
            model = extends.extended(model, extends.robots(), key)
    except ScenarioError as error:
        problems.extend(error.problems)
        model = from_python(_ANY_ROBOT, model.place)  # so that the other problems are found too
    return replace(robot, value=robot.value | {"model": model})


def _with_mesh_found(file: ScenarioFile, tree: Node, trust: bool, problems: list[Problem]) -> ScenarioFile:
    """The scenario with the absolute path of its mesh, which is read once to see whether it can be."""
    if file.world.mesh is None:
        return file
    place = tree.nearest("world", "mesh", "file").place
    mesh = replace(file.world.mesh, file=os.path.abspath(place.folder / file.world.mesh.file))
    if not trust:
        try:
            triangles(mesh)
        except ValueError as error:
            problems.append(Problem(place, "world.mesh.file", str(error)))
    return replace(file, world=replace(file.world, mesh=mesh))


def _name_problems(tree: Node) -> Iterator[Problem]:
    robots = tree.child("robots")
    for name, robot in robots.items() if robots else ():
        yield from _reserved("robot", NOT_ROBOTS, ("robots", name), robot)
        sensors = robot.child("sensors")
        for sensor, node in sensors.items() if sensors else ():
            yield from _reserved("sensor", NOT_SENSORS, ("robots", name, "sensors", sensor), node)


def _reserved(what: str, names: tuple[str, ...], path: tuple[str, ...], node: Node) -> Iterator[Problem]:
    if path[-1] in names:
        text = f"no {what} can be called '{path[-1]}'; names in use by others: {', '.join(names)}"
        yield Problem(node.place, key_path(path), text)


def _time_problems(file: ScenarioFile, tree: Node) -> Iterator[Problem]:
    for value, *path in ((file.dt, "dt"), (file.end.time_limit, "end", "time_limit")):
        text = ""
        if _nanoseconds(value) % 1:
            text = "expected a whole number of nanoseconds (at most 9 decimals)"
        elif value >= _LONGEST:
            text = f"expected less than {_LONGEST} s"
        elif value < file.dt:
            text = f"expected at least one time step, {file.dt} s"
        if text:
            yield Problem(tree.nearest(*path).place, key_path(path), f"found {value}, {text}")


def _without_goal(end: Ending, tree: Node, problems: list[Problem]) -> Ending:
    """The ending of a scenario without robots, in which nobody has a goal."""
    written = tree.nearest("end").child("goal")
    if written is not None and end.goal != "none":
        problems.append(Problem(written.place, "end.goal", f"found '{end.goal}', expected none: there are no robots"))
    return replace(end, goal="none")


def _nanoseconds(seconds: float) -> Decimal:
    """Exactly as many as the decimal that was written says: 0.1 s is 100000000 ns."""
    return Decimal(repr(seconds)) * 10**9


def _robots(file: ScenarioFile) -> tuple[Robot, ...]:
    return tuple(
        Robot(name=name, number=number, model=entry.model, start=entry.start, goal=entry.goal)
        for number, (name, entry) in enumerate(file.robots.items(), 1)
    )


def _resolved(file: ScenarioFile, components: tuple[ComponentSpec, ...]) -> dict[str, Any]:
    """The file with all defaults filled in, robots' models and components' options too."""
    resolved: dict[str, Any] = adapter().dump_python(file, mode="json", exclude_none=True, exclude={"attach"})
    for component in components:
        mapping = resolved
        for key in component.path[:-1]:
            mapping = mapping[key]
        mapping[component.path[-1]] = dict(component.entry)
    return resolved
