"""The short names of the shipped components, and from what a scenario writes under `use` to an import string."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal, get_args

from crowdcosim.component import Component, ComponentError, Kind, ports_of
from crowdcosim.loading import load_class
from orchestrator.scenario.problems import near_miss

Family = Literal["crowd", "drive", "sensor", "controller", "evaluator"]

SHIPPED: dict[Family, dict[str, str]] = {
    "crowd": {
        "crowd": "components.crowd.crowd:CrowdModel",
        "replay": "components.crowd.replay:Replay",
    },
    "drive": {
        "forces": "components.robot.forces:Forces",
        "kinematic": "components.robot.kinematic:Kinematic",
        "wheels": "components.robot.wheels:Wheels",
    },
    "sensor": {
        "color_camera": "components.sensors.camera:ColorCamera",
        "depth_camera": "components.sensors.camera:DepthCamera",
        "detections": "components.sensors.detections:PeopleTracker",
        "encoders": "components.sensors.encoders:WheelEncoders",
        "imu": "components.sensors.imu:InertialUnit",
        "labelled_camera": "components.sensors.camera:LabelledCamera",
        "lidar": "components.sensors.lidar:Lidar",
        "odometry": "components.sensors.odometry:Odometer",
        "point_cloud": "components.sensors.point_cloud:PointCloud",
        "rgbd_camera": "components.sensors.camera:RGBDCamera",
        "ultrasound": "components.sensors.ultrasound:Ultrasound",
    },
    "controller": {
        "baseline": "components.controllers.baseline:Baseline",
        "dwa": "components.controllers.dwa:DWA",
        "dwa_crowdbot": "components.controllers.dwa_rollout:CrowdBotDWA",
        "dwa_python_robotics": "components.controllers.dwa_rollout:PythonRoboticsDWA",
        "mpc": "components.controllers.mpc:MPC",
        "mppi": "components.controllers.mppi:MPPI",
        "onnx": "components.controllers.onnx_policy:OnnxPolicy",
        "python_robotics": "components.controllers.python_robotics:PythonRobotics",
        "rvo": "components.controllers.rvo:RVO",
        "rvo_crowdbot": "components.controllers.rvo_crowdbot:CrowdBotRVO",
        "social_force": "components.controllers.social_force:SocialForce",
        "ttc": "components.controllers.ttc:TTC",
    },
    "evaluator": {"paper": "components.evaluator.paper:PaperEvaluator"},
}

KIND: dict[Family, Kind] = {
    "crowd": "mover",
    "drive": "mover",
    "sensor": "reactor",
    "controller": "reactor",
    "evaluator": "observer",
}
_BASE: dict[Kind, str] = {"mover": "Mover", "reactor": "Controller or Sensor", "observer": "Evaluator"}


def import_string(use: str, family: Family, folder: Path) -> str:
    """What `use` stands for: `package.module:Class`, or `/absolute/path/file.py:Class`.

    Raises:
        ComponentError: if it is a short name that the family does not have.
    """
    source, separator, name = use.rpartition(":")
    if separator:
        return f"{os.path.abspath(folder / source)}:{name}" if source.endswith(".py") else use
    if use in SHIPPED[family]:
        return SHIPPED[family][use]
    if use.endswith(".py"):
        raise ComponentError(f"found '{use}', expected the class too: '{use}:Class'")
    for other in get_args(Family):
        if use in SHIPPED[other] and other != family:
            raise ComponentError(f"'{use}' is a {other}, expected a {family}: {', '.join(SHIPPED[family])}")
    raise ComponentError(
        f"there is no {family} '{use}'{near_miss(use, SHIPPED[family])}; shipped: {', '.join(SHIPPED[family])}; "
        "write your own as 'package.module:Class' or './file.py:Class'"
    )


def component_class(use: str, family: Family) -> type[Component]:
    """The class that an import string names, with ports that can be read and the kind that its family needs.

    Raises:
        ComponentError: if it cannot be imported, breaks the contract or is of another kind.
    """
    try:
        cls = load_class(use)
    except (OSError, ValueError) as error:  # a name that no file or module can have
        raise ComponentError(f"'{use}' cannot be imported: {error}") from None
    kind = ports_of(cls).kind
    if kind != KIND[family]:
        raise ComponentError(
            f"'{use}' is of the kind {kind}, expected {KIND[family]}: derive it from {_BASE[KIND[family]]}"
        )
    return cls
