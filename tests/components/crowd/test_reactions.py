"""Each reaction to the robot does what it says, with any policy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.crowd.config import Config
from components.crowd.crowd import CrowdModel
from components.crowd.people import Population
from components.crowd.reactions import HIDDEN, MOVING, STILL, Curious, Reactions, face, step_aside
from crowdcosim.messages import RobotState
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World
from tests.components.crowd.crowds import scene

WORLD = World(size=(60.0, 10.0), periodic=(True, True))
SETUP = Setup(component="crowd", period=100_000_000, seed=1, world=WORLD)
POLICIES = ("orca", "social_force", "power_law", "rvo", "moussaid")
RADII = 0.18 + 0.3


def robot(x, y, vx=0.0, vy=0.0):
    return RobotState(name="robot", position=np.array([x, y]), velocity=np.array([vx, vy]), radius=0.18)


class Walk:
    """Somebody who walks along x from (10, 5), and a robot that begins at (20, 5.05)."""

    def __init__(self, reaction, policy="orca", *, robot_speed=0.0, steps=250, world=WORLD, **options):
        model = CrowdModel(
            Config(policy=policy, positions=((10.0, 5.0),), preferred_speed=1.3, reaction=reaction, **options)
        )
        self.states = [model.reset(replace(SETUP, world=world))]
        at = np.array([20.0, 5.05])
        self.gaps, self.bearings = [], []
        for _ in range(steps):
            self.states.append(model.step((robot(*at, robot_speed),)))
            at = at + 0.1 * robot_speed * np.array((1.0, 0.0))
            way = at - self.states[-1].position[0]
            self.gaps.append(np.hypot(*way) - RADII)
            self.bearings.append(math.atan2(way[1], way[0]))
        self.gaps = np.array(self.gaps)
        self.speeds = np.hypot(*np.array([state.velocity[0] for state in self.states]).T)
        self.end = self.states[-1].position[0]

    def seconds_near(self, gap):
        return 0.1 * np.count_nonzero(self.gaps < gap)


def test_none_walks_through_the_robot_to_the_last_bit():
    free = CrowdModel(Config(positions=((10.0, 5.0),), preferred_speed=1.3))
    expected = [free.reset(SETUP), *(free.step(()) for _ in range(250))]
    walk = Walk("none")
    assert walk.states == expected
    assert walk.gaps.min() < 0
    assert Walk("curious", reactive=False).states == expected


@pytest.mark.parametrize("policy", POLICIES)
def test_a_person_counts_on_the_robots_motion_and_a_static_disc_does_not(policy):
    # Both start at rest beside each other and walk the same way: who anticipates sees no danger.
    def drift(reaction):
        model = CrowdModel(Config(policy=policy, positions=((10.0, 5.0),), preferred_speed=1.3, reaction=reaction))
        state, x = model.reset(SETUP), 11.0
        for _ in range(60):
            state = model.step((robot(x, 5.05, 1.3),))
            x += 0.13
        return abs(state.position[0, 1] - 5.0)

    assert drift("static") > drift("person") + 0.05


def test_person_and_static_are_the_same_for_a_robot_at_rest():
    assert Walk("static").states == Walk("person").states


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("speed", [0.0, -0.8])
def test_the_cautious_keep_more_distance_and_slow_down(policy, speed):
    cautious, person = Walk("cautious", policy, robot_speed=speed), Walk("person", policy, robot_speed=speed)
    assert cautious.gaps.min() > person.gaps.min() + 0.3
    # At the least gap that any policy keeps, 0.5 m: (0.5 + 0.5 / 6) of the preferred speed; all have started by 3 s.
    assert cautious.speeds[30:120].min() < 0.9 * person.speeds[30:120].max()
    assert cautious.end[0] < person.end[0]


@pytest.mark.parametrize("policy", POLICIES)
def test_the_curious_come_near_stay_for_a_while_and_walk_on(policy):
    walk, person = Walk("curious", policy), Walk("person", policy)
    assert walk.seconds_near(1.5) > person.seconds_near(1.5) + 4.0
    standing = np.flatnonzero(walk.speeds[10:] < 0.05) + 10
    # Noticed at 5 m, 3.8 m at 1.3 m/s: some seven seconds are left of ten.
    assert 5.0 < 0.1 * len(standing) < 8.0
    # Who takes half a second to brake goes a little too far, and does not walk backwards.
    assert walk.gaps[standing - 1] == pytest.approx(1.2, abs=0.3)
    facing = walk.states[standing[-1]].heading[0]
    assert facing == pytest.approx(walk.bearings[standing[-1] - 1], abs=0.02)
    assert walk.end[0] > 30.0


def test_the_curious_are_so_only_once():
    law = Curious(name="curious", duration=2.0)
    model = CrowdModel(Config(positions=((10.0, 5.0),), preferred_speed=1.3, reaction=law))
    model.reset(SETUP)
    speed = []
    for k in range(200):
        # The robot backs off before the person.
        speed.append(np.hypot(*model.step((robot(13.0 + 0.12 * k, 5.05, 1.2),)).velocity[0]))
    assert model._state.attended[0] == pytest.approx(2.0)
    assert np.mean(speed[50:]) == pytest.approx(1.25, abs=0.1)


@pytest.mark.parametrize("policy", POLICIES)
def test_the_surprised_stop_and_look_and_walk_on(policy):
    walk = Walk("surprised", policy)
    standing = 0.1 * np.count_nonzero(walk.speeds[10:] < 0.1)
    # Three seconds, less what stopping takes (tau = 0.5 s).
    assert 1.5 < standing <= 3.1
    assert walk.end[0] > 35.0


@pytest.mark.parametrize("policy", POLICIES)
def test_the_threatening_stand_in_the_robots_way_and_walk_on(policy):
    walk, person = Walk("threatening", policy, robot_speed=-0.4), Walk("person", policy, robot_speed=-0.4)
    blocking = [
        abs(bearing) < math.radians(20) and gap < 1.2 for bearing, gap in zip(walk.bearings, walk.gaps, strict=True)
    ]
    meeting = [
        abs(bearing) < math.radians(20) and gap < 1.2 for bearing, gap in zip(person.bearings, person.gaps, strict=True)
    ]
    # Fifteen seconds, less the way there.
    assert 0.1 * sum(blocking) > 9.0
    assert 0.1 * sum(meeting) < 2.0
    assert walk.speeds[-1] == pytest.approx(1.3, abs=0.15)


def test_nobody_notices_a_robot_behind_a_wall_or_behind_the_back():
    wall = World(size=(60.0, 10.0), walls=(Wall(start=(12.0, 4.0), end=(12.0, 6.0)),))
    laws = Reactions(["surprised"], np.zeros(1, np.int64))
    for walls, x, expected in (((), 13.0, 0.0), (wall.segments, 13.0, 1.0), ((), 7.0, 1.0), ((), 16.0, 1.0)):
        now = scene([(10, 5)], preferred=[(1, 0)], robots=[(x, 5, 0, 0, 0.2)], walls=walls)
        assert laws.react(now, np.zeros(1), np.zeros(1)).preferred[0, 0] == expected


def test_every_population_has_a_reaction_of_its_own():
    populations = tuple(
        Population(name=name, share=1.0, reaction=name) for name in ("none", "person", "static", "surprised")
    )
    model = CrowdModel(Config(count=40, populations=populations))
    model.reset(SETUP)
    sight = model._reactions.react(model._scene, np.zeros(40), np.zeros(40)).sight
    assert np.bincount(sight).tolist() == [20, 10, 10]
    assert (~model._reactions.pushed).sum() == 10
    assert ((sight == HIDDEN) == ~model._reactions.pushed).all()
    assert {MOVING, STILL, HIDDEN} == set(sight)


# Laws.


@settings(deadline=None, max_examples=200)
@given(
    angle=st.floats(0, 2 * math.pi),
    bearing=st.floats(0.01, math.pi - 0.01),
    gap=st.floats(-0.2, 6.0),
    turn=st.floats(0, 2 * math.pi),
)
def test_stepping_aside_is_mirrored_turned_and_never_faster(angle, bearing, gap, turn):
    def aside(way, to):
        return np.array(step_aside(1.3 * math.cos(way), 1.3 * math.sin(way), math.cos(to), math.sin(to), gap, 3.0, 0.5))

    x, y = aside(0.0, bearing)
    assert np.hypot(x, y) <= 1.3 + 1e-12
    # The robot is on the left.
    assert y <= 0.0
    assert aside(0.0, -bearing) == pytest.approx((x, -y))
    rotated = (x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn))
    assert aside(turn, turn + bearing) == pytest.approx(rotated)
    if gap >= 3.0:
        assert (x, y) == pytest.approx((1.3, 0.0))


def test_who_stands_turns_at_a_limited_rate_and_the_short_way_round():
    velocity = np.array([(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 0.0)])
    heading = face(np.array([3.0, 0.0, 0.5, 0.5]), np.array([-3.0, 0.1, 2.0, np.nan]), velocity, 0.1)
    assert heading == pytest.approx([3.2 - 2 * math.pi, 0.1, 0.5, 0.5])
