"""Whom a controller knows about, and that it looks at nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.controllers.dwa import DWA
from components.controllers.ego import ego_of
from components.controllers.mpc import MPC
from components.controllers.mppi import MPPI
from components.controllers.rvo import RVO
from components.controllers.sight import Sight
from components.controllers.social_force import SocialForce
from components.controllers.ttc import TTC
from crowdcosim.component import make
from crowdcosim.messages import Detections, Header, LaserScan, Time

ALL = [DWA, MPC, MPPI, RVO, SocialForce, TTC]


def reported(position, velocity=(0.0, 0.0), frame="robot/base_link", time=0.0, deviation=0.02) -> Detections:
    position = np.array(position, np.float64).reshape(-1, 2)
    n = len(position)
    stamp = Time(sec=int(time), nanosec=round(time % 1 * 1e9))
    return Detections(
        header=Header(stamp=stamp, frame_id=frame),
        track=np.zeros(n, np.uint32),
        position=position,
        velocity=np.broadcast_to(np.array(velocity, np.float64), (n, 2)),
        radius=np.full(n, 0.3),
        position_deviation=np.full(n, deviation),
        velocity_deviation=np.full(n, 0.0),
    )


def scan(scene, pose, people, beams=360, reach=8.0) -> LaserScan:
    """Exact ranges to discs of 0.3 m."""
    angles = -math.pi + math.tau / beams * np.arange(beams)
    d = np.array([np.cos(angles + pose[2]), np.sin(angles + pose[2])]).T
    ranges = np.full(beams, np.inf)
    for person in people:
        p = np.array(person) - pose[:2]
        along = d @ p
        square = 0.09 - (p @ p - along**2)
        hit = (square > 0) & (along > 0)
        ranges[hit] = np.minimum(ranges[hit], along[hit] - np.sqrt(square[hit]))
    ranges[ranges > reach] = np.inf
    return LaserScan(
        angle_min=-math.pi,
        angle_max=math.pi,
        angle_increment=math.tau / beams,
        range_min=0.1,
        range_max=reach,
        ranges=ranges.astype(np.float32),
    )


@pytest.mark.parametrize("controller", ALL)
def test_exact_detections_are_as_good_as_the_truth(scene, controller):
    odometry = scene.odometry(20.0, 5.0, 0.7, 0.8)
    ego = ego_of(odometry)
    cos, sin = math.cos(ego.heading), math.sin(ego.heading)
    turn = np.array([[cos, -sin], [sin, cos]])
    truth = scene.crowd((22.0, 5.2), (21.5, 6.5), velocity=(-1.0, 0.2))
    told = reported((truth.position - (20.0, 5.0)) @ turn, np.array((-1.0, 0.2)) @ turn)
    decisions = []
    for options, given in (({}, {"crowd": truth}), ({"people_from": "detections"}, {"detections": told})):
        component = make(controller, options)
        component.reset(scene.setup())
        result = component.step(odometry=odometry, goal=scene.line(), others=(), **given)
        twist = getattr(result, "twist", result)
        decisions.append((twist.linear.x, twist.angular.z))
    # Positions differ by rounding, 1e-15 m; solvers and linear programs magnify that.
    assert decisions[1] == pytest.approx(decisions[0], abs=1e-6)
    assert decisions[0] != (1.0, 0.0)


@pytest.mark.parametrize("controller", ALL)
def test_who_is_told_to_use_detections_never_looks_at_the_truth(scene, controller):
    decisions = []
    for crowd, others in ((None, ()), (scene.crowd((21.0, 5.1)), (scene.robot("other", 20.8, 4.9),))):
        component = make(controller, {"people_from": "detections"})
        component.reset(scene.setup())
        result = component.step(
            odometry=scene.odometry(20.0, 5.0, 0.0, 1.0),
            goal=scene.line(),
            crowd=crowd,
            others=others,
            detections=reported([]),
        )
        decisions.append(result)
    assert decisions[0] == decisions[1]


@pytest.mark.parametrize(("people_from", "missing"), [("truth", "Crowd"), ("detections", "Detections")])
@pytest.mark.parametrize("controller", ALL)
def test_what_is_asked_for_and_not_connected_is_named(scene, controller, people_from, missing):
    component = make(controller, {"people_from": people_from})
    component.reset(scene.setup())
    with pytest.raises(ValueError, match=f"people_from is '{people_from}'.*gives a {missing}"):
        component.step(odometry=scene.odometry(20.0, 5.0), goal=scene.line(), others=())


def test_a_frame_that_is_not_known_is_refused(scene):
    sight = Sight("detections", scene.setup())
    with pytest.raises(ValueError, match="in the frame 'robot/camera', expected map, odom or the robot's base_link"):
        sight.discs(ego_of(scene.odometry(1, 1)), Header(), None, (), reported([(1, 0)], frame="robot/camera"))


def test_detections_without_velocity_are_followed(scene):
    sight = Sight("detections", scene.setup())
    for k in range(30):
        x = 20.0 + 0.1 * k
        ego = ego_of(scene.odometry(x, 5.0, 0.3, 1.0))
        person = np.array([30.0 - 0.13 * k, 6.0]) - (x, 5.0)
        cos, sin = math.cos(0.3), math.sin(0.3)
        seen = reported(person @ np.array([[cos, -sin], [sin, cos]]), time=0.1 * k, deviation=0.01)
        discs = sight.discs(ego, seen.header, None, (), seen)
    np.testing.assert_allclose(discs.position, [(30.0 - 0.13 * 29, 6.0)], atol=0.02)
    np.testing.assert_allclose(discs.velocity, [(-1.3, 0.0)], atol=0.1)


def test_a_detection_that_is_held_is_counted_once(scene):
    sight, ego = Sight("detections", scene.setup()), ego_of(scene.odometry(0.0, 5.0))
    seen = reported([(3.0, 0.0)], time=0.0)
    for k in range(4):
        now = Header(stamp=Time(nanosec=k * 100_000_000))
        discs = sight.discs(ego, now, None, (), seen)
    assert len(discs.radius) == 1


def test_the_points_of_a_scan_lie_on_what_it_hit(scene):
    pose, people = (20.0, 5.0, 0.6), [(22.0, 5.5), (19.0, 3.0)]
    sight = Sight("scan", scene.setup())
    ego = ego_of(scene.odometry(*pose))
    discs = sight.discs(ego, Header(), None, (), None, scan(scene, pose, people))
    gap = np.min([np.hypot(*(discs.position - p).T) for p in people], axis=0)
    assert len(discs.radius) > 20
    # Ranges are 32-bit: 1e-7 of a few metres.
    np.testing.assert_allclose(gap, 0.3, atol=1e-6)
    assert not discs.velocity.any() and not discs.radius.any()


def test_what_is_too_near_to_measure_is_at_the_least_range(scene):
    sight, ego = Sight("scan", scene.setup()), ego_of(scene.odometry(20.0, 5.0))
    empty = scan(scene, (20.0, 5.0, 0.0), [])
    ranges = np.array(empty.ranges)
    ranges[180] = -np.inf
    near = LaserScan(angle_min=-math.pi, angle_increment=math.tau / 360, range_min=0.1, range_max=8.0, ranges=ranges)
    discs = sight.discs(ego, Header(), None, (), None, near)
    np.testing.assert_allclose(discs.position, [(20.1, 5.0)], atol=1e-6)


def test_dwa_passes_somebody_whom_only_its_laser_sees(scene):
    controller = make(DWA, {"people_from": "scan"})
    controller.reset(scene.setup())
    x, y, theta, v = 5.0, 5.0, 0.0, 0.0
    gap = math.inf
    for _ in range(250):
        odometry = scene.odometry(x, y, theta, v)
        twist = controller.step(odometry=odometry, goal=scene.line(12.0), scan=scan(scene, (x, y, theta), [(8.0, 5.1)]))
        v, omega = twist.linear.x, twist.angular.z
        theta += 0.1 * omega
        x, y = x + 0.1 * v * math.cos(theta), y + 0.1 * v * math.sin(theta)
        gap = min(gap, math.hypot(x - 8.0, y - 5.1) - 0.3 - scene.model.radius)
        if x >= 12.0:
            break
    assert x >= 12.0
    assert gap > 0.0


def test_a_mount_that_the_robot_does_not_have_is_refused(scene):
    with pytest.raises(ValueError, match="mount is 'hat', expected one of the robot's"):
        Sight("scan", scene.setup(), "hat")
