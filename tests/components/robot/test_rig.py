"""Rigid bodies on a floor: Coulomb's friction, the way wheels roll, and the laws of impacts."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pymunk
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.robot.bases import drive_at_start
from components.robot.floor import GRAVITY
from components.robot.rig import Rig
from crowdcosim.component import ComponentError
from crowdcosim.robots import Car, Differential, Holonomic, Pose, Robot, Target

H = 0.01
BASES = {
    "differential": Differential(track=0.23),
    "holonomic": Holonomic(max_lateral_speed=1.0),
    "car": Car(wheelbase=0.24, max_steering_angle=0.5, max_steering_rate=2.0),
}
# Joints keep wheels in place by iteration: what is left of their error after 40 rounds.
JOINTS = 1e-4


class Stand:
    """One robot on an endless floor."""

    def __init__(self, turtlebot, kind, grip=0.8, heading=0.0):
        model = dataclasses.replace(turtlebot, min_speed=-1.0, base=BASES[kind])
        start = Pose(x=0.0, y=0.0, heading=heading)
        robot = Robot(name="robot", number=1, model=model, start=start, goal=Target(x=0.0, y=0.0))
        self.model = model
        self.space = pymunk.Space()
        self.drive = drive_at_start(robot)
        self.rig = Rig(self.space, robot, self.drive, grip)

    def step(self, command):
        self.rig.pull(self.drive.plan(command, H))
        self.space.step(H)
        self.rig.read()

    @property
    def momentum(self):
        return np.sum([body.mass * np.array(body.velocity) for body in self.space.bodies], axis=0)

    @property
    def energy(self):
        return sum(body.kinetic_energy / 2.0 for body in self.space.bodies)  # pymunk's is m v^2


@pytest.fixture
def stand(turtlebot):
    return lambda *options, **more: Stand(turtlebot, *options, **more)


@pytest.mark.parametrize("kind", BASES)
def test_mass_and_inertia_are_those_of_the_whole(stand, kind):
    bodies = list(stand(kind).space.bodies)
    centre = bodies[0].position
    assert sum(body.mass for body in bodies) == pytest.approx(20.0)
    inertia = sum(body.moment + body.mass * (body.position - centre).length_squared for body in bodies)
    assert inertia == pytest.approx(0.5 * 20.0 * 0.177**2)


@pytest.mark.parametrize("kind", BASES)
def test_it_accelerates_as_commanded(stand, twist, kind):
    here = stand(kind, heading=0.3)
    for _ in range(15):
        here.step(twist(1.0))
    acceleration = min(5.0, 0.5 * 0.8 * GRAVITY) if kind == "car" else 5.0  # half its weight is on the driven wheel
    assert here.drive.speed == pytest.approx(0.15 * acceleration, abs=JOINTS)
    # The way that v = a t leads to, less what its beginning from the old velocity costs: a h t / 2.
    way = 0.5 * acceleration * 0.15**2 - 0.5 * acceleration * H * 0.15
    assert math.hypot(here.drive.x, here.drive.y) == pytest.approx(way, abs=JOINTS)
    assert here.drive.heading == pytest.approx(0.3, abs=1e-9)


@pytest.mark.parametrize("kind", BASES)
def test_grip_limits_how_fast_it_gets(stand, twist, kind):
    here = stand(kind, grip=0.1)
    for _ in range(50):
        here.step(twist(1.0))
    driven = 0.5 if kind == "car" else 1.0  # one of its two wheels
    assert here.drive.speed == pytest.approx(driven * 0.1 * GRAVITY * 0.5, rel=1e-3)


@pytest.mark.parametrize("kind", BASES)
def test_a_shove_aside_decays_by_coulombs_law(stand, twist, kind):
    here = stand(kind)
    here.rig.shove(0.0, 1.5, 0.0)
    # Wheels resist with mu m g across; a holonomic base is braked by its motors, which have 5 m/s2.
    deceleration = 5.0 if kind == "holonomic" else 0.8 * GRAVITY
    for _ in range(10):
        here.step(twist(0.0))
    assert here.drive.lateral_speed == pytest.approx(1.5 - 0.1 * deceleration, abs=1e-3)
    for _ in range(30):
        here.step(twist(0.0))
    assert np.hypot(*here.drive.velocity) == pytest.approx(0.0, abs=JOINTS)
    assert here.drive.y == pytest.approx(1.5**2 / (2.0 * deceleration), rel=0.08)  # semi-implicit: h v / 2 early


@pytest.mark.parametrize("kind", BASES)
def test_on_ice_it_keeps_its_momentum(stand, twist, kind):
    here = stand(kind, grip=1e-12)
    here.rig.shove(0.7, -0.4, 0.3)
    before = here.momentum
    for _ in range(100):
        here.step(twist(1.0, 0.5))
    assert here.momentum == pytest.approx(before, abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(
    kind=st.sampled_from(sorted(BASES)),
    velocity=st.tuples(*[st.floats(-2, 2)] * 3),
    grip=st.floats(0.05, 1.0),
)
def test_friction_only_takes_energy(turtlebot, twist, kind, velocity, grip):
    here = Stand(turtlebot, kind, grip=grip)
    here.rig.shove(*velocity)
    before = here.energy
    left_over = 1e-5 * (1.0 + before)  # a millimetre per second or two: the solver stops after 40 rounds
    for _ in range(60):
        here.step(twist(0.0))
        assert here.energy <= before + left_over
        before = here.energy
        before = here.energy


def test_two_wheels_draw_the_circle_that_is_commanded(stand, twist):
    here = stand("differential")
    for _ in range(50):
        here.step(twist(0.8, 0.5))
    assert here.drive.turn_rate == pytest.approx(0.5, abs=1e-4)
    assert here.drive.speed == pytest.approx(0.8, abs=1e-4)
    # Turning needs a force to the inside, and friction gives it before it slips.
    assert abs(here.drive.lateral_speed) < 0.01


def test_the_front_wheel_leads_a_car_round_its_circle(stand, twist):
    here = stand("car")
    for _ in range(100):
        here.step(twist(0.5, 0.5))
    rate = here.drive.turn_rate
    assert rate == pytest.approx(0.5, rel=0.01)
    # The centre of the rear axle does not slip sideways: the base's centre moves at omega L / 2 across.
    assert here.drive.lateral_speed == pytest.approx(rate * 0.12, abs=0.005)


def test_a_car_that_stands_does_not_turn(stand, twist):
    here = stand("car")
    for _ in range(100):
        here.step(twist(0.0, 1.0))
    assert (here.drive.turn_rate, here.drive.heading) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_wheels_stay_where_they_are_joined(stand, twist):
    rng = np.random.default_rng(5)
    for kind in ("differential", "car"):
        here = stand(kind)
        wheels = list(here.space.bodies)[1:]
        places = [here.rig.base.world_to_local(body.position) for body in wheels]
        for _ in range(200):
            here.step(twist(rng.uniform(-1, 1), rng.uniform(-3, 3)))
            for body, place in zip(wheels, places, strict=True):
                assert (here.rig.base.world_to_local(body.position) - place).length < JOINTS * 10


@settings(max_examples=30, deadline=None)
@given(mass=st.floats(1.0, 60.0), speed=st.floats(0.3, 3.0))
def test_a_head_on_impact_keeps_momentum_and_loses_half_mu_v_squared(turtlebot, mass, speed):
    here = Stand(turtlebot, "differential", grip=1e-12)
    other = pymunk.Body(mass, math.inf)
    other.position = (0.6, 0.0)
    here.space.add(other, pymunk.Circle(other, 0.3))
    here.rig.shove(speed, 0.0, 0.0)
    momentum, energy = here.momentum, here.energy
    for _ in range(int(0.4 / (speed * 0.001))):
        here.space.step(0.001)
    common = 20.0 * speed / (20.0 + mass)
    # The solver stops after 40 rounds; joints and contact share the impulse.
    assert here.momentum == pytest.approx(momentum, rel=1e-9)
    assert other.velocity.x == pytest.approx(common, rel=5e-3)
    assert energy - here.energy == pytest.approx(0.5 * speed**2 / (1 / 20.0 + 1 / mass), rel=2e-2)


def test_a_differential_base_needs_its_track(turtlebot):
    model = dataclasses.replace(turtlebot, base=Differential())
    robot = Robot(name="robot", number=1, model=model, start=Pose(x=0.0, y=0.0), goal=Target(x=0.0, y=0.0))
    with pytest.raises(ComponentError, match="gives no track, expected it"):
        Rig(pymunk.Space(), robot, drive_at_start(robot), 0.8)


def test_wheels_beyond_the_disc_are_refused(turtlebot):
    model = dataclasses.replace(turtlebot, base=Differential(track=2.0))
    robot = Robot(name="robot", number=1, model=model, start=Pose(x=0.0, y=0.0), goal=Target(x=0.0, y=0.0))
    with pytest.raises(ComponentError, match="too far out for a disc of 0.177 m"):
        Rig(pymunk.Space(), robot, drive_at_start(robot), 0.8)
