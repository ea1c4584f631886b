"""The variants of the benchmark's authors and of the literature."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.controllers.baseline import Baseline
from components.controllers.dwa_rollout import CrowdBotConfig, CrowdBotDWA, PythonRoboticsDWA
from components.controllers.rvo import RVO
from components.controllers.rvo_crowdbot import CrowdBotRVO
from crowdcosim.component import make


def command_of(cls, scene, odometry, crowd, goal=None, world=None, **options):
    controller = make(cls, options)
    controller.reset(scene.setup(world))
    given = {"odometry": odometry, "goal": goal or scene.line(1e6), "crowd": crowd, "others": ()}
    twist = controller.step(**{k: v for k, v in given.items() if cls is not Baseline or k in ("odometry", "goal")})
    return twist.linear.x, twist.angular.z


def test_the_authors_baseline_never_steers(scene):
    odometry = scene.odometry(5.0, 5.0, 1.0)
    assert command_of(Baseline, scene, odometry, None, steer=False) == (1.0, 0.0)
    assert command_of(Baseline, scene, odometry, None)[1] < 0.0


@pytest.mark.parametrize("theta", [-2.5, -1.0, 0.0, 0.4, 2.0])
def test_every_drive_of_rvo_follows_the_preferred_velocity_by_its_own_formula(scene, theta):
    """In an open world without people V is 1 m/s along x."""
    odometry, e, limit = scene.odometry(5.0, 5.0, theta), -theta, scene.model.max_angular_velocity
    expected = {
        "brake": (max(0.0, math.cos(e)), 2 * e),
        "nh_orca": (e * math.sin(e) / (2 * (1 - math.cos(e))) if e else 1.0, e / 0.4),
        "orca_dd": (math.cos(e), math.sin(e) / 0.15),
        "heading": (1.0, e),
    }
    for drive, (v, omega) in expected.items():
        found = command_of(RVO, scene, odometry, scene.crowd(), world=scene.open, drive=drive)
        assert found == pytest.approx((v, max(-limit, min(limit, omega))), abs=1e-9)


def test_the_arc_of_nh_orca_ends_where_the_wished_way_does(scene):
    theta, T = 0.7, 0.4
    v, omega = command_of(RVO, scene, scene.odometry(5, 5, theta), scene.crowd(), world=scene.open, drive="nh_orca")
    x = v / omega * (math.sin(theta + omega * T) - math.sin(theta))
    y = v / omega * (math.cos(theta) - math.cos(theta + omega * T))
    # Its heading is that of V, and it has come as far along V as the best arc can: the error is across only.
    assert theta + omega * T == pytest.approx(0.0, abs=1e-9)
    assert abs(y) < 0.2 and 0.0 < x <= T


def test_a_crowd_that_comes_makes_the_other_drives_back_away_and_brake_not(scene):
    rows = [(x, y) for x in (7.0, 7.8, 8.6) for y in np.arange(0.5, 10.0, 0.7)]
    crowd = scene.crowd(*rows, velocity=(-1.3, 0.0))
    odometry = scene.odometry(6.0, 5.0, 0.0, 0.2)
    assert command_of(RVO, scene, odometry, crowd)[0] >= 0.0
    v, _ = command_of(RVO, scene, odometry, crowd, drive="orca_dd")
    assert v < -0.1
    _, omega = command_of(CrowdBotRVO, scene, odometry, crowd)
    assert abs(omega) > 1.5


def test_the_authors_rvo_keeps_off_as_if_bodies_were_wide(scene):
    """0.4 m and 0.41 m where truly 0.177 m and 0.3 m: somebody who passes at 0.6 m is in the way."""
    odometry, crowd = scene.odometry(20.0, 5.0, 0.0, 1.0), scene.crowd((24.0, 5.6), velocity=(-1.0, 0.0))
    assert command_of(RVO, scene, odometry, crowd) == (1.0, 0.0)
    assert command_of(CrowdBotRVO, scene, odometry, crowd)[1] < 0.0


def by_hand(scene, config, odometry, crowd, goal):
    """The authors' objective over their grid, as plain loops."""
    v0, w0 = odometry.twist.twist.linear.x, odometry.twist.twist.angular.z
    theta0 = 2 * math.atan2(odometry.pose.pose.orientation.z, odometry.pose.pose.orientation.w)
    at = np.array([odometry.pose.pose.position.x, odometry.pose.pose.position.y])
    low = max(config.min_speed, v0 - 0.1 * config.max_acceleration)
    high = min(config.max_speed, v0 + 0.1 * config.max_acceleration)
    right = max(-config.max_turn_rate, w0 - 0.1 * config.max_angular_acceleration)
    left = min(config.max_turn_rate, w0 + 0.1 * config.max_angular_acceleration)
    best = (math.inf, 0.0, 0.0)
    for v in np.arange(low, high + 1e-9, config.speed_resolution):
        for w in np.arange(right, left + 1e-9, config.turn_rate_resolution):
            theta = theta0 + w * 0.1 * np.arange(1, 31)
            way = at + np.cumsum(0.1 * v * np.stack([np.cos(theta), np.sin(theta)], axis=1), axis=0)
            d = np.hypot(*(way[:, None] - crowd.position).transpose(2, 0, 1)).min()
            if d < config.contact:
                continue
            to_goal = goal - way[-1]
            e = abs(math.remainder(math.atan2(to_goal[1], to_goal[0]) - theta[-1], math.tau))
            obstacle = 1 / d if d <= (config.sight or math.inf) else 0.0
            cost = config.goal_gain * e + config.speed_gain * (config.max_speed - v) + config.obstacle_gain * obstacle
            if cost < best[0] - 1e-12:
                best = (cost, v, w)
    return best


def test_the_authors_dwa_takes_the_least_of_its_objective(scene):
    coarse = {"turn_rate_resolution": 0.2, "speed_resolution": 0.02}
    config = CrowdBotConfig(**coarse)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        crowd = scene.crowd(*map(tuple, rng.uniform([22, 3], [28, 7], (5, 2))))
        odometry = scene.odometry(24.0, 5.0, rng.uniform(-1, 1), rng.uniform(0, 1), rng.uniform(-0.5, 0.5))
        goal = scene.disc(30.0, 6.0)
        _, v, w = by_hand(scene, config, odometry, crowd, goal.position)
        found = command_of(CrowdBotDWA, scene, odometry, crowd, goal, scene.open, **coarse)
        if abs(v) > 1e-3:
            assert found == pytest.approx((v, w), abs=1e-9)


def test_python_robotics_dwa_accelerates_as_slowly_as_its_settings(scene):
    v, omega = command_of(PythonRoboticsDWA, scene, scene.odometry(5, 5, 0.0, 0.5), scene.crowd(), world=scene.open)
    assert v == pytest.approx(0.52)
    assert abs(omega) <= math.radians(4.0) + 1e-9


@pytest.mark.parametrize("cls", [CrowdBotDWA, PythonRoboticsDWA])
def test_a_stuck_dwa_turns(scene, cls):
    crowd = scene.crowd(*[(5.0 + 0.5 * math.cos(a), 5.0 + 0.5 * math.sin(a)) for a in np.arange(0, 6.2, 0.3)])
    v, omega = command_of(cls, scene, scene.odometry(5.0, 5.0), crowd, contact=1.0)
    assert v == 0.0
    assert omega < 0.0


@pytest.mark.parametrize(("option", "value"), [("step", 0.0), ("goal_gain", -1.0), ("min_speed", 0.1)])
def test_options_of_the_authors_dwa_that_mean_nothing_are_refused(option, value):
    with pytest.raises(ValueError, match=rf"{option} is .*, expected"):
        CrowdBotConfig(**{option: value})
