"""A robot that forces move, among walls, people and robots: it obeys, it pushes, it is pushed, and says so."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from pydantic import ValidationError

from components.robot.forces import Config, Forces
from components.robot.kinematic import Kinematic
from components.robot.wheels import Config as WheelsConfig
from components.robot.wheels import Wheels
from crowdcosim.component import make, ports_of
from crowdcosim.messages import Contacts
from crowdcosim.robots import Car, Holonomic, Pose
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World
from orchestrator.stimuli import ROBOT as SUBJECT
from orchestrator.stimuli import WORLD as STIMULI

R = 0.177
# An impact is found at the end of the inner step of 10 ms in which it happens.
LATE = 0.01
CORRIDOR = World(
    size=(50.0, 10.0),
    periodic=(True, True),
    walls=(Wall(start=(50.0, 0.0), end=(50.0, 10.0), stops_people=False),),
)


@pytest.fixture(scope="module")
def pushed(bodies):
    """Scenes whose robots are moved by forces."""
    return lambda *starts, grip=0.8, **options: bodies(*starts, drive=lambda: Forces(Config(grip=grip)), **options)


def test_ports_are_those_of_the_kinematic_drive():
    assert ports_of(Forces) == ports_of(Kinematic)


def test_without_obstacles_it_drives_as_the_kinematic_robot_does(pushed, bodies, twist):
    ours, ideal = pushed(Pose(x=3.0, y=4.0)), bodies(Pose(x=3.0, y=4.0))
    for command in [twist(1.0)] * 10 + [twist(0.6, 0.5)] * 20 + [twist(0.0)] * 5:
        state, other = ours.step(command)[0].state, ideal.step(command)[0].state
    # Velocities come before positions: h / 2 of the speed's change, and of the turn's effect on the way.
    assert state.position == pytest.approx(other.position, abs=0.02)
    assert state.heading == pytest.approx(other.heading, abs=0.01)
    assert state.velocity == pytest.approx(other.velocity, abs=1e-3)


def test_a_wall_stops_it(pushed, twist):
    scene = pushed(Pose(x=48.0, y=5.0), world=CORRIDOR)
    first = None
    for _ in range(40):
        state, contacts = scene.step(twist(1.0))[0]
        if first is None and len(contacts.kind):
            first = contacts
    assert state.position == pytest.approx([50.0 - R, 5.0], abs=LATE)
    assert state.velocity == pytest.approx([0.0, 0.0], abs=0.02)
    assert (first.kind.tolist(), first.robot_part.tolist()) == ([Contacts.WALL], [Contacts.FRONT])
    assert first.approach_speed == pytest.approx([1.0], abs=1e-3)
    assert first.energy == pytest.approx([0.5 * 20.0], rel=2e-3)


@pytest.mark.parametrize(("base", "aside"), [(None, 0.0), (Holonomic(max_lateral_speed=1.0), 1.0)])
def test_a_slanting_wall_holds_wheels_and_deflects_a_holonomic_base(pushed, twist, turtlebot, base, aside):
    """Wheels resist with mu m g = 157 N across, motors push with 127 N at most: they are held at 30 degrees."""
    model = dataclasses.replace(turtlebot, min_speed=-1.0, base=base or turtlebot.base)
    slope = math.radians(30.0)
    wall = Wall(start=(6.0 - 4 * math.sin(slope), 4.0 - 4 * math.cos(slope)), end=(6.0 + 4 * math.sin(slope), 8.0))
    scene = pushed(Pose(x=4.5, y=4.0), world=World(size=(50.0, 10.0), walls=(wall,)), model=model)
    for _ in range(60):
        state = scene.step(twist(1.0))[0].state
    slid = np.hypot(*state.velocity)
    if aside:
        assert state.position[1] > 4.3
        assert slid == pytest.approx(0.5, abs=0.05)  # what is along the wall of 1 m/s
    else:
        assert (
            state.position[1] < 4.04
        )  # the impact's momentum aside takes v^2 / 2 mu g = 0.43^2 / 15.7 = 12 mm and more
        assert slid < 1e-3
    assert state.heading == pytest.approx(0.0, abs=0.02)


def test_somebody_light_is_pushed_along_and_costs_speed(pushed, twist, people):
    """Feet of 4 kg at 20 kg: after a plastic impact both go on with 20 / 24 of the speed."""
    scene = pushed(Pose(x=3.0, y=4.0), period=10_000_000)  # one impact per step, so that both speeds are seen
    for _ in range(40):
        before = scene.step(twist(1.0), crowd=people())[0].state
    x = before.position[0] + R + 0.3 + 0.0049
    state, contacts = scene.step(twist(1.0), crowd=people((x, 4.0, 0.0, 0.0)))[0]
    assert contacts.reflected_mass.tolist() == [4.0]
    # The motors have given 5 m/s2 since the impact, for at most 10 ms.
    assert 20.0 / 24.0 - 1e-3 <= state.velocity[0] <= 20.0 / 24.0 + 0.05
    assert contacts.approach_speed == pytest.approx([1.0], abs=1e-3)
    assert contacts.energy == pytest.approx([0.5 / (1 / 4 + 1 / 20)], rel=2e-3)
    assert contacts.striker.tolist() == [Contacts.BY_ROBOT]


def test_energy_that_is_reported_is_what_the_impact_takes(pushed, twist, people):
    """On ice: the kinetic energy of the two together before, less that after."""
    scene = pushed(Pose(x=3.0, y=4.0), grip=1e-9)
    for k in range(8):
        state, contacts = scene.step(twist(), crowd=people((3.6 - 0.1 * k, 4.0, -1.0, 0.0)))[0]
        if len(contacts.kind):
            break
    (mass,) = contacts.reflected_mass
    common = mass * -1.0 / (mass + 20.0)
    assert state.velocity == pytest.approx([common, 0.0], abs=5e-3)
    lost = 0.5 * mass * 1.0**2 - 0.5 * (mass + 20.0) * state.velocity[0] ** 2
    assert contacts.energy == pytest.approx([lost], rel=1e-2)
    assert contacts.striker.tolist() == [Contacts.BY_OTHER]


def test_two_robots_that_collide_keep_their_momentum(pushed, bodies, twist):
    """Each computes its own half of the same impact."""
    scene = pushed(Pose(x=3.0, y=4.0), Pose(x=4.2, y=4.1), grip=1e-9)
    for body, speed in zip(scene.components, (1.0, -0.5), strict=True):
        body._rig.shove(speed, 0.0, 0.0)
    scene.last = [body._output() for body in scene.components]
    for _ in range(12):
        results = scene.step(twist(), twist())
        assert sum(r.state.velocity for r in results) == pytest.approx([0.5, 0.0], abs=0.02)
        if len(results[0].contacts.kind):
            break
    a, b = results
    assert a.contacts.energy == pytest.approx(b.contacts.energy, rel=1e-6)
    assert a.contacts.normal[0] == pytest.approx(-b.contacts.normal[0], abs=1e-6)
    normal = a.contacts.normal[0]
    assert (b.state.velocity - a.state.velocity) @ normal == pytest.approx(0.0, abs=0.02)  # plastic


@pytest.mark.parametrize("seed", range(3))
def test_a_straight_driver_in_a_blind_crowd_keeps_its_line_within_a_palm(pushed, twist, people, seed):
    """Wheels hold what people shove; the robot only loses time."""
    rng = np.random.default_rng(seed)
    position = rng.uniform((0.0, 2.0), (8.0, 8.0), (25, 2))
    velocity = rng.uniform(-1.5, 1.5, (25, 2))
    scene = pushed(Pose(x=3.0, y=5.0))
    for _ in range(60):
        state = scene.step(twist(1.0), crowd=people(*np.hstack([position, velocity])))[0].state
        position += velocity * 0.1
    assert state.position[1] == pytest.approx(5.0, abs=0.1)
    assert abs(state.heading) < 0.1
    assert 3.0 < state.position[0] < 3.0 + 5.9


def test_people_shove_a_holonomic_robot_but_hardly_one_on_wheels(pushed, twist, people, turtlebot):
    ways = {}
    for name, base in (("wheels", turtlebot.base), ("holonomic", Holonomic(max_lateral_speed=1.0))):
        scene = pushed(Pose(x=3.0, y=4.0), model=dataclasses.replace(turtlebot, height=1.0, base=base), grip=0.3)
        for k in range(10):
            state = scene.step(twist(), crowd=people((3.0, 3.5 + 0.1 * k, 0.0, 1.0)))[0].state
        ways[name] = state.position[1] - 4.0
    assert ways["wheels"] > 0.0
    assert ways["holonomic"] > 0.0


def test_a_car_like_robot_steers_round_and_is_stopped(pushed, twist, turtlebot):
    base = Car(wheelbase=0.24, max_steering_angle=0.5, max_steering_rate=2.0)
    scene = pushed(Pose(x=3.0, y=4.0), world=CORRIDOR, model=dataclasses.replace(turtlebot, base=base))
    for _ in range(60):
        state = scene.step(twist(0.5, 0.5))[0].state
    assert state.angular_velocity == pytest.approx(0.5, rel=0.02)
    scene = pushed(Pose(x=48.5, y=4.0), world=CORRIDOR, model=dataclasses.replace(turtlebot, base=base))
    for _ in range(60):
        state = scene.step(twist(1.0))[0].state
    assert state.position == pytest.approx([50.0 - R, 4.0], abs=LATE)


def test_who_stands_over_the_robot_does_not_hold_it(pushed, twist, people):
    scene = pushed(Pose(x=3.0, y=4.0))
    for _ in range(10):
        state, contacts = scene.step(twist(1.0), crowd=people((3.0, 4.05, 0.0, 0.0)))[0]
        if len(contacts.kind) == 0:
            break
    assert state.position[0] > 3.2


def test_people_across_the_seam_are_touched(pushed, twist, people):
    scene = pushed(Pose(x=49.0, y=4.0), world=World(size=(50.0, 10.0), periodic=(True, False)))
    agents = set()
    for _ in range(20):
        agents.update(scene.step(twist(1.0), crowd=people((0.5, 4.0, 0.0, 0.0)))[0].contacts.agent.tolist())
    assert agents == {101}


def test_the_same_inputs_give_the_same_bits(pushed, twist, people):
    def run():
        rng = np.random.default_rng(7)
        scene = pushed(Pose(x=3.0, y=5.0), Pose(x=6.0, y=5.0, heading=math.pi), world=CORRIDOR)
        for _ in range(30):
            crowd = people(*rng.uniform((2, 4, -1, -1), (7, 6, 1, 1), (20, 4)))
            yield scene.step(twist(1.0, rng.normal()), twist(1.0, rng.normal()), crowd=crowd)

    assert list(run()) == list(run())


@pytest.mark.parametrize(("options", "text"), [({"grip": 0.0}, "grip is 0.0"), ({"grib": 1.0}, "grib")])
def test_wrong_options_are_refused(options, text):
    with pytest.raises(ValidationError, match=text):
        make(Forces, options)


@pytest.mark.parametrize("drive", [Forces(Config()), Wheels(WheelsConfig())], ids=["forces", "wheels"])
def test_the_robot_of_crowdcosim_check_has_the_measures_that_drives_need(drive):
    setup = Setup(component="robot", period=100_000_000, seed=1, world=STIMULI, robots=(SUBJECT,), robot="robot")
    assert drive.reset(setup).state.name == "robot"
