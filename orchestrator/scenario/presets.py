"""Sensors by the name of a device: `preset: urg-04lx` stands for a file with the component and its options."""

from __future__ import annotations

from dataclasses import replace

from orchestrator.scenario import extends
from orchestrator.scenario.problems import Problem, ScenarioError, key_path
from orchestrator.scenario.yaml_tree import Node


def with_presets(tree: Node, problems: list[Problem]) -> Node:
    """The tree with each sensor laid over the device that its `preset` names."""
    robots = tree.child("robots")
    if robots is None or not isinstance(robots.value, dict):
        return tree
    assert isinstance(tree.value, dict)
    entries = {name: _of_robot(name, robot, problems) for name, robot in robots.items()}
    return replace(tree, value=tree.value | {"robots": replace(robots, value=entries)})


def _of_robot(name: str, robot: Node, problems: list[Problem]) -> Node:
    sensors = robot.child("sensors")
    if sensors is None or not isinstance(sensors.value, dict):
        return robot
    assert isinstance(robot.value, dict)
    entries = {
        sensor: _of_sensor(node, key_path(("robots", name, "sensors", sensor, "preset")), problems)
        for sensor, node in sensors.items()
    }
    return replace(robot, value=robot.value | {"sensors": replace(sensors, value=entries)})


def _of_sensor(sensor: Node, key: str, problems: list[Problem]) -> Node:
    preset = sensor.child("preset")
    if preset is None or not isinstance(preset.value, str):
        return sensor
    assert isinstance(sensor.value, dict)
    own = replace(sensor, value={k: node for k, node in sensor.value.items() if k != "preset"})
    try:
        device = extends.read(preset.value, extends.devices(), preset.place, key)
    except ScenarioError as error:
        problems.extend(error.problems)
        return sensor
    use, named = device.child("use"), own.child("use")
    if use is not None and named is not None and use.value != named.value:
        text = f"'{preset.value}' is a {use.value}, found beside `use: {named.value}`; leave one of them out"
        problems.append(Problem(preset.place, key, text))
        return own
    return extends.merge(device, own)
