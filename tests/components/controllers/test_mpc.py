"""Model predictive control as a controller: what it does among people and walls."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from components.controllers.ego import ego_of
from components.controllers.mpc import MPC, Config
from crowdcosim import Controller
from crowdcosim.component import make, ports_of
from crowdcosim.messages import Crowd, Detections, Goal, Header, Odometry, Path, RobotState, Time, Twist
from crowdcosim.world import Wall, World


def mpc(scene, world=None, dt=0.1, **options) -> MPC:
    controller = make(MPC, options)
    controller.reset(scene.setup(world, dt))
    return controller


def decide(controller, odometry, goal, crowd, others=()) -> tuple[float, float]:
    twist, _ = controller.step(odometry=odometry, goal=goal, crowd=crowd, others=others)
    return twist.linear.x, twist.angular.z


def decision_bytes(controller, odometry, goal, crowd) -> bytes:
    twist, plan = controller.step(odometry=odometry, goal=goal, crowd=crowd, others=())
    poses = [(p.pose.position.x, p.pose.position.y, p.pose.orientation.z) for p in plan.poses]
    return np.array([(twist.linear.x, twist.angular.z, 0.0), *poses]).tobytes()


class Among(Controller):
    """An MPC for `Scene.drive`, among people who walk on at their velocity."""

    def __init__(self, controller, crowd, dt=0.1) -> None:
        self.controller = controller
        self.crowd = crowd
        self.dt = dt
        self.past: list[np.ndarray] = []

    def step(self, odometry, goal, crowd, others) -> Twist:
        self.past.append(self.crowd.position)
        twist, _ = self.controller.step(odometry=odometry, goal=goal, crowd=self.crowd, others=others)
        self.crowd = replace(self.crowd, position=self.crowd.position + self.dt * self.crowd.velocity)
        return twist

    def least_gap(self, trace) -> float:
        """Least distance between the centres [m]."""
        past = np.array(self.past)
        return float(np.hypot(*(trace[: len(past), None, :2] - past).transpose(2, 0, 1)).min())


def driven(scene, controller, goal, crowd, **options) -> tuple[np.ndarray, float]:
    among = Among(controller, crowd, options.get("dt", 0.1))
    trace = scene.drive(among, goal, crowd=crowd, **options)
    return trace, among.least_gap(trace) if len(crowd.id) else math.inf


def random_state(scene, seed, count=200):
    rng = np.random.default_rng(seed)
    x, y, v = rng.uniform([0.3, 0.3, 0.0], [49.7, 9.7, 1.0])
    theta, omega = rng.uniform(-math.pi, math.pi, 2)
    return scene.odometry(x, y, theta, v, omega), scene.random_crowd(seed, count)


def test_its_inputs_are_truth_or_what_is_sensed_and_it_says_its_plan():
    ports = ports_of(MPC)
    assert {p.name: (p.type, p.many) for p in ports.inputs} == {
        "odometry": (Odometry, False),
        "goal": (Goal, False),
        "crowd": (Crowd, False),
        "others": (RobotState, True),
        "detections": (Detections, False),
    }
    assert {p.name: p.type for p in ports.outputs} == {"twist": Twist, "plan": Path}


@pytest.mark.parametrize("pose", [(5.0, 5.0, 0.0), (5.0, 5.0, 2.0), (5.0, 5.0, -3.1)])
def test_without_people_it_turns_to_the_goal_and_drives_at_full_speed(scene, pose):
    trace, _ = driven(scene, mpc(scene, scene.open), scene.line(1e6), scene.crowd(), pose=pose, seconds=8.0)
    # An interior point comes as near as its tolerance.
    assert trace[-1, 3] == pytest.approx(1.0, abs=0.003)
    assert math.remainder(trace[-1, 2], math.tau) == pytest.approx(0.0, abs=0.003)
    assert trace[-1, 4] == pytest.approx(0.0, abs=0.003)


def test_it_crosses_the_empty_corridor_hardly_slower_than_straight_ahead(scene):
    trace, _ = driven(scene, mpc(scene), scene.line(), scene.crowd(), until_x=45.0)
    # The baseline needs 40.1 s.
    assert 0.1 * (len(trace) - 1) <= 40.5
    np.testing.assert_allclose(trace[:, 1], 5.0, atol=0.01)


@pytest.mark.parametrize(("x", "y"), [(27.0, 5.0), (25.0, 8.0), (22.5, 4.0), (26.0, 3.0)])
def test_it_enters_a_disc_and_rests(scene, x, y):
    trace, _ = driven(scene, mpc(scene), scene.disc(x, y), scene.crowd(), pose=(25.0, 5.0, 0.5), seconds=10.0)
    assert math.dist(trace[-1, :2], (x, y)) <= 0.3
    assert trace[-1, 3] == 0.0


@pytest.mark.parametrize("y", [4.6, 5.0, 5.001, 5.2])
def test_a_person_who_stands_in_the_way_is_passed_with_a_distance(scene, y):
    crowd = scene.crowd((9.0, y))
    trace, gap = driven(scene, mpc(scene), scene.line(15.0), crowd, seconds=14.0, until_x=15.0)
    assert trace[-1, 0] >= 15.0
    assert gap > 0.3 + scene.model.radius


@pytest.mark.parametrize("velocity", [(-1.3, 0.0), (-0.9, 0.45), (0.3, 0.0)])
@pytest.mark.parametrize("y", [4.8, 5.0])
def test_somebody_who_walks_and_does_not_look_is_avoided(scene, velocity, y):
    crowd = scene.crowd((10.0, y), velocity=velocity)
    trace, gap = driven(scene, mpc(scene), scene.line(16.0), crowd, seconds=16.0, until_x=16.0)
    assert trace[-1, 0] >= 16.0
    assert gap > 0.3 + scene.model.radius


def test_a_gap_in_a_row_of_people_is_found(scene):
    crowd = scene.crowd(*((10.0, y) for y in (3.4, 4.1, 4.8, 5.5, 7.2, 7.9)), velocity=(-1.0, 0.0))
    trace, gap = driven(scene, mpc(scene), scene.line(14.0), crowd, seconds=14.0, until_x=14.0)
    assert trace[-1, 0] >= 14.0
    assert gap > 0.3 + scene.model.radius


@pytest.mark.parametrize("theta", [0.4, 1.2, -1.57])
def test_walls_are_never_touched_even_when_a_crowd_presses(scene, theta):
    rng = np.random.default_rng(7)
    people = rng.uniform([6.0, 4.0], [20.0, 10.0], (80, 2)) if theta > 0 else rng.uniform([6, 0], [20, 6], (80, 2))
    crowd = scene.crowd(*map(tuple, people), velocity=(-1.3, 0.3 if theta > 0 else -0.3))
    y = 8.8 if theta > 0 else 1.2
    trace, _ = driven(scene, mpc(scene), scene.line(), crowd, pose=(6.0, y, theta), speed=1.0, seconds=6.0)
    assert trace[:, 1].min() > scene.model.radius
    assert trace[:, 1].max() < 10.0 - scene.model.radius


@pytest.mark.parametrize("dt", [0.05, 0.1, 0.3])
def test_it_stops_before_a_wall_that_bars_its_way(scene, dt):
    goal = Goal(robot="robot", position=np.array([60.0, 5.0]), direction=np.array([1.0, 0.0]))
    trace, _ = driven(
        scene, mpc(scene, dt=dt), goal, scene.crowd(), pose=(46.0, 5.0, 0.3), speed=1.0, dt=dt, seconds=6.0
    )
    assert 49.0 < trace[:, 0].max() < 50.0 - scene.model.radius


def test_a_robot_that_starts_at_a_wall_gets_away(scene):
    start = 10.0 - scene.model.radius - 1e-3
    trace, _ = driven(scene, mpc(scene), scene.line(), scene.crowd(), pose=(20.0, start, 1.5), seconds=5.0)
    assert trace[-1, 0] > 22.0
    assert trace[:, 1].max() < 10.0 - scene.model.radius + 5e-3


def test_it_goes_through_a_door_and_not_through_the_wall_beside_it(scene):
    walls = (Wall(start=(25.0, -50.0), end=(25.0, 4.3)), Wall(start=(25.0, 5.5), end=(25.0, 60.0)))
    world = World(size=(50.0, 10.0), walls=walls)
    trace, _ = driven(
        scene, mpc(scene, world), scene.disc(30.0, 5.0), scene.crowd(), pose=(21.0, 5.6, 0.0), seconds=14.0
    )
    assert math.dist(trace[-1, :2], (30.0, 5.0)) <= 0.3
    beside = np.abs(trace[:, 0] - 25.0) < scene.model.radius
    assert beside.any()
    jambs = np.array([(25.0, 4.3), (25.0, 5.5)])
    assert np.hypot(*(trace[:, None, :2] - jambs).transpose(2, 0, 1)).min() > scene.model.radius
    closed = World(size=(50.0, 10.0), walls=(Wall(start=(25.0, -50.0), end=(25.0, 60.0)),))
    trace, _ = driven(scene, mpc(scene, closed), scene.line(), scene.crowd(), pose=(23.0, 5.0, 0.2), seconds=6.0)
    assert 24.5 < trace[:, 0].max() < 25.0 - scene.model.radius


def test_commands_stay_within_the_robots_limits(scene):
    controller, model = mpc(scene), scene.model
    for seed in range(40):
        state, crowd = random_state(scene, seed)
        ego = ego_of(state)
        v, omega = decide(controller, state, scene.line(), crowd)
        assert model.min_speed <= v <= model.max_speed
        assert abs(omega) <= model.max_angular_velocity
        assert abs(v - ego.speed) <= model.max_acceleration * 0.1 + 1e-6
        assert abs(omega - ego.turn_rate) <= model.max_angular_acceleration * 0.1 + 1e-6


def test_the_plan_begins_at_the_robot_and_goes_on_in_time(scene):
    state = replace(scene.odometry(20.0, 4.0, 0.5, 0.8), header=Header(stamp=Time(sec=7, nanosec=900_000_000)))
    twist, plan = mpc(scene).step(odometry=state, goal=scene.line(), crowd=scene.crowd((23.0, 4.5)), others=())
    assert plan.header == Header(stamp=state.header.stamp, frame_id="map")
    assert len(plan.poses) == 21
    first, second, last = plan.poses[0], plan.poses[1], plan.poses[-1]
    assert (first.pose.position.x, first.pose.position.y) == pytest.approx((20.0, 4.0), abs=1e-3)
    assert 2 * math.asin(first.pose.orientation.z) == pytest.approx(0.5, abs=1e-3)
    assert (second.header.stamp.sec, second.header.stamp.nanosec) == (8, 100_000_000)
    assert (last.header.stamp.sec, last.header.stamp.nanosec) == (11, 900_000_000)
    # The command is for half of the first stage.
    way = math.dist(*[(p.pose.position.x, p.pose.position.y) for p in (first, second)])
    assert way == pytest.approx(0.2 * twist.linear.x, abs=1e-3)


def test_people_are_seen_across_the_seam_and_robots_are_not(scene):
    goal, state = scene.line(), scene.odometry(20.0, 0.4, 0.0, 1.0)

    def fresh(crowd, others=()):
        return decide(mpc(scene), state, goal, crowd, others)

    free, across = fresh(scene.crowd()), fresh(scene.crowd((21.0, 9.99)))
    assert across == pytest.approx(fresh(scene.crowd((21.0, -0.01))), abs=1e-6)
    assert across != free
    assert fresh(scene.crowd(), (scene.robot("other", 21.0, 9.99),)) == free


def test_other_robots_are_avoided_and_the_robot_itself_is_not(scene):
    state, goal = scene.odometry(5.0, 5.0, 0.0, 1.0), scene.line()
    free = decide(mpc(scene), state, goal, scene.crowd())
    assert decide(mpc(scene), state, goal, scene.crowd(), (scene.robot("robot", 5.0, 5.0),)) == free
    other = decide(mpc(scene), state, goal, scene.crowd(), (scene.robot("other", 7.0, 5.1),))
    assert other == decide(mpc(scene), state, goal, scene.crowd((7.0, 5.1)))
    assert other != free


def test_equal_inputs_give_equal_bytes_in_every_episode_and_object(scene):
    goal = scene.line()

    def episode(controller):
        return [decision_bytes(controller, *given) for given in inputs]

    inputs = [(o, goal, c) for o, c in (random_state(scene, seed) for seed in range(15))]
    controller = mpc(scene)
    first = episode(controller)
    decide(controller, scene.odometry(900.0, -900.0, 1.0), goal, scene.crowd((900.0, -900.0)))
    controller.reset(scene.setup())
    assert episode(controller) == first
    assert episode(mpc(scene)) == first


def test_what_is_not_finite_is_refused_and_the_next_step_is_as_if_it_had_not_been(scene):
    goal, crowd = scene.line(), scene.crowd((7.0, 5.1))
    state = scene.odometry(5.0, 5.0, 0.0, 1.0)
    controller, expected = mpc(scene), decide(mpc(scene), state, goal, crowd)
    for bad in (
        (scene.odometry(math.nan, 5.0), goal, crowd),
        (scene.odometry(5.0, 5.0, 0.0, math.inf), goal, crowd),
        (state, goal, scene.crowd((math.nan, 5.1))),
        (state, goal, scene.crowd((7.0, 5.1), velocity=(0.0, math.inf))),
        (state, goal, scene.crowd((7.0, 5.1), radius=math.nan)),
    ):
        with pytest.raises(ValueError, match="expected finite"):
            decide(controller, *bad)
    assert decide(controller, state, goal, crowd) == expected


@pytest.mark.parametrize(
    "crowd",
    [
        {"position": [(5.0, 5.0)] * 30},
        {"position": [(5.0, 5.0)], "radius": 1e4},
        {"position": [(8.0, 5.0)], "radius": 150.0},
        {"position": [(8.0, 5.0)], "radius": 1e300},
        {"position": [(8.0, 5.0)], "velocity": (1e300, -1e300)},
        {"position": [(1e300, -1e300)]},
        {"position": [(8.0, 5.0)], "radius": 0.0},
    ],
)
def test_absurd_people_never_hang_it_nor_make_it_leave_its_limits(scene, crowd):
    people = scene.crowd(*crowd.pop("position"), **crowd)
    for world in (scene.corridor, scene.open):
        v, omega = decide(mpc(scene, world), scene.odometry(5.0, 5.0, 0.0, 1.0), scene.line(), people)
        assert scene.model.min_speed <= v <= scene.model.max_speed
        assert abs(omega) <= scene.model.max_angular_velocity


def test_where_every_start_is_hopeless_it_brakes(scene):
    controller = mpc(scene)
    state = scene.odometry(5.0, 5.0, 0.0, 1.0)
    assert decide(controller, state, scene.line(), scene.crowd((8.0, 5.0), radius=1e4)) == (0.0, 0.0)
    assert decide(controller, state, scene.line(), scene.crowd()) != (0.0, 0.0)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("margin", -0.1),
        ("proximity", math.inf),
        ("steepness", 0.0),
        ("people", -1),
        ("stages", 1),
        ("stage", math.nan),
    ],
)
def test_options_that_mean_nothing_are_refused(option, value):
    with pytest.raises(ValueError, match=rf"{option} is .*, expected"):
        Config(**{option: value})


def test_a_robot_that_cannot_turn_is_refused(scene):
    setup = scene.setup()
    model = replace(scene.model, max_angular_velocity=0.0)
    robots = (replace(setup.robots[0], model=model),)
    with pytest.raises(ValueError, match="cannot turn"):
        make(MPC, {}).reset(replace(setup, robots=robots))
