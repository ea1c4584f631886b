"""Cameras outside of robots look where their names say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crowdcosim.messages import RobotState
from crowdcosim.robots import Mount, Pose, Robot, RobotModel, Target
from crowdcosim.world import World
from orchestrator.errors import InputError
from orchestrator.pictures.cameras import DEFAULT_CAMERAS, Fixed, Following, Onboard, TopDown, named, subject, view_at

WORLD = World(size=(20.0, 10.0))
MODEL = RobotModel(
    radius=0.2,
    height=0.5,
    mass=20.0,
    max_speed=1.0,
    max_acceleration=5.0,
    max_angular_velocity=3.0,
    max_angular_acceleration=10.0,
    mounts={"camera": Mount(position=(0.1, 0.0, 0.4))},
)
ROBOTS = tuple(
    Robot(name=name, number=n, model=MODEL, start=Pose(x=1.0, y=1.0), goal=Target(x=9.0, y=1.0))
    for n, name in enumerate(("ada", "bob"), 1)
)
STATE = RobotState(name="ada", position=np.array((4.0, 6.0)), heading=0.5 * math.pi, radius=0.2)


def seen_at(view, point):
    """Column and row at which a point of the map is seen, from -1 to 1 across the picture, or None."""
    x, y, z = view.axes @ (np.array(point) - view.position)
    return None if z <= 0 else (2 * view.focal * x / z / view.width, 2 * view.focal * y / z / view.height)


def test_fixed_shows_the_whole_world_and_looks_at_its_middle():
    view = view_at(Fixed(view="fixed"), WORLD, None, None, 640, 480)
    np.testing.assert_allclose(seen_at(view, (10.0, 5.0, 0.0)), 0.0, atol=1e-9)
    for corner in ((0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)):
        assert np.abs(seen_at(view, (*corner, 0.0))).max() < 1.05


def test_following_looks_over_the_robot_from_behind():
    view = view_at(Following(view="following", distance=3.0, height=2.0), WORLD, ROBOTS[0], STATE, 640, 480)
    np.testing.assert_allclose(view.position, (4.0, 3.0, 2.0))
    column, row = seen_at(view, (4.0, 6.0, 0.0))
    assert column == pytest.approx(0.0, abs=1e-9) and 0.0 < row < 1.0


def test_top_down_has_the_map_upright():
    view = view_at(TopDown(view="top_down"), WORLD, None, None, 640, 480)
    right, up = seen_at(view, (15.0, 5.0, 0.0)), seen_at(view, (10.0, 8.0, 0.0))
    assert right[0] > 0.4 and up[1] < -0.2
    assert right[1] == pytest.approx(0.0, abs=1e-9) and up[0] == pytest.approx(0.0, abs=1e-9)


def test_the_robots_own_view_is_that_of_its_mount():
    view = view_at(Onboard(view="robot"), WORLD, ROBOTS[0], STATE, 640, 480)
    np.testing.assert_allclose(view.position, (4.0, 6.1, 0.4))
    np.testing.assert_allclose(view.axes[2], (0.0, 1.0, 0.0), atol=1e-12)


def test_a_camera_belongs_to_the_first_robot_unless_it_says_which():
    assert subject(DEFAULT_CAMERAS["following"], ROBOTS) is ROBOTS[0]
    assert subject(Following(view="following", robot="bob"), ROBOTS) is ROBOTS[1]
    assert subject(DEFAULT_CAMERAS["fixed"], ROBOTS) is None
    with pytest.raises(InputError, match="did you mean 'bob'"):
        subject(Following(view="following", robot="bop"), ROBOTS)
    with pytest.raises(InputError, match="the scenario has none"):
        subject(Following(view="following"), ())


def test_a_scenarios_cameras_come_before_those_of_every_scenario():
    own = Fixed(view="fixed", position=(0.0, 0.0, 1.0))
    assert named({"fixed": own}, "fixed") is own
    with pytest.raises(InputError, match="did you mean 'top_down'"):
        named({}, "topdown")
