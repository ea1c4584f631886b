"""What holds for every controller that looks ahead or feels forces: MPPI, time-to-collision, social forces."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.controllers import mppi, social_force, ttc
from components.controllers.differential import Limits, Motion, advance
from components.controllers.dwa import DWA
from components.controllers.ego import Ego
from components.controllers.mpc import MPC
from components.controllers.mppi import MPPI
from components.controllers.prediction import Tracks
from components.controllers.rvo import RVO
from components.controllers.social_force import Forces, SocialForce, repulsion
from components.controllers.ttc import STEP, TTC, first_contact
from crowdcosim.component import make
from crowdcosim.obstacles import Box
from crowdcosim.world import Wall, World

ALL = [MPPI, SocialForce, TTC]
LIMITS = Limits(-0.2, 1.0, 5.0, math.pi, 10.0)


def controller_of(cls, scene, world=None, dt=0.1, **options):
    controller = make(cls, options)
    controller.reset(scene.setup(world, dt))
    return controller


def decide(controller, odometry, goal, crowd, others=()):
    twist = controller.step(odometry=odometry, goal=goal, crowd=crowd, others=others)
    return twist.linear.x, twist.angular.z


def random_state(scene, seed, count=150):
    rng = np.random.default_rng(seed)
    x, y, v = rng.uniform([0.5, 0.5, 0.0], [49.5, 9.5, 1.0])
    theta, omega = rng.uniform(-math.pi, math.pi, 2)
    return scene.odometry(x, y, theta, v, omega), scene.random_crowd(seed, count)


@pytest.mark.parametrize("cls", ALL)
def test_it_crosses_the_empty_corridor(scene, cls):
    trace = scene.drive(controller_of(cls, scene), scene.line(), crowd=scene.crowd(), until_x=45.0)
    assert trace[-1, 0] >= 45.0
    # 40 m at 1 m/s; noise and averages cost MPPI a little.
    assert 39.9 <= 0.1 * (len(trace) - 1) <= 42.0
    assert np.abs(trace[:, 1] - 5.0).max() < 0.3


@pytest.mark.parametrize("cls", ALL)
@pytest.mark.parametrize("theta", [2.0, -3.1])
def test_it_turns_round_to_a_disc_and_rests_in_it(scene, cls, theta):
    goal = scene.disc(27.0, 6.0)
    trace = scene.drive(controller_of(cls, scene), goal, pose=(25.0, 5.0, theta), seconds=15.0, crowd=scene.crowd())
    assert math.dist(trace[-1, :2], goal.position) <= 0.3
    assert trace[-1, 3] == 0.0


@pytest.mark.parametrize("cls", ALL)
@pytest.mark.parametrize("y", [4.8, 5.0, 5.15])
def test_a_person_who_stands_in_the_way_is_passed_without_contact(scene, cls, y):
    crowd = scene.crowd((9.0, y))
    trace = scene.drive(controller_of(cls, scene), scene.line(14.0), crowd=crowd, seconds=30.0, until_x=14.0)
    assert trace[-1, 0] >= 14.0
    assert np.hypot(*(trace[:, :2] - (9.0, y)).T).min() > 0.3 + scene.model.radius


@pytest.mark.parametrize("cls", ALL)
def test_walls_are_not_touched_though_people_press(scene, cls):
    crowd = scene.crowd((20.8, 1.2), (20.0, 1.5), (21.0, 2.0), velocity=(-0.5, -0.3))
    trace = scene.drive(
        controller_of(cls, scene), scene.line(), pose=(19.5, 0.6, -0.8), speed=0.6, crowd=crowd, seconds=3.0
    )
    assert trace[:, 1].min() > scene.model.radius


@pytest.mark.parametrize("cls", [MPPI, TTC])
def test_it_goes_round_a_short_wall(scene, cls):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(8.0, 4.0), end=(8.0, 5.5)),))
    trace = scene.drive(controller_of(cls, scene, world), scene.line(12.0), crowd=scene.crowd(), until_x=12.0)
    assert trace[-1, 0] >= 12.0
    y = np.interp(8.0, trace[:, 0], trace[:, 1])
    assert y > 5.5 + scene.model.radius or y < 4.0 - scene.model.radius


@pytest.mark.parametrize("cls", ALL)
def test_commands_stay_within_the_robots_limits(scene, cls):
    controller = controller_of(cls, scene)
    for seed in range(20):
        state, crowd = random_state(scene, seed)
        v, omega = decide(controller, state, scene.line(), crowd)
        assert scene.model.min_speed <= v <= scene.model.max_speed
        assert abs(omega) <= scene.model.max_angular_velocity


@pytest.mark.parametrize("cls", ALL)
def test_equal_inputs_give_equal_commands_in_every_episode_and_object(scene, cls):
    first = controller_of(cls, scene)

    def episode(controller):
        controller.reset(scene.setup())
        return [decide(controller, o, scene.line(), c) for o, c in (random_state(scene, s) for s in range(5))]

    assert episode(first) == episode(first) == episode(controller_of(cls, scene))


@pytest.mark.parametrize("cls", [TTC, SocialForce])
def test_a_mirrored_scene_gets_the_mirrored_command(scene, cls):
    for seed in range(20):
        state, crowd = random_state(scene, seed)
        pose, twist = state.pose.pose, state.twist.twist
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        mirrored = scene.odometry(pose.position.x, 10.0 - pose.position.y, -heading, twist.linear.x, -twist.angular.z)
        people = scene.crowd(*map(tuple, crowd.position * (1, -1) + (0, 10)), velocity=crowd.velocity * (1, -1))
        v, omega = decide(controller_of(cls, scene), state, scene.line(), crowd)
        assert decide(controller_of(cls, scene), mirrored, scene.line(), people) == pytest.approx((v, -omega), abs=1e-7)


@pytest.mark.parametrize("cls", ALL)
def test_people_count_across_the_seam_and_robots_do_not(scene, cls):
    state, goal = scene.odometry(20.0, 0.4, 0.0, 1.0), scene.line()

    def say(crowd, others=()):
        return decide(controller_of(cls, scene), state, goal, crowd, others)

    free = say(scene.crowd())
    across = say(scene.crowd((20.8, 9.99)))
    assert across != free
    assert across == pytest.approx(say(scene.crowd((20.8, -0.01))), abs=1e-9)
    assert say(scene.crowd(), (scene.robot("other", 20.8, 9.99),)) == free
    assert say(scene.crowd(), (scene.robot("robot", 20.0, 0.4),)) == free


def test_a_step_of_the_drive_obeys_its_limits_and_keeps_its_speeds_mean():
    motion = advance(Motion(0.0, 0.0, 0.3, 0.5, 0.0), 1.0, 9.0, 0.2, Limits(0.0, 0.9, 1.0, 2.0, 5.0))
    assert (motion.speed, motion.turn_rate) == pytest.approx((0.7, 1.0))
    assert motion.heading == pytest.approx(0.3 + 0.5 * 0.2)
    assert math.hypot(motion.x, motion.y) == pytest.approx(0.6 * 0.2)


def test_the_time_to_collision_is_the_closed_form_on_a_straight_line():
    gap, closing = 3.3, 1.0 + 0.65
    times = STEP * np.arange(31)
    position = np.stack([gap + 0.5 - 0.65 * times, np.zeros(31)], axis=1)[:, None]
    tracks = Tracks(np.ascontiguousarray(position), np.array([0.3]))
    t, least = first_contact(Ego(0.0, 0.0, 0.0, 1.0, 0.0), 1.0, 0.0, tracks, np.empty((0, 2, 2)), 0.2, LIMITS)
    assert t <= gap / closing < t + STEP
    assert least < 0.0


def test_the_force_is_the_gradient_of_its_potential():
    forces = Forces(0.5, 1.7, 0.3, 1.0, 1.0, 0.1, 5.0, 0.2, 1.0)
    rng = np.random.default_rng(4)
    for _ in range(50):
        r, w = rng.uniform(-3, 3, 2), rng.uniform(-1, 1, 2)

        def b(r, w=w):
            return 0.5 * math.sqrt((np.hypot(*r) + np.hypot(*(r - w))) ** 2 - np.hypot(*w) ** 2)

        def potential(r, b=b):
            return 1.7 * math.exp(-(b(r) - 0.5) / 0.3)

        if b(r) < 0.6:
            continue
        h = 1e-5
        gradient = [(potential(r + d) - potential(r - d)) / (2 * h) for d in h * np.eye(2)]
        # Central differences: errors of h^2 times the third derivative, 1 / 0.3^3.
        np.testing.assert_allclose(repulsion(*r, *w, 0.5, forces), -np.array(gradient), rtol=1e-6, atol=1e-7)


def test_mppi_changes_its_turn_rate_smoothly(scene):
    controller, rates = controller_of(MPPI, scene), []
    state = scene.odometry(20.0, 5.0, 0.0, 1.0)
    for _ in range(30):
        rates.append(decide(controller, state, scene.line(), scene.crowd())[1])
    # Straight ahead with nobody near, the average of the noise is what is left of it.
    assert np.abs(np.diff(rates)).mean() < 0.1


@pytest.mark.parametrize(
    ("module", "option", "value"),
    [
        (mppi, "temperature", 0.0),
        (mppi, "samples", -1),
        (mppi, "steps", 1),
        (mppi, "margin", -0.1),
        (ttc, "horizon", 0.0),
        (ttc, "urgency", math.inf),
        (social_force, "relaxation", 0.0),
        (social_force, "strength", -1.0),
    ],
)
def test_options_that_mean_nothing_are_refused(module, option, value):
    with pytest.raises(ValueError, match=rf"{option} is .*, expected"):
        module.Config(**{option: value})


@pytest.mark.parametrize("cls", [DWA, MPC, MPPI, RVO, TTC])
def test_a_pillar_in_the_way_is_passed_without_touching_it(scene, cls):
    pillar = Box(shape="box", centre=(8.0, 5.2), size=(0.6, 0.6), yaw=0.3)
    world = World(size=(50.0, 10.0), obstacles=(pillar,))
    controller = controller_of(cls, scene, world)
    x, y, theta, v, omega = 5.0, 5.0, 0.0, 0.0, 0.0
    for _ in range(150):
        result = controller.step(
            odometry=scene.odometry(x, y, theta, v, omega), goal=scene.line(12.0), crowd=scene.crowd(), others=()
        )
        twist = getattr(result, "twist", result)
        motion = advance(Motion(x, y, theta, v, omega), twist.linear.x, twist.angular.z, 0.1, LIMITS)
        x, y, theta, v, omega = motion
        along, across = _seen_from(pillar, x, y)
        gap = math.hypot(max(0.0, abs(along) - 0.3), max(0.0, abs(across) - 0.3)) - scene.model.radius
        assert gap > 0.0
        if x >= 12.0:
            break
    assert x >= 12.0


def _seen_from(box, x, y):
    dx, dy = x - box.centre[0], y - box.centre[1]
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    return cos * dx + sin * dy, cos * dy - sin * dx
