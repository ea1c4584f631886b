"""What is said about a contact: part, energy, duration."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.robot.body_part import REFLECTED_MASS, TouchedPart
from components.robot.contact import impact_energy, part_of_rim
from crowdcosim.message import check_finite
from crowdcosim.messages import Contacts
from crowdcosim.robots import Pose
from crowdcosim.world import Wall, World


@pytest.mark.parametrize(
    ("part", "reduced"), [(Contacts.FEET, 3.33), (Contacts.LOWER_LEGS, 7.88), (Contacts.UPPER_LEGS, 10.91)]
)
def test_energy_is_that_of_the_published_reduced_masses(part, reduced):
    # The published masses have two decimals.
    assert 2.0 * impact_energy(1.0, REFLECTED_MASS[part], 20.0) == pytest.approx(reduced, abs=0.005)


def test_energy_against_a_wall_is_the_robots_own():
    assert impact_energy(0.5, 0.0, 20.0) == 2.5


@given(speed=st.floats(-5, 0), mass=st.floats(0, 100))
def test_receding_bodies_have_no_impact_energy(speed, mass):
    assert impact_energy(speed, mass, 20.0) == 0.0


@given(speed=st.floats(0.01, 5), mass=st.floats(0.1, 100), robot=st.floats(0.1, 100), by_robot=st.floats(0, 1))
def test_energy_is_what_a_perfectly_plastic_impact_loses(speed, mass, robot, by_robot):
    """Momentum is kept; the kinetic energy that is lost does not depend on who of the two moves."""
    v_robot, v_other = by_robot * speed, -(1 - by_robot) * speed
    common = (robot * v_robot + mass * v_other) / (robot + mass)
    lost = 0.5 * (robot * v_robot**2 + mass * v_other**2 - (robot + mass) * common**2)
    # Absolute: cancellation in the difference of the energies, which are at most 2500 J.
    assert impact_energy(speed, mass, robot) == pytest.approx(lost, rel=1e-9, abs=1e-11)


def touched(people, height, x, y, heading=0.0, speed=0.0, phase=0.0):
    """The part that a robot at (x, y) touches of somebody of 1.75 m at the origin."""
    crowd = dataclasses.replace(
        people((0.0, 0.0, speed * np.cos(heading), speed * np.sin(heading))), heading=[heading], gait_phase=[phase]
    )
    return TouchedPart(height)(crowd, 0, np.array([-x, -y]))


@pytest.mark.parametrize(
    ("height", "x", "y", "part"),
    [
        (0.42, 0.477, 0.0, Contacts.FEET),  # a TurtleBot2 meets the toes,
        (0.42, -0.477, 0.0, Contacts.FEET),  # from behind the heels,
        (0.42, 0.0, 0.477, Contacts.LOWER_LEGS),  # and beside the calves, which are thicker than feet;
        (0.05, 0.0, 0.477, Contacts.FEET),  # a lower robot does not reach them,
        (0.60, 0.0, 0.477, Contacts.UPPER_LEGS),  # a higher one meets the thighs,
        (1.21, 0.0, 0.477, Contacts.UPPER_BODY),  # and Pepper an arm;
        (0.01, 0.477, 0.0, Contacts.FEET),  # the axis of a foot is above that
    ],
)
def test_a_person_who_stands_is_touched_where_they_are_nearest(people, height, x, y, part):
    assert touched(people, height, x, y) == part
    assert touched(people, height, -y, x, heading=np.pi / 2) == part


def test_a_turtlebot_touches_feet_and_lower_legs_only(people):
    """0.42 m is below the knees' height, and hands hang above it."""
    parts = {
        touched(people, 0.42, 0.477 * np.cos(way), 0.477 * np.sin(way), speed=1.3, phase=phase)
        for way in np.linspace(0, 2 * np.pi, 16, endpoint=False)
        for phase in np.linspace(0, 1, 20, endpoint=False)
    }
    assert parts == {Contacts.FEET, Contacts.LOWER_LEGS}


def test_the_foot_that_reaches_out_is_touched_first(people):
    """A landing foot is ahead, toes up, while the other one is left behind."""
    assert touched(people, 0.42, 0.6, 0.05, speed=1.3) == Contacts.FEET
    assert touched(people, 0.42, -0.6, -0.05, speed=1.3) == Contacts.FEET


def test_head_on_contact_is_reported_in_full(bodies, twist, people):
    """1 m/s against 0.5 m/s: they close at 1.5 m/s, which at 3.33 kg are 3.75 J: heels come first."""
    scene = bodies(Pose(x=3.0, y=4.0))
    x = 5.0
    for _ in range(100):
        contacts = scene.step(twist(1.0), crowd=people((x, 4.0, -0.5, 0.0)))[0].contacts
        x -= 0.05
        if len(contacts.kind):
            break
    check_finite(contacts)
    assert contacts.kind.tolist() == [Contacts.PERSON]
    assert contacts.agent.tolist() == [101]
    assert contacts.body_part.tolist() == [Contacts.FEET]
    assert contacts.reflected_mass.tolist() == [4.0]
    assert contacts.robot_part.tolist() == [Contacts.FRONT]
    assert contacts.striker.tolist() == [Contacts.BY_BOTH]
    assert contacts.relative_velocity[0] == pytest.approx([-1.5, 0.0], abs=1e-12)
    assert contacts.robot_closing_speed == pytest.approx([1.0], abs=1e-12)
    assert contacts.approach_speed == pytest.approx([1.5], abs=1e-12)
    assert contacts.energy == pytest.approx([0.5 / (1 / 4 + 1 / 20) * 1.5**2], rel=1e-12)
    assert contacts.normal[0] == pytest.approx([1.0, 0.0], abs=1e-12)
    assert contacts.position[0] == pytest.approx([scene.last[0].state.position[0] + 0.177, 4.0], abs=1e-12)
    assert contacts.duration.tolist() == [0.0]


@pytest.mark.parametrize(
    ("speed", "person", "part", "striker", "mine"),
    [
        (1.0, (4.0, 4.0, 0.0, 0.0), Contacts.FRONT, Contacts.BY_ROBOT, 1.0),
        (1.0, (4.0, 4.0, 0.5, 0.0), Contacts.FRONT, Contacts.BY_ROBOT, 1.0),  # it catches up with somebody
        (0.0, (3.5, 4.0, -1.0, 0.0), Contacts.FRONT, Contacts.BY_OTHER, 0.0),
        (0.0, (2.5, 4.0, 1.0, 0.0), Contacts.REAR, Contacts.BY_OTHER, 0.0),
        (0.2, (2.5, 4.0, 1.0, 0.0), Contacts.REAR, Contacts.BY_OTHER, -0.2),  # it is caught up with
        (0.0, (3.0, 4.5, 0.0, -1.0), Contacts.LEFT, Contacts.BY_OTHER, 0.0),
        (0.0, (3.0, 3.5, 0.0, 1.0), Contacts.RIGHT, Contacts.BY_OTHER, 0.0),
        (0.0, (3.4, 4.0, 1.0, 0.0), Contacts.FRONT, Contacts.NEITHER, 0.0),  # they overlap, and somebody leaves
    ],
)
def test_who_ran_into_whom_is_told(bodies, twist, people, speed, person, part, striker, mine):
    scene = bodies(Pose(x=3.0, y=4.0))
    for _ in range(8):
        scene.step(twist(speed), crowd=people())  # up to speed, away from everybody
    x, y, vx, vy = person
    x += scene.last[0].state.position[0] - 3.0
    for _ in range(20):
        contacts = scene.step(twist(speed), crowd=people((x, y, vx, vy)))[0].contacts
        x, y = x + 0.1 * vx, y + 0.1 * vy
        if len(contacts.kind):
            break
    assert (contacts.robot_part.tolist(), contacts.striker.tolist()) == ([part], [striker])
    assert contacts.robot_closing_speed == pytest.approx([mine], abs=1e-12)
    assert contacts.approach_speed == pytest.approx([mine - contacts.normal[0] @ (vx, vy)], abs=1e-12)


@given(heading=st.floats(-np.pi, np.pi), bearing=st.floats(-np.pi, np.pi))
def test_the_quarter_of_the_rim_is_seen_from_the_robot(heading, bearing):
    part = part_of_rim((np.cos(heading + bearing), np.sin(heading + bearing)), heading)
    nearest = np.argmax([np.cos(bearing - middle) for middle in np.pi / 2 * np.arange(4)])
    if abs(abs(bearing) % (np.pi / 2) - np.pi / 4) > 1e-9:
        assert part == (Contacts.FRONT, Contacts.LEFT, Contacts.REAR, Contacts.RIGHT)[nearest]


def test_a_lasting_contact_keeps_how_it_began_and_grows_older(bodies, twist, people):
    scene = bodies(Pose(x=3.0, y=4.0))
    crowd = people((4.0, 4.0, 0.0, 0.0))
    seen = [c for c in (scene.step(twist(1.0), crowd=crowd)[0].contacts for _ in range(20)) if len(c.kind)]
    assert len(seen) > 10
    assert np.concatenate([c.duration for c in seen]) == pytest.approx(0.1 * np.arange(len(seen)), abs=1e-12)
    for contacts in seen:
        assert contacts.approach_speed == pytest.approx([1.0], abs=1e-12)
        assert contacts.energy == seen[0].energy


def test_a_contact_that_ended_begins_anew(bodies, twist, people):
    scene = bodies(Pose(x=3.0, y=4.0))
    near, far = people((3.4, 4.0, 0.0, 0.0)), people((9.0, 4.0, 0.0, 0.0))
    ages = [scene.step(twist(), crowd=crowd)[0].contacts.duration for crowd in (near, near, far, near)]
    assert [age.tolist() for age in ages] == [[0.0], [0.1], [], [0.0]]


def test_following_at_somebodys_heels_is_one_contact(bodies, twist, people):
    """The robot stops at each touch and catches up again at once; that is not a new collision every time."""
    scene = bodies(Pose(x=3.0, y=4.0))
    x, beginnings = 3.6, 0
    for _ in range(50):
        contacts = scene.step(twist(1.0), crowd=people((x, 4.0, 0.1, 0.0)))[0].contacts
        beginnings += int(np.count_nonzero(contacts.duration == 0.0))
        x += 0.01
    assert beginnings == 1


def test_wall_contact_names_the_wall(bodies, twist):
    walls = (Wall(start=(0.0, 9.0), end=(9.0, 9.0)), Wall(start=(4.0, 0.0), end=(4.0, 9.0)))
    scene = bodies(Pose(x=3.0, y=4.0), world=World(size=(50.0, 10.0), walls=walls))
    for _ in range(15):
        state, contacts = scene.step(twist(1.0))[0]
    assert (contacts.kind.tolist(), contacts.agent.tolist()) == ([Contacts.WALL], [2])
    assert (contacts.body_part.tolist(), contacts.reflected_mass.tolist()) == ([Contacts.NO_PART], [0.0])
    assert contacts.energy == pytest.approx([0.5 * 20.0 * 1.0**2], rel=1e-12)
    assert contacts.position[0] == pytest.approx([4.0, 4.0], abs=1e-3)  # what counts as touching
    assert state.velocity.tolist() == [0.0, 0.0]


def test_contacts_come_by_kind_and_agent(bodies, twist, people):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(0.0, 3.83), end=(9.0, 3.83)),))
    scene = bodies(Pose(x=3.0, y=4.0), Pose(x=3.353, y=4.0), world=world)
    contacts = scene.step(twist(), twist(), crowd=people((3.0, 4.4, 0, 0), (2.6, 4.0, 0, 0)))[0].contacts
    assert contacts.kind.tolist() == [Contacts.WALL, Contacts.PERSON, Contacts.PERSON, Contacts.ROBOT]
    assert contacts.agent.tolist() == [1, 101, 102, 2]
    assert contacts.reflected_mass.tolist() == [0.0, 13.0, 4.0, 20.0]  # beside one, before the other
