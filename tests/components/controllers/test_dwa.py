"""The dynamic window approach: what it may choose, what it chooses, and where that leads."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.controllers.arc import clearance, obstacles_near
from components.controllers.dwa import DWA, Config, heading, sample, window
from components.controllers.ego import Ego, Way, ego_of
from components.controllers.surroundings import discs_of, frozen
from crowdcosim.component import make, ports_of
from crowdcosim.messages import Crowd, Detections, Goal, LaserScan, Odometry, RobotState
from crowdcosim.world import Wall, World

INFLATION = 0.05
SEED = st.integers(0, 2**32 - 1)


def dwa(scene, world=None, dt=0.1, **options) -> DWA:
    controller = make(DWA, options)
    controller.reset(scene.setup(world, dt))
    return controller


def decide(controller, odometry, goal, crowd, others=()) -> tuple[float, float]:
    twist = controller.step(odometry=odometry, goal=goal, crowd=crowd, others=others)
    return twist.linear.x, twist.angular.z


def random_state(scene, seed):
    """A robot somewhere in the corridor, among 150 people."""
    rng = np.random.default_rng(seed)
    x, y, v = rng.uniform([0.3, 0.3, 0.0], [49.7, 9.7, 1.0])
    theta, omega = rng.uniform(-math.pi, math.pi, 2)
    return scene.odometry(x, y, theta, v, omega), scene.random_crowd(seed, 150)


def test_its_inputs_are_truth_or_what_is_sensed():
    types = {port.name: (port.type, port.many) for port in ports_of(DWA).inputs}
    assert types == {
        "odometry": (Odometry, False),
        "goal": (Goal, False),
        "crowd": (Crowd, False),
        "others": (RobotState, True),
        "detections": (Detections, False),
        "scan": (LaserScan, False),
    }


@settings(max_examples=200, deadline=None)
@given(seed=SEED)
def test_it_never_picks_an_inadmissible_velocity(scene, seed):
    odometry, crowd = random_state(scene, seed)
    setup = scene.setup()
    v, omega = decide(dwa(scene), odometry, scene.line(), crowd)
    ego = ego_of(odometry)
    discs = discs_of(crowd, (), "robot")
    walls, period = frozen(setup.world.segments), frozen(setup.world.period)
    obstacles = obstacles_near(ego, discs, walls, period, scene.model.radius + INFLATION, 20.0)
    slowest = max(0.0, ego.speed - 0.5)
    if v > slowest:
        # 2 m/s2, 0.4 of the robot's braking, after one period at v.
        assert 2.0 * 2.0 * (clearance(omega / v, obstacles) - 0.1 * v) >= v * v * (1 - 1e-12)


@settings(max_examples=200, deadline=None)
@given(seed=SEED)
def test_it_stays_within_the_dynamic_window_and_the_limits(scene, seed):
    odometry, crowd = random_state(scene, seed)
    v, omega = decide(dwa(scene), odometry, scene.line(), crowd)
    ego = ego_of(odometry)
    assert abs(v - ego.speed) <= 5.0 * 0.1 + 1e-12
    assert abs(omega - ego.turn_rate) <= 10.0 * 0.1 + 1e-12
    assert 0.0 <= v <= scene.model.max_speed
    assert abs(omega) <= scene.model.max_angular_velocity


@given(now=st.floats(-5, 5), change=st.floats(0, 2))
def test_the_window_lies_within_the_limits_and_reaches_as_far_as_the_robot_can(now, change):
    lowest, highest = window(now, change, -1.0, 2.0)
    assert -1.0 <= lowest <= highest <= 2.0
    if -1.0 <= now <= 2.0:
        assert (lowest, highest) == (max(-1.0, now - change), min(2.0, now + change))


@given(first=st.floats(-5, 5), width=st.floats(0, 5), count=st.integers(2, 40))
def test_samples_run_from_end_to_end_exactly(first, width, count):
    values = [sample(first, first + width, i, count) for i in range(count)]
    assert (values[0], values[-1]) == (first, first + width)
    # Half an ulp of either product.
    assert all(b - a >= -4e-15 for a, b in pairwise(values))


def test_the_heading_term_looks_at_where_the_robot_will_have_turned(scene):
    controller = dwa(scene)
    ego = Ego(0.0, 0.0, 0.2, 1.0, 0.0)
    # 1 rad/s for 0.1 s, and 0.05 rad more while it brakes at 10 rad/s2: 0.35 rad off the goal's line.
    far = heading(ego, Way(1.0, 0.0, 0.0), 1.0, 1.0, controller._search)
    assert far == pytest.approx(1 - 0.35 / math.pi, abs=1e-14)
    # Straight on for 0.1 m and 0.1 m of braking, past a goal abreast of the way's middle: 135 degrees off.
    near = heading(Ego(0.0, 0.0, 0.0, 1.0, 0.0), Way(0.1, 0.1, 1.0), 1.0, 0.0, controller._search)
    assert near == pytest.approx(0.25, abs=1e-14)
    # Turned by 0.3 rad after 0.2 m, whose chord lies at 0.15 rad: a goal farther along the chord is 0.15 rad off.
    goal = Way(math.cos(0.15), math.sin(0.15), 1.0)
    omega = math.sqrt(1.0 + 2 * 10.0 * 0.3) - 1.0
    turning = heading(Ego(0.0, 0.0, 0.0, 1.0, 0.0), goal, 1.0, omega, controller._search)
    assert turning == pytest.approx(1 - 0.15 / math.pi, abs=1e-14)


def test_a_robot_that_cannot_change_its_turn_rate_has_a_heading_too(scene):
    search = dwa(scene)._search._replace(max_angular_acceleration=0.0)
    assert heading(Ego(0.0, 0.0, 0.0, 1.0, 0.0), Way(1.0, 0.0, 0.0), 1.0, 0.0, search) == 1.0


@settings(max_examples=30, deadline=None)
@given(theta=st.floats(-math.pi, math.pi), v=st.floats(0, 1))
def test_in_a_free_field_it_converges_to_full_speed_at_the_goal(scene, theta, v):
    trace = scene.drive(
        dwa(scene, scene.open), scene.line(1e6), pose=(5.0, 5.0, theta), speed=v, seconds=6.0, crowd=scene.crowd()
    )
    assert trace[-1, 3] == 1.0
    # Turn rates come in steps of a thirtieth of the window, 2 rad/s wide: the last error that is worth a step, which
    # turns the robot by 0.1 s of it, is half of that.
    assert abs(math.remainder(trace[-1, 2], math.tau)) < 0.5 * 0.1 * 2.0 / 30 + 1e-3


def test_it_crosses_the_empty_corridor_in_forty_seconds(scene):
    trace = scene.drive(dwa(scene), scene.line(), crowd=scene.crowd(), until_x=45.0)
    assert trace[-1, 0] >= 45.0
    assert 39.0 <= 0.1 * (len(trace) - 1) <= 41.5


@settings(max_examples=25, deadline=None)
@given(bearing=st.floats(-math.pi, math.pi), distance=st.floats(0.4, 4.0), theta=st.floats(-math.pi, math.pi))
def test_it_enters_a_disc_wherever_it_lies(scene, bearing, distance, theta):
    goal = scene.disc(25.0 + distance * math.cos(bearing), 5.0 + distance * math.sin(bearing))
    trace = scene.drive(dwa(scene), goal, pose=(25.0, 5.0, theta), seconds=12.0, crowd=scene.crowd())
    assert math.dist(trace[-1, :2], goal.position) <= 0.3
    assert trace[-1, 3] == 0.0


@settings(max_examples=40, deadline=None)
@given(
    dt=st.sampled_from([0.02, 0.1, 0.25, 0.5]),
    theta=st.floats(-1.2, 1.2),
    gap=st.floats(0.8, 4.0),
    v=st.floats(0.0, 1.0),
)
def test_it_stops_before_a_wall_whatever_its_period(scene, dt, theta, gap, v):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(20.0, -50.0), end=(20.0, 60.0)),))
    start = 20.0 - scene.model.radius - gap
    trace = scene.drive(
        dwa(scene, world, dt), scene.line(), pose=(start, 5.0, theta), speed=v, dt=dt, seconds=8.0, crowd=scene.crowd()
    )
    assert trace[:, 0].max() < 20.0 - scene.model.radius
    # It does come near, rather than stop at once.
    assert trace[:, 0].max() > 20.0 - scene.model.radius - 0.5


@pytest.mark.parametrize("y", [4.4, 4.9, 5.0, 5.3])
def test_it_drives_around_a_person_who_stands_in_its_way(scene, y):
    trace = scene.drive(dwa(scene), scene.line(15.0), crowd=scene.crowd((9.0, y)), seconds=20.0, until_x=15.0)
    assert trace[-1, 0] >= 15.0
    assert np.hypot(*(trace[:, :2] - (9.0, y)).T).min() > 0.3 + scene.model.radius


def ring(scene, radius=0.5, missing=0.0) -> Crowd:
    """People shoulder to shoulder around (5, 5), but for a gap `missing` wide to the left of x [rad]."""
    angles = np.linspace(missing / 2, 2 * np.pi - missing / 2, 24, endpoint=missing > 0) + np.pi / 2
    return scene.crowd(*zip(5 + radius * np.cos(angles), 5 + radius * np.sin(angles), strict=True))


def test_a_robot_that_is_stuck_turns_on_the_spot_and_keeps_its_side(scene):
    trace = scene.drive(dwa(scene), scene.line(), crowd=ring(scene), seconds=8.0)
    assert np.hypot(*(trace[:, :2] - (5.0, 5.0)).T).max() < 1e-3
    turned = np.diff(trace[:, 2])
    assert (np.sign(turned) == np.sign(turned[0])).all()
    assert abs(trace[-1, 2]) > 2 * math.pi


@pytest.mark.parametrize("y", [4.7, 5.3])
def test_a_robot_that_is_stuck_turns_away_from_the_nearest_obstacle(scene, y):
    crowd = scene.crowd((5.35, y), *ring(scene, 0.55).position.tolist())
    v, omega = decide(dwa(scene), scene.odometry(5.0, 5.0), scene.line(), crowd)
    assert v == 0.0
    assert np.sign(omega) == np.sign(5.0 - y)


def test_a_robot_that_is_stuck_again_chooses_its_side_anew(scene):
    controller, state = dwa(scene), scene.odometry(5.0, 5.0)
    for y in (4.7, 5.3, 4.7):
        stuck = decide(controller, state, scene.line(), scene.crowd((5.35, y), *ring(scene, 0.55).position.tolist()))
        assert np.sign(stuck[1]) == np.sign(5.0 - y)
        assert decide(controller, state, scene.line(), scene.crowd())[0] > 0.0


def test_a_robot_that_is_stuck_leaves_through_the_gap(scene):
    trace = scene.drive(dwa(scene), scene.line(), crowd=ring(scene, 1.2, missing=1.8), seconds=30.0)
    assert trace[-1, 0] > 10.0


def test_other_robots_are_avoided_and_the_robot_itself_is_not(scene):
    state, goal = scene.odometry(5.0, 5.0, 0.0, 1.0), scene.line()
    free = decide(dwa(scene), state, goal, scene.crowd())
    assert decide(dwa(scene), state, goal, scene.crowd(), (scene.robot("robot", 5.0, 5.0),)) == free
    other = decide(dwa(scene), state, goal, scene.crowd(), (scene.robot("other", 6.0, 5.1),))
    assert other == decide(dwa(scene), state, goal, scene.crowd((6.0, 5.1)))
    assert other != free


def test_people_are_seen_across_the_seam(scene):
    controller, goal = dwa(scene), scene.line()
    state = scene.odometry(20.0, 0.4, 0.0, 1.0)
    across = decide(controller, state, goal, scene.crowd((21.0, 9.9)))
    assert across == pytest.approx(decide(controller, state, goal, scene.crowd((21.0, -0.1))), abs=1e-12)
    assert across != decide(controller, state, goal, scene.crowd())


def test_a_mirrored_scene_gets_the_mirrored_command(scene):
    for seed in range(40):
        odometry, crowd = random_state(scene, seed)
        ego = ego_of(odometry)
        mirrored = scene.odometry(ego.x, 10.0 - ego.y, -ego.heading, ego.speed, -ego.turn_rate)
        people = scene.crowd(*map(tuple, crowd.position * (1, -1) + (0, 10)))
        v, omega = decide(dwa(scene), odometry, scene.line(), crowd)
        # Equal but for rounding, as long as no two samples are equally good.
        assert decide(dwa(scene), mirrored, scene.line(), people) == pytest.approx((v, -omega), abs=1e-9)


def test_equal_inputs_give_equal_commands_in_every_episode(scene):
    controller = dwa(scene)

    def episode():
        controller.reset(scene.setup())
        return [decide(controller, o, scene.line(), c) for o, c in (random_state(scene, seed) for seed in range(20))]

    first = episode()
    assert episode() == first
    stuck = decide(controller, scene.odometry(5.0, 5.0), scene.line(), ring(scene))
    assert stuck[0] == 0.0
    assert episode() == first


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("heading", -0.1),
        ("clearance", math.nan),
        ("velocity", -1.0),
        ("inflation", -0.01),
        ("horizon", 0.0),
        ("braking", 1.5),
        ("braking", 0.0),
        ("speeds", 1),
        ("turn_rates", 0),
    ],
)
def test_options_that_mean_nothing_are_refused(option, value):
    with pytest.raises(ValueError, match=rf"{option} is .*, expected"):
        Config(**{option: value})
