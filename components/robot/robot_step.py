"""What every drive says at the end of a step, and into how many inner steps it cuts one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from components.robot.drive import Drive
from crowdcosim.messages import Contacts, Header, RobotState
from crowdcosim.robots import Robot

INNER_STEPS = 10
"""a step of the scenario is so many steps of a drive"""


class RobotStep(NamedTuple):
    """What a robot's body says at the end of a step."""

    state: RobotState
    contacts: Contacts


def robot_state(robot: Robot, drive: Drive, header: Header) -> RobotState:
    """Where `drive` has taken `robot`, and how it moves."""
    return RobotState(
        header=header,
        name=robot.name,
        position=np.array((drive.x, drive.y)),
        heading=drive.heading,
        velocity=np.array(drive.velocity),
        angular_velocity=drive.turn_rate,
        radius=robot.model.radius,
    )
