"""Where the sensors of a scenario sit on their robots."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping

from crowdcosim.component import config_adapter
from crowdcosim.robots import Mount, Robot, RobotModel
from orchestrator.component_specs import ComponentSpec
from orchestrator.problems import Problem
from orchestrator.registry import component_class


def sensor_frames(spec: ComponentSpec, model: RobotModel) -> Mapping[str, Mount]:
    """The frames of a sensor's messages that are fixed to its robot's base, and where they are.

    They are what the method `frames(model)` of the sensor's config says, if it has one.

    Raises:
        ValueError: if the config names a mount that the robot does not have.
    """
    if spec.use is None or "/" not in spec.name:
        return {}
    config = config_adapter(component_class(spec.use, "sensor")).validate_json(json.dumps(spec.config), strict=True)
    frames: Mapping[str, Mount] = config.frames(model) if hasattr(config, "frames") else {}
    return {f"{spec.name}/{suffix}" if suffix else spec.name: mount for suffix, mount in frames.items()}


def mount_problems(components: tuple[ComponentSpec, ...], robots: tuple[Robot, ...]) -> Iterator[Problem]:
    """Sensors that sit where their robots have no mount."""
    models = {robot.name: robot.model for robot in robots}
    for spec in components:
        if spec.robot in models:
            try:
                sensor_frames(spec, models[spec.robot])
            except ValueError as error:
                yield spec.problem(str(error), "config", str(error).partition(" ")[0])
