"""The crowd as a component: flows, seams, robots, chance, messages."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from components.crowd.crowd import Config, CrowdModel
from crowdcosim.component import make, ports_of
from crowdcosim.message import check_finite
from crowdcosim.messages import Crowd, RobotState
from crowdcosim.robots import Pose, Robot, RobotModel, Target
from crowdcosim.setup import Setup, nanoseconds_of
from crowdcosim.world import Wall, World

PERIOD = 100_000_000
CORRIDOR = World(
    size=(50.0, 10.0),
    periodic=(True, True),
    walls=(
        Wall(start=(0.0, 0.0), end=(50.0, 0.0), stops_people=False),
        Wall(start=(0.0, 10.0), end=(50.0, 10.0), stops_people=False),
    ),
)
TURTLEBOT = RobotModel(
    radius=0.18,
    height=0.42,
    mass=20.0,
    max_speed=1.0,
    max_acceleration=5.0,
    max_angular_velocity=2.0,
    max_angular_acceleration=10.0,
)
SETUP = Setup(
    component="crowd",
    period=PERIOD,
    seed=1,
    world=CORRIDOR,
    robots=(Robot(name="robot", number=1, model=TURTLEBOT, start=Pose(x=5.0, y=5.0), goal=Target(x=45.0, y=5.0)),),
)
POLICIES = ("orca", "social_force", "power_law")
BELL = {"mean": 1.3, "deviation": 0.2, "limits": [0.8, 1.8]}


def robot(x, y, vx=0.0, vy=0.0):
    return RobotState(name="robot", position=np.array([x, y]), velocity=np.array([vx, vy]), radius=0.18)


def run(config, setup=SETUP, steps=30, robots=()):
    """All states, from t = 0 on."""
    model = CrowdModel(config)
    return [model.reset(setup), *(model.step(robots) for _ in range(steps))]


def difference(a, b, world=CORRIDOR):
    return np.abs(world.displacement(a, b)).max()


def test_it_moves_the_crowd_and_sees_all_robots():
    ports = ports_of(CrowdModel)
    assert ports.kind == "mover"
    assert [(p.name, p.type, p.many) for p in ports.inputs] == [("robots", RobotState, True)]
    assert [(p.name, p.type) for p in ports.outputs] == [("crowd", Crowd)]


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize(
    ("flow", "ways"),
    [
        ("1d+", {(1, 0): 40}),
        ("1d-", {(-1, 0): 40}),
        ("1dx", {(1, 0): 20, (-1, 0): 20}),
        ("2d", {(0, 1): 40}),
        ("2dx", {(0, 1): 20, (0, -1): 20}),
    ],
)
def test_people_walk_the_way_of_their_flow(flow, ways, policy):
    states = run(Config(policy=policy, count=40, flow=flow), steps=60)
    assert not states[0].velocity.any()
    facing = np.round(np.column_stack([np.cos(states[0].heading), np.sin(states[0].heading)])).astype(int)
    assert {tuple(w): n for w, n in zip(*np.unique(facing, axis=0, return_counts=True), strict=True)} == ways
    travelled = sum(CORRIDOR.displacement(a.position, b.position) for a, b in pairwise(states))
    # 6 s at 0.8 m/s at least, less a second for starting and dodging.
    assert ((travelled * facing).sum(axis=1) > 4.0).all()


@pytest.mark.parametrize("policy", POLICIES)
def test_counts_are_conserved_and_everything_stays_finite_in_a_dense_crossing(policy):
    states = run(Config(policy=policy, count=350, flow="2dx"), steps=100, robots=(robot(25.0, 5.0),))
    for state in states:
        check_finite(state)
        assert np.array_equal(state.id, np.arange(1, 351))
        assert (state.position >= 0).all()
        assert (state.position < CORRIDOR.size).all()
        assert ((state.gait_phase >= 0) & (state.gait_phase < 1)).all()
        assert np.abs(state.heading).max() <= np.pi


def test_time_advances_by_the_period_in_the_frame_of_the_map():
    states = run(Config(count=3), replace(SETUP, period=33_333_333), steps=40)
    assert [nanoseconds_of(s.header.stamp) for s in states] == [k * 33_333_333 for k in range(41)]
    assert {s.header.frame_id for s in states} == {"map"}


@pytest.mark.parametrize("policy", POLICIES)
def test_alone_means_that_nobody_is_there(policy):
    for state in run(Config(policy=policy, count=350), replace(SETUP, alone=True), robots=(robot(5.0, 5.0),)):
        assert len(state.id) == 0
        assert state.position.shape == (0, 2)
        assert state.gait_phase.shape == (0,)


@pytest.mark.parametrize("policy", POLICIES)
def test_the_same_seed_gives_the_same_bits_again_and_another_seed_others(policy):
    config = Config(policy=policy, count=200, flow="1dx")
    a, b = run(config, robots=(robot(5.0, 5.0, 1.0),)), run(config, robots=(robot(5.0, 5.0, 1.0),))
    assert a == b
    assert run(config, replace(SETUP, seed=2))[0] != a[0]


def test_a_second_episode_is_as_the_first():
    model = CrowdModel(Config(count=50))
    first = [model.reset(SETUP), *(model.step(()) for _ in range(5))]
    assert [model.reset(SETUP), *(model.step(()) for _ in range(5))] == first


def test_states_are_not_changed_by_later_steps():
    model = CrowdModel(Config(count=50))
    first = model.reset(SETUP)
    copy = first.position.copy()
    model.step(())
    assert np.array_equal(first.position, copy)
    assert not first.position.flags.writeable


@pytest.mark.parametrize("policy", POLICIES)
def test_people_who_do_not_react_ignore_robots_to_the_last_bit(policy):
    config = Config(policy=policy, count=100, flow="1d-", reactive=False)
    assert run(config, robots=(robot(25.0, 5.0, 1.0),)) == run(config)


@pytest.mark.parametrize("policy", POLICIES)
def test_people_who_react_walk_round_a_robot(policy):
    frozen = {"positions": ((10.0, 5.0),), "flow": "1d+", "policy": policy}
    obstacle = (robot(16.0, 4.9),)
    blind = run(Config(**frozen, reactive=False), steps=70, robots=obstacle)
    seeing = run(Config(**frozen, reactive=True), steps=70, robots=obstacle)

    def least_distance(states):
        return min(np.hypot(*(s.position[0] - (16.0, 4.9))) for s in states)

    assert least_distance(blind) < 0.2
    assert least_distance(seeing) > 0.3
    assert blind[-1].position[0, 1] == 5.0


def test_given_positions_change_nothing_but_where_they_come_from():
    drawn = run(Config(count=100, flow="2dx"))
    frozen = tuple((float(x), float(y)) for x, y in drawn[0].position)
    assert run(Config(positions=frozen, flow="2dx")) == drawn


@pytest.mark.parametrize("policy", POLICIES)
@settings(deadline=None, max_examples=15)
@given(shift=st.tuples(st.floats(-60, 60), st.floats(-60, 60)), seed=st.integers(0, 2**32 - 1))
def test_it_does_not_matter_where_the_seam_is(policy, shift, seed):
    setup = replace(SETUP, seed=seed, robots=())
    config = Config(policy=policy, count=60, flow="2dx")
    straight = run(config, setup, steps=10, robots=(robot(20.0, 5.0, 1.0),))
    moved = CORRIDOR.wrap(straight[0].position + shift)
    x, y = CORRIDOR.wrap(np.array([20.0, 5.0]) + shift)
    shifted = run(
        Config(policy=policy, positions=tuple(map(tuple, moved.tolist())), flow="2dx"),
        setup,
        steps=10,
        robots=(robot(x, y, 1.0),),
    )
    # Coordinates of up to 50 m carry 7e-15 m; the flow may amplify that by some powers of ten in a second.
    assert difference(straight[-1].position + shift, shifted[-1].position) < 1e-9


@pytest.mark.parametrize("policy", POLICIES)
def test_a_mirrored_crowd_walks_mirrored_ways(policy):
    setup = replace(SETUP, robots=())
    # Nobody is exactly head on, where ORCA passes on the right by convention.
    a = run(Config(policy=policy, count=60, flow="2d"), setup, steps=10)
    mirrored = CORRIDOR.wrap(np.column_stack([-a[0].position[:, 0], a[0].position[:, 1]]))
    b = run(Config(policy=policy, positions=tuple(map(tuple, mirrored.tolist())), flow="2d"), setup, steps=10)
    assert difference(b[-1].position * (-1, 1), a[-1].position) < 1e-9


@pytest.mark.parametrize("policy", POLICIES)
def test_walls_that_stop_people_stop_a_crowd_that_pushes(policy):
    world = World(
        size=(10.0, 10.0),
        periodic=(True, False),
        walls=(Wall(start=(0.0, 10.0), end=(10.0, 10.0)), Wall(start=(0.0, 0.0), end=(10.0, 0.0))),
    )
    states = run(Config(policy=policy, count=60, flow="2d"), replace(SETUP, world=world), steps=200)
    assert max(s.position[:, 1].max() for s in states) < 10.0
    assert states[-1].position[:, 1].min() > 5.0


@pytest.mark.parametrize("policy", POLICIES)
def test_dense_flows_overlap_by_no_more_than_contacts_give_way(policy):
    states = run(Config(policy=policy, count=350, flow="1d+"), steps=100)
    for state in states[20:]:
        d = CORRIDOR.displacement(state.position[:, None], state.position[None, :])
        distance = np.hypot(d[..., 0], d[..., 1])
        np.fill_diagonal(distance, 1.0)
        # A step at most closes the gap by the greatest difference of preferred speeds, 1 m/s, times dt.
        assert distance.min() > 0.6 - 0.1


def test_whoever_is_free_walks_at_the_preferred_speed():
    states = run(Config(positions=((1.0, 5.0),), preferred_speed=1.3), replace(SETUP, robots=()), steps=30)
    assert states[-1].velocity == pytest.approx(np.array([(1.3, 0.0)]))
    # 5 m/s2 up to 1.3 m/s: 0.5, 1.0, 1.3, and so on.
    assert [s.velocity[0, 0] for s in states[:4]] == pytest.approx([0.0, 0.5, 1.0, 1.3])


def test_nobody_starts_on_a_robot():
    start = run(Config(count=350), steps=0)[0]
    assert np.hypot(*CORRIDOR.displacement(np.array([5.0, 5.0]), start.position).T).min() >= 0.48


def test_no_room_is_an_error():
    with pytest.raises(ValueError, match="no room for person"):
        CrowdModel(Config(count=2000)).reset(SETUP)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "none of count, positions and journeys given"),
        ({"count": 3, "positions": [[1, 1]]}, "count and positions given"),
        ({"count": -1}, "count is -1, expected zero or more"),
        ({"count": 3, "time_horizon": 0}, "time_horizon is 0.0, expected a positive number"),
        ({"count": 3, "radius": -0.3}, "radius is -0.3"),
        ({"count": 3, "radius": {"uniform": [-0.1, 0.3]}}, "radius may be -0.1, expected a positive number"),
        ({"count": 3, "radius": {"uniform": [0.4, 0.3]}}, "ascending order"),
        ({"count": 3, "radius": []}, "radius is an empty list"),
        ({"count": 3, "max_speed": 1.5}, r"preferred_speed may be 1.8, expected at most max_speed \(1.5\)"),
        ({"count": 3, "preferred_speed": {"normal": BELL | {"limits": [1.8, 0.8]}}}, "ascending order"),
        ({"count": 3, "preferred_speed": {"normal": BELL | {"mean": 2.0}}}, "mean is 2.0"),
        ({"count": 3, "preferred_speed": {"normal": BELL | {"deviation": -1}}}, "deviation is -1.0"),
        ({"count": 3, "groups": [0.0]}, r"groups is \[0.0\]"),
        ({"positions": [[1, 1], [2, 2]], "groups": [1, 1]}, "walks alone"),
        ({"count": 3, "populations": [{"name": "a", "share": 0}]}, "share is 0.0, expected a positive number"),
        ({"count": 3, "populations": [{"name": "a", "share": 1, "max_speed": 1.0}]}, "'a': preferred_speed may be 1.8"),
        ({"count": 3, "populations": [{"name": "a", "share": 1}, {"name": "a", "share": 2}]}, "'a' is there twice"),
        ({"count": 3, "reaction": "scared"}, "reaction"),
        ({"count": 3, "reaction": {"name": "curious", "duration": 0}}, "duration is 0.0"),
        ({"count": 3, "policy": "orka"}, "policy"),
        ({"count": 3, "flow": "3d"}, "flow"),
        ({"count": 3, "speed": 1.0}, "speed"),
    ],
)
def test_options_that_make_no_sense_are_refused(options, message):
    with pytest.raises(ValidationError, match=message):
        make(CrowdModel, options)


def test_options_may_be_whole_numbers():
    model = make(CrowdModel, {"positions": [[1, 2], [3, 4]], "max_speed": 2, "time_horizon": 1, "max_acceleration": 5})
    assert model.reset(SETUP).position.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    whole = CrowdModel(Config(count=3, radius=1, max_speed=2, time_horizon=1, max_acceleration=5))
    whole.reset(SETUP)
    check_finite(whole.step((robot(5.0, 5.0),)))
