"""Where the sensors of a scenario sit on their robots."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping

from crowdcosim.component import config_adapter
from crowdcosim.robots import Mount, Robot, RobotModel
from orchestrator.scenario.component_specs import ComponentSpec
from orchestrator.scenario.problems import Problem
from orchestrator.scenario.registry import component_class


def sensor_frames(spec: ComponentSpec, model: RobotModel) -> Mapping[str, Mount]:
    """The frames of a sensor's messages that are fixed to its robot's base, and where they are.

    They are what the method `frames(model)` of the sensor's config says, if it has one.

    Raises:
        ValueError: if the config names a mount that the robot does not have.
    """
    config = _config(spec)
    frames: Mapping[str, Mount] = config.frames(model) if hasattr(config, "frames") else {}
    return {f"{spec.name}/{suffix}" if suffix else spec.name: mount for suffix, mount in frames.items()}


def optical_frames(spec: ComponentSpec, model: RobotModel) -> Mapping[str, str]:
    """Those of a sensor's frames that have an optical frame (REP 103), and what it is called: a camera's."""
    if not getattr(_config(spec), "optical", False):
        return {}
    return {frame: f"{frame}_optical_frame" for frame in sensor_frames(spec, model)}


def _config(spec: ComponentSpec) -> object:
    """The config of a sensor of a class that we know, else None."""
    if spec.use is None or "/" not in spec.name:
        return None
    adapter = config_adapter(component_class(spec.use, "sensor"))
    return adapter.validate_json(json.dumps(spec.config), strict=True)


def mount_problems(components: tuple[ComponentSpec, ...], robots: tuple[Robot, ...]) -> Iterator[Problem]:
    """Sensors that sit where their robots have no mount."""
    models = {robot.name: robot.model for robot in robots}
    for spec in components:
        if spec.robot in models:
            try:
                sensor_frames(spec, models[spec.robot])
            except ValueError as error:
                yield spec.problem(str(error), "config", str(error).partition(" ")[0])
