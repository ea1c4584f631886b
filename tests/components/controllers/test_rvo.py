"""Reciprocal avoidance: the geometry of the cones, and how a differential drive follows it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.controllers.ego import Ego, ego_of
from components.controllers.rvo import RVO, Config, escape, nearest_discs
from components.controllers.surroundings import Discs, frozen
from crowdcosim.component import make, ports_of
from crowdcosim.messages import Crowd, Detections, Goal, Odometry, RobotState
from crowdcosim.world import Wall, World

SEED = st.integers(0, 2**32 - 1)
TAU = 1.5


def rvo(scene, world=None, dt=0.1, **options) -> RVO:
    controller = make(RVO, options)
    controller.reset(scene.setup(world, dt))
    return controller


def decide(controller, odometry, goal, crowd, others=()) -> tuple[float, float]:
    twist = controller.step(odometry=odometry, goal=goal, crowd=crowd, others=others)
    return twist.linear.x, twist.angular.z


def random_state(scene, seed, count=150):
    rng = np.random.default_rng(seed)
    x, y, v = rng.uniform([0.3, 0.3, 0.0], [49.7, 9.7, 1.0])
    theta, omega = rng.uniform(-math.pi, math.pi, 2)
    return scene.odometry(x, y, theta, v, omega), scene.random_crowd(seed, count)


def least_gap(p, v, contact, horizon) -> float:
    """Least distance within the horizon of centres p apart that close at relative velocity v, minus `contact`."""
    square = v @ v
    t = min(horizon, max(0.0, (p @ v) / square)) if square else 0.0
    return float(np.hypot(*(p - t * v)) - contact)


def test_its_inputs_are_truth_or_what_is_sensed():
    types = {port.name: (port.type, port.many) for port in ports_of(RVO).inputs}
    assert types == {
        "odometry": (Odometry, False),
        "goal": (Goal, False),
        "crowd": (Crowd, False),
        "others": (RobotState, True),
        "detections": (Detections, False),
    }


@settings(max_examples=300, deadline=None)
@given(seed=SEED)
def test_the_escape_is_the_least_change_to_the_brink_of_a_collision(seed):
    rng = np.random.default_rng(seed)
    contact = rng.uniform(0.2, 1.0)
    distance, bearing = contact * rng.uniform(1.05, 8.0), rng.uniform(-math.pi, math.pi)
    p, v = distance * np.array([math.cos(bearing), math.sin(bearing)]), rng.uniform(-2.0, 2.0, 2)
    ux, uy, nx, ny = escape(*p, *v, contact, TAU, 0.1)
    u, n = np.array([ux, uy]), np.array([nx, ny])
    assert np.hypot(*n) == pytest.approx(1.0, abs=1e-12)
    assert abs(least_gap(p, v + u, contact, TAU)) < 1e-9
    # Inside the cone u points out of it, outside into it.
    assert (least_gap(p, v, contact, TAU) < 0) == (u @ n > 0)
    for angle in np.linspace(-math.pi, math.pi, 40):
        less = v + 0.99 * np.hypot(*u) * np.array([math.cos(angle), math.sin(angle)])
        assert (least_gap(p, less, contact, TAU) < 0) == (u @ n > 0)


@given(bearing=st.floats(-math.pi, math.pi), depth=st.floats(1e-6, 0.5), vx=st.floats(-1, 1), vy=st.floats(-1, 1))
def test_bodies_that_overlap_part_within_one_period(bearing, depth, vx, vy):
    p = (0.5 - depth) * np.array([math.cos(bearing), math.sin(bearing)])
    ux, uy, *_ = escape(*p, vx, vy, 0.5, TAU, 0.1)
    assert math.hypot(*(p - 0.1 * np.array([vx + ux, vy + uy]))) == pytest.approx(0.5, abs=1e-12)


@settings(max_examples=100, deadline=None)
@given(seed=SEED, most=st.integers(0, 8), people=st.integers(0, 60))
def test_neighbours_are_the_nearest_in_order(scene, seed, most, people):
    crowd = scene.random_crowd(seed, 60)
    ego = Ego(*np.random.default_rng(seed).uniform([0, 0], [50, 10]).tolist(), 0.0, 0.0, 0.0)
    discs = Discs(crowd.position, crowd.velocity, crowd.radius, people)
    near, count = nearest_discs(ego, discs, frozen([50.0, 10.0]), most, 5.0)
    d = crowd.position - (ego.x, ego.y)
    d[:people] = scene.corridor.displacement(np.array([ego.x, ego.y]), crowd.position[:people])
    distance = np.hypot(*d.T)
    expected = [i for i in np.argsort(distance, kind="stable") if distance[i] <= 5.0][:most]
    assert near[:count].tolist() == expected


def test_of_neighbours_equally_far_the_first_comes_first(scene):
    crowd = scene.crowd((2.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (1.0, 0.0))
    discs = Discs(crowd.position, crowd.velocity, crowd.radius, 4)
    near, count = nearest_discs(Ego(0.0, 0.0, 0.0, 0.0, 0.0), discs, frozen([0.0, 0.0]), 3, 5.0)
    assert near[:count].tolist() == [1, 2, 3]


@settings(max_examples=50, deadline=None)
@given(theta=st.floats(-3.0, 3.0), v=st.floats(0, 1))
def test_without_people_it_drives_at_full_speed_to_the_goal(scene, theta, v):
    trace = scene.drive(
        rvo(scene, scene.open), scene.line(1e6), pose=(5.0, 5.0, theta), speed=v, seconds=6.0, crowd=scene.crowd()
    )
    # The heading error shrinks by 1 - 2 dt a period, and by pi a second at most: 3 exp(-2 * 5) is below 2e-4.
    assert trace[-1, 3] == pytest.approx(1.0, abs=1e-6)
    assert abs(math.remainder(trace[-1, 2], math.tau)) < 1e-3


def test_straight_ahead_without_people_the_command_is_exactly_one_and_zero(scene):
    assert decide(rvo(scene), scene.odometry(20.0, 5.0, 0.0, 1.0), scene.line(), scene.crowd()) == (1.0, 0.0)


def test_it_crosses_the_empty_corridor_in_forty_seconds(scene):
    trace = scene.drive(rvo(scene), scene.line(), crowd=scene.crowd(), until_x=45.0)
    assert trace[-1, 0] >= 45.0
    assert 39.0 <= 0.1 * (len(trace) - 1) <= 41.5


@settings(max_examples=25, deadline=None)
@given(bearing=st.floats(-math.pi, math.pi), distance=st.floats(0.4, 4.0), theta=st.floats(-math.pi, math.pi))
def test_it_enters_a_disc_wherever_it_lies(scene, bearing, distance, theta):
    goal = scene.disc(25.0 + distance * math.cos(bearing), 5.0 + distance * math.sin(bearing))
    trace = scene.drive(rvo(scene), goal, pose=(25.0, 5.0, theta), seconds=12.0, crowd=scene.crowd())
    assert math.dist(trace[-1, :2], goal.position) <= 0.3
    assert trace[-1, 3] == 0.0


@pytest.mark.parametrize("y", [4.6, 4.95, 5.0, 5.001, 5.2])
def test_a_person_who_stands_in_the_way_is_passed_without_contact(scene, y):
    trace = scene.drive(rvo(scene), scene.line(15.0), crowd=scene.crowd((9.0, y)), seconds=30.0, until_x=15.0)
    assert trace[-1, 0] >= 15.0
    assert np.hypot(*(trace[:, :2] - (9.0, y)).T).min() > 0.3 + scene.model.radius


def test_someone_who_comes_is_avoided_where_someone_who_leaves_is_not(scene):
    controller, state, goal = rvo(scene), scene.odometry(5.0, 5.0, 0.0, 1.0), scene.line()
    comes = decide(controller, state, goal, scene.crowd((7.0, 5.1), velocity=(-1.3, 0.0)))
    assert comes[0] < 1.0 or comes[1] < 0.0
    assert decide(controller, state, goal, scene.crowd((7.0, 5.1), velocity=(1.3, 0.0))) == (1.0, 0.0)


def test_its_share_of_the_avoidance_is_half_unless_the_other_stands(scene):
    goal, state = scene.line(), scene.odometry(5.0, 5.0, 0.0, 1.0)

    def turn(x, velocity, **options):
        return decide(rvo(scene, **options), state, goal, scene.crowd((x, 5.2), velocity=(velocity, 0.0)))[1]

    assert turn(8.0, -1.0, share=1.0) < turn(8.0, -1.0) < turn(8.0, -1.0, share=0.0) == 0.0
    assert turn(6.5, 0.0, share=1.0) == turn(6.5, 0.0) < 0.0


def test_it_never_backs_away_from_a_crowd_that_comes(scene):
    for seed in range(40):
        state, crowd = random_state(scene, seed)
        people = scene.crowd(*map(tuple, crowd.position), velocity=(-1.3, 0.0))
        v, omega = decide(rvo(scene), state, scene.line(), people)
        assert 0.0 <= v <= scene.model.max_speed
        # Nor does it turn round: what it turns to has no part against the way to the goal.
        target = ego_of(state).heading + omega / 2
        if abs(omega) < scene.model.max_angular_velocity and omega != 0.0:
            assert math.cos(target) >= -1e-9


@settings(max_examples=100, deadline=None)
@given(seed=SEED)
def test_its_speed_never_breaks_the_bound_of_a_wall(scene, seed):
    state, crowd = random_state(scene, seed)
    ego = ego_of(state)
    v, _ = decide(rvo(scene), state, scene.line(), crowd)
    gaps = np.array([ego.x, 50.0 - ego.x, ego.y, 10.0 - ego.y]) - scene.model.radius - 0.02
    closing = v * np.array([-1, 1, 0, 0]) * math.cos(ego.heading) + v * np.array([0, 0, -1, 1]) * math.sin(ego.heading)
    # Within one second the robot would not be through.
    assert (closing <= np.maximum(gaps, 0.0) + 1e-9).all()


@settings(max_examples=25, deadline=None)
@given(dt=st.sampled_from([0.02, 0.1, 0.25]), theta=st.floats(-1.2, 1.2), gap=st.floats(0.8, 3.0))
def test_it_never_touches_a_wall_that_bars_its_way(scene, dt, theta, gap):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(20.0, -50.0), end=(20.0, 60.0)),))
    start = 20.0 - scene.model.radius - gap
    trace = scene.drive(
        rvo(scene, world, dt), scene.line(), pose=(start, 5.0, theta), dt=dt, seconds=8.0, crowd=scene.crowd()
    )
    assert trace[:, 0].max() < 20.0 - scene.model.radius
    assert trace[:, 0].max() > 20.0 - scene.model.radius - 0.1


def test_a_mirrored_scene_gets_the_mirrored_command(scene):
    for seed in range(100):
        state, crowd = random_state(scene, seed)
        ego = ego_of(state)
        mirrored = scene.odometry(ego.x, 10.0 - ego.y, -ego.heading, ego.speed, -ego.turn_rate)
        people = scene.crowd(*map(tuple, crowd.position * (1, -1) + (0, 10)), velocity=crowd.velocity * (1, -1))
        v, omega = decide(rvo(scene), state, scene.line(), crowd)
        # Positions are mirrored to 1e-15 m; programs with edges at small angles magnify that.
        assert decide(rvo(scene), mirrored, scene.line(), people) == pytest.approx((v, -omega), abs=1e-7)


def test_other_robots_are_avoided_and_the_robot_itself_is_not(scene):
    state, goal = scene.odometry(5.0, 5.0, 0.0, 1.0), scene.line()
    assert decide(rvo(scene), state, goal, scene.crowd(), (scene.robot("robot", 5.0, 5.0),)) == (1.0, 0.0)
    other = decide(rvo(scene), state, goal, scene.crowd(), (scene.robot("other", 6.0, 5.1),))
    assert other == decide(rvo(scene), state, goal, scene.crowd((6.0, 5.1)))
    assert other != (1.0, 0.0)


def test_people_are_seen_across_the_seam_and_robots_are_not(scene):
    controller, goal = rvo(scene), scene.line()
    state = scene.odometry(20.0, 0.4, 0.0, 1.0)
    free = decide(controller, state, goal, scene.crowd())
    across = decide(controller, state, goal, scene.crowd((21.0, 9.99)))
    assert across == pytest.approx(decide(controller, state, goal, scene.crowd((21.0, -0.01))), abs=1e-9)
    assert across != free
    assert decide(controller, state, goal, scene.crowd(), (scene.robot("other", 21.0, 9.99),)) == free


def test_equal_inputs_give_equal_commands_in_every_episode(scene):
    controller = rvo(scene)

    def episode():
        controller.reset(scene.setup())
        return [decide(controller, o, scene.line(), c) for o, c in (random_state(scene, seed) for seed in range(20))]

    assert episode() == episode()


@given(seed=SEED)
@settings(max_examples=50, deadline=None)
def test_people_beyond_its_range_change_nothing(scene, seed):
    state, crowd = random_state(scene, seed)
    ego = ego_of(state)
    near = np.hypot(*scene.corridor.displacement(np.array([ego.x, ego.y]), crowd.position).T) <= 5.0
    assume(near.any())
    some = scene.crowd(*map(tuple, crowd.position[near]), velocity=crowd.velocity[near])
    controller = rvo(scene)
    assert decide(controller, state, scene.line(), crowd) == decide(controller, state, scene.line(), some)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("horizon", 0.0),
        ("wall_horizon", -1.0),
        ("range", math.nan),
        ("neighbours", -1),
        ("margin", -0.1),
        ("share", 1.2),
    ],
)
def test_options_that_mean_nothing_are_refused(option, value):
    with pytest.raises(ValueError, match=rf"{option} is .*, expected"):
        Config(**{option: value})
