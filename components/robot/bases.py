"""Which drive a robot's base has."""

from __future__ import annotations

import math

from components.robot.car import CarDrive
from components.robot.differential import DifferentialDrive
from components.robot.drive import Drive
from components.robot.holonomic import HolonomicDrive
from crowdcosim.robots import Robot

_DRIVES: dict[str, type[Drive]] = {"differential": DifferentialDrive, "holonomic": HolonomicDrive, "car": CarDrive}


def drive_at_start(robot: Robot) -> Drive:
    """The robot's drive at its start pose, at rest."""
    start = robot.start
    heading = math.remainder(start.heading, 2.0 * math.pi)
    return _DRIVES[robot.model.base.kind](model=robot.model, x=start.x, y=start.y, heading=heading)
