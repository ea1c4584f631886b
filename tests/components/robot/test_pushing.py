"""Robot and crowd together: people who react are pushed, robots are stopped, and nobody walks through a robot."""

from __future__ import annotations

import numpy as np
import pytest

from components.crowd.crowd import CrowdModel
from components.robot.forces import Config, Forces
from components.robot.kinematic import Kinematic
from crowdcosim.component import make
from crowdcosim.messages import Contacts
from crowdcosim.robots import Pose
from crowdcosim.setup import Setup
from crowdcosim.world import World

WORLD = World(size=(12.0, 2.0), periodic=(True, True))
START = Pose(x=2.0, y=1.0)


def together(bodies, twist, turtlebot, drive, *, reactive, seconds=12.0):
    """A robot that drives straight at 0.8 m/s against 25 people in 24 m2: states, deepest overlaps [m], contacts."""
    crowd = make(CrowdModel, {"flow": "1d-", "count": 25, "policy": "social_force", "reactive": reactive})
    scene = bodies(START, world=WORLD, drive=drive)
    (robot,) = scene.robots
    people = crowd.reset(Setup(component="crowd", period=100_000_000, seed=3, world=WORLD, robots=(robot,)))
    states, overlaps, contacts = [], [], []
    for _ in range(round(seconds / 0.1)):
        (old,) = (result.state for result in scene.last)
        (result,) = scene.step(twist(0.8), crowd=people)
        people = crowd.step((old,))
        way = WORLD.displacement(result.state.position, people.position)
        overlaps.append((people.radius + turtlebot.radius - np.hypot(*way.T)).max())
        states.append(result.state)
        contacts.append(result.contacts)
    return states, np.array(overlaps), contacts


@pytest.mark.parametrize("drive", [Kinematic, lambda: Forces(Config())], ids=["kinematic", "forces"])
def test_people_who_react_are_pushed_out_of_the_way(bodies, twist, turtlebot, drive):
    _, pushed, contacts = together(bodies, twist, turtlebot, drive, reactive=True)
    _, blind, _ = together(bodies, twist, turtlebot, drive, reactive=False)
    assert any(Contacts.PERSON in c.kind for c in contacts)
    # Springs of 62.5 /s2 stop 1.3 m/s within v / omega = 0.16 m; the blind walk on into the robot's disc.
    assert pushed.max() < 0.16
    assert blind.max() > 0.25


def test_a_straight_driver_keeps_its_line_among_people_who_react_and_loses_time(bodies, twist, turtlebot):
    states, _, contacts = together(bodies, twist, turtlebot, Kinematic, reactive=True)
    assert {state.position[1] for state in states} == {1.0}
    assert 2.0 < states[-1].position[0] < 2.0 + 0.8 * 12.0 - 0.05
    for report in contacts:
        people = report.kind == Contacts.PERSON
        mu = 1.0 / (1.0 / report.reflected_mass[people] + 1.0 / turtlebot.mass)
        approach = np.maximum(report.approach_speed[people], 0.0)
        assert report.energy[people] == pytest.approx(0.5 * mu * approach**2)
        assert set(report.striker.tolist()) <= {
            Contacts.NEITHER,
            Contacts.BY_ROBOT,
            Contacts.BY_OTHER,
            Contacts.BY_BOTH,
        }
