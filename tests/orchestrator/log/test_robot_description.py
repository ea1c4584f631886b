"""A robot's URDF has its shape, its mass and the inertia of a cylinder."""

from xml.etree import ElementTree as Xml

import pytest
from rosbags.typesys import Stores, get_typestore

from orchestrator.log.robot_description import TYPE, description_record, urdf
from orchestrator.stimuli import ROBOT


def test_the_body_is_a_cylinder_that_stands_in_the_base_frame() -> None:
    (link,) = Xml.fromstring(urdf(ROBOT)).findall("link")
    assert link.get("name") == "robot/base_link"
    for part in ("visual", "collision"):
        cylinder = link.find(f"{part}/geometry/cylinder")
        assert cylinder is not None
        assert (float(cylinder.get("radius", 0)), float(cylinder.get("length", 0))) == (0.177, 0.42)
    inertia = link.find("inertial/inertia")
    assert inertia is not None
    assert float(inertia.get("izz", 0)) == pytest.approx(0.5 * 20.0 * 0.177**2)
    assert inertia.get("ixx") == inertia.get("iyy")


def test_it_is_a_string_message_of_ros_2() -> None:
    message = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(description_record(ROBOT).payload, TYPE)
    assert message.data == urdf(ROBOT)
