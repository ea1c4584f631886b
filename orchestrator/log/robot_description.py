"""A robot's body as URDF, which RViz and Foxglove draw in its frame."""

from __future__ import annotations

from xml.etree import ElementTree as Xml

from crowdcosim.robots import Robot
from orchestrator.log.marker import Wire
from orchestrator.log.recorder import Channel, Record

TYPE = "std_msgs/msg/String"


def description_channel(robot: str) -> Channel:
    """The topic on which a robot describes itself."""
    return Channel(f"/{robot}/robot_description", TYPE, "", "robot_description", latched=True)


def description_record(robot: Robot) -> Record:
    """What the robot says at t = 0: a `std_msgs/String` with its URDF."""
    wire = Wire()
    wire.text(urdf(robot))
    return Record(description_channel(robot.name).topic, 0, wire.message())


def urdf(robot: Robot) -> str:
    """A cylinder with the robot's radius, height and mass, standing in the frame `ROBOT/base_link`."""
    model = robot.model
    root = Xml.Element("robot", name=robot.name)
    link = Xml.SubElement(root, "link", name=f"{robot.name}/base_link")
    for part in ("visual", "collision"):
        shape = Xml.SubElement(link, part)
        Xml.SubElement(shape, "origin", xyz=f"0 0 {0.5 * model.height!r}", rpy="0 0 0")
        geometry = Xml.SubElement(shape, "geometry")
        Xml.SubElement(geometry, "cylinder", radius=repr(model.radius), length=repr(model.height))
    inertial = Xml.SubElement(link, "inertial")
    Xml.SubElement(inertial, "origin", xyz=f"0 0 {0.5 * model.height!r}", rpy="0 0 0")
    Xml.SubElement(inertial, "mass", value=repr(model.mass))
    about_z = 0.5 * model.mass * model.radius**2
    across = model.mass * (3.0 * model.radius**2 + model.height**2) / 12.0
    axes = {"ixx": across, "iyy": across, "izz": about_z, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    Xml.SubElement(inertial, "inertia", {name: repr(value) for name, value in axes.items()})
    return Xml.tostring(root, encoding="unicode")
