"""What a LiDAR sees in scenes that can be worked out by hand, and its noise.

People of 1.75 m are scanned at the height of their heads, unless a test says otherwise: there the body is an upright
cylinder, 0.084 m in radius, with its axis 17.5 mm ahead of the person's position.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.sensors.imperfections import Dropout, Gaussian, MixedPixels
from components.sensors.lidar import Config, Lidar
from crowdcosim.avatar import pose
from crowdcosim.body import SEGMENTS
from crowdcosim.component import make, ports_of
from crowdcosim.message import check_finite
from crowdcosim.messages import BeamAgents, LaserScan
from crowdcosim.obstacles import Box, Disc
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World

OPEN = World(size=(50.0, 50.0))
EYES, HEAD, AHEAD = 1.62, 0.048 * 1.75, 0.010 * 1.75
FLOAT32 = 1e-6  # relative precision of a range


def box(width, height, **options):
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    walls = tuple(Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    return World(size=(width, height), walls=walls, **options)


@pytest.fixture
def lidar(setup):
    def build(world=OPEN, seed=1, position=(0.0, 0.0, EYES), yaw=0.0, **options):
        sensor = Lidar(Config(mount=Mount(position=position, yaw=yaw), **options))
        sensor.reset(setup(world, seed=seed))
        return sensor

    return build


def gaussian(deviation):
    return (Gaussian(kind="gaussian", deviation=deviation),)


def at(scan, angle):
    """Index of the beam at `angle` [rad] from ahead."""
    return round((angle - scan.angle_min) / scan.angle_increment)


def test_a_head_is_the_cylinder_that_the_scenes_are_worked_out_with(people):
    crowd = people((3.0, 2.0))
    *ends, radius = pose(crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)[
        0, SEGMENTS.index("head")
    ]
    assert ends[0:2] == ends[3:5] == pytest.approx([3.0 + AHEAD, 2.0], abs=1e-12)
    assert min(ends[2], ends[5]) < EYES < max(ends[2], ends[5])
    assert radius == pytest.approx(HEAD)


def test_ports_are_those_that_scenarios_wire():
    ports = ports_of(Lidar)
    assert [port.name for port in ports.inputs] == ["robot", "crowd", "others"]
    assert [(port.name, port.type) for port in ports.outputs] == [("scan", LaserScan), ("agents", BeamAgents)]


def test_options_come_from_a_scenario():
    lidar = make(Lidar, {"beams": 541, "field_of_view": 4.7, "mount": {"position": [0.1, 0.0, 0.2]}})
    assert lidar.config.mount == Mount(position=(0.1, 0.0, 0.2))
    lidar = make(Lidar, {"imperfections": [{"kind": "dropout", "probability": 0.1}, {"kind": "mixed_pixels"}]})
    assert lidar.config.imperfections == (Dropout(kind="dropout", probability=0.1), MixedPixels(kind="mixed_pixels"))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("beams", 1),
        ("field_of_view", 0.0),
        ("field_of_view", 6.3),
        ("range_min", -0.1),
        ("range_max", 0.1),
        ("rate", 0.0),
    ],
)
def test_options_without_meaning_are_refused(option, value):
    with pytest.raises(ValueError, match=r"is .*, expected"):
        Config(**{option: value})


def test_an_empty_world_is_seen_as_nothing(lidar, robot, people):
    scan, agents = lidar().step(robot(5.0, 5.0, 1.0), people(), ())
    assert np.all(scan.ranges == np.inf)
    assert not agents.kind.any()
    assert not agents.agent.any()
    check_finite(scan)


def test_header_and_limits_are_those_of_the_scan(lidar, robot, people):
    scan, agents = lidar(beams=360, range_max=8.0).step(robot(5.0, 5.0, nanoseconds=1_300_000_000), people(), ())
    assert (scan.header.stamp.sec, scan.header.stamp.nanosec) == (1, 300_000_000)
    assert scan.header.frame_id == "robot1/sensor"
    assert agents.header == scan.header
    assert len(scan.ranges) == len(agents.kind) == 360
    assert scan.range_max == 8.0
    assert scan.range_min == scan.scan_time == np.float32(0.1)


@pytest.mark.parametrize("field_of_view", [2 * math.pi, 6.2832, 6.283])
def test_a_full_circle_has_no_direction_twice(lidar, robot, people, field_of_view):
    scan, _ = lidar(beams=720, field_of_view=field_of_view).step(robot(5.0, 5.0), people(), ())
    angles = scan.angle_min + scan.angle_increment * np.arange(720)
    assert scan.angle_min == pytest.approx(-math.pi)
    assert angles[-1] == pytest.approx(scan.angle_max, abs=1e-5)
    assert angles[-1] + scan.angle_increment - angles[0] == pytest.approx(2 * math.pi, abs=1e-5)


def test_a_partial_view_spans_its_angle_from_end_to_end(lidar, robot, people):
    crowd = people((5 + 3 * math.cos(2.0), 5 + 3 * math.sin(2.0)), (5 + 3 * math.cos(2.0), 5 - 3 * math.sin(2.0)))
    scan, agents = lidar(beams=401, field_of_view=4.0).step(robot(5.0, 5.0), crowd, ())
    assert (scan.angle_min, scan.angle_max) == (-2.0, 2.0)
    assert agents.agent[[0, -1]].tolist() == [102, 101]


@pytest.mark.parametrize("heading", [0.0, 1.0, math.pi, -2.5, 40.0])
def test_a_person_is_seen_at_their_surface_and_in_their_direction(lidar, robot, people, heading):
    direction = heading + math.pi / 3
    crowd = people((5.0 + 4.0 * math.cos(direction), 5.0 + 4.0 * math.sin(direction)), heading=direction)
    scan, agents = lidar().step(robot(5.0, 5.0, heading), crowd, ())
    beam = at(scan, math.pi / 3)
    assert scan.ranges[beam] == pytest.approx(4.0 + AHEAD - HEAD, rel=FLOAT32)
    assert (agents.kind[beam], agents.agent[beam]) == (BeamAgents.PERSON, 101)
    assert agents.body_part[beam] == BeamAgents.UPPER_BODY
    # Half the angle under which a disc appears is asin(r / d).
    angle = 2 * math.asin(HEAD / (4.0 + AHEAD))
    assert np.count_nonzero(agents.kind) == pytest.approx(angle / scan.angle_increment, abs=1)


@pytest.mark.parametrize(
    ("height", "part"),
    [
        (0.03, BeamAgents.FEET),
        (0.3, BeamAgents.LOWER_LEGS),
        (0.7, BeamAgents.UPPER_LEGS),
        (1.3, BeamAgents.UPPER_BODY),
    ],
)
def test_each_height_sees_its_part_of_the_body(lidar, robot, people, height, part):
    _, agents = lidar(position=(0.0, 0.0, height)).step(robot(5.0, 5.0), people((6.0, 5.0)), ())
    # The hands of somebody who stands are beside the thighs.
    assert set(agents.body_part.tolist()) - {BeamAgents.NO_PART} == {part} | (
        {BeamAgents.UPPER_BODY} if height == 0.7 else set()
    )
    np.testing.assert_array_equal(agents.kind == BeamAgents.PERSON, agents.body_part != BeamAgents.NO_PART)


def test_nobody_is_seen_above_their_head(lidar, robot, people):
    _, agents = lidar(position=(0.0, 0.0, 1.76)).step(robot(5.0, 5.0), people((6.0, 5.0)), ())
    assert not agents.kind.any()


def test_between_the_legs_of_somebody_who_stands_one_sees_what_is_behind(lidar, robot, people):
    """Shanks are 0.049 m thick and, at the ankle, 0.094 m to either side: 0.09 m are free between them."""
    sensor = lidar(position=(0.0, 0.0, 0.2))
    scan, agents = sensor.step(robot(5.0, 5.0), people((7.0, 5.0), (9.0, 5.1)), ())
    assert agents.agent[at(scan, 0.0)] == 102
    for side in (-1, 1):
        beam = at(scan, side * math.atan2(0.094, 2.0))
        assert agents.agent[beam] == 101
        assert scan.ranges[beam] == pytest.approx(2.0 - 0.049, abs=0.02)  # shanks lean by that


def test_the_legs_of_somebody_who_walks_move_through_the_scan(lidar, robot, people):
    """From the side, 2 m away, at 1.3 m/s: legs are nearly a stride times the duty apart, and pass each other."""
    sensor = lidar(position=(0.0, 0.0, 0.15))
    spans = []
    for phase in np.linspace(0.0, 1.0, 40):
        standing = people((5.0, 7.0))
        crowd = dataclasses.replace(standing, velocity=[(1.3, 0.0)], gait_phase=[phase])
        scan, agents = sensor.step(robot(5.0, 5.0), crowd, ())
        seen = np.flatnonzero(agents.agent == 101)
        angles = scan.angle_min + scan.angle_increment * seen
        spans.append(np.ptp(scan.ranges[seen] * np.cos(angles)))
    assert max(spans) == pytest.approx(0.7, abs=0.2)
    assert min(spans) < 0.25


def test_mount_and_yaw_move_the_scan(lidar, robot, people):
    """1 m ahead of and 0.5 m left of a robot that looks along y, the scanner looks back."""
    sensor = lidar(position=(1.0, 0.5, EYES), yaw=math.pi)
    scan, agents = sensor.step(robot(5.0, 5.0, math.pi / 2), people((4.5, 2.0), heading=math.pi / 2), ())
    beam = at(scan, 0.0)
    assert agents.agent[beam] == 101
    assert scan.ranges[beam] == pytest.approx(6.0 - 2.0 - AHEAD - HEAD, rel=FLOAT32)


def test_inside_a_person_every_beam_is_too_near(lidar, robot, people):
    scan, agents = lidar(box(20.0, 10.0)).step(robot(5.0, 5.0), people((5.02, 5.03), (5.6, 5.0)), ())
    assert np.all(scan.ranges == -np.inf)
    assert set(agents.agent.tolist()) == {101}
    check_finite(scan)


def test_too_near_is_minus_infinity_and_still_says_who(lidar, robot, people):
    scan, agents = lidar().step(robot(5.0, 5.0), people((5.15, 5.0)), ())
    beam = at(scan, 0.0)
    assert scan.ranges[beam] == -np.inf
    assert agents.agent[beam] == 101


def test_too_far_is_infinity_and_nobody(lidar, robot, people):
    scan, agents = lidar(range_max=4.0).step(robot(5.0, 5.0), people((9.0 + HEAD - AHEAD + 1e-3, 5.0)), ())
    assert np.all(scan.ranges == np.inf)
    assert not agents.kind.any()
    scan, agents = lidar(range_max=4.0).step(robot(5.0, 5.0), people((9.0 + HEAD - AHEAD - 1e-3, 5.0)), ())
    assert agents.agent[at(scan, 0.0)] == 101


def test_walls_and_people_hide_what_is_behind_them(lidar, robot, people):
    world = World(size=(50.0, 50.0), walls=(Wall(start=(7.0, 4.0), end=(7.0, 6.0)),))
    scan, agents = lidar(world).step(robot(5.0, 5.0), people((9.0, 5.0), (2.0, 5.0), (1.0, 5.0)), ())
    ahead, behind = at(scan, 0.0), 0
    assert (agents.kind[ahead], agents.agent[ahead]) == (BeamAgents.WALL, 1)
    assert scan.ranges[ahead] == pytest.approx(2.0, rel=FLOAT32)
    assert agents.agent[behind] == 102


def test_other_robots_are_seen_by_their_number_if_they_are_high_enough(lidar, robot, people):
    others = (robot(8.0, 5.0, number=2), robot(2.0, 5.0, number=3))
    scan, agents = lidar(position=(0.0, 0.0, 0.3)).step(robot(5.0, 5.0), people(), others)
    assert not agents.body_part.any()
    assert (agents.kind[at(scan, 0.0)], agents.agent[at(scan, 0.0)]) == (BeamAgents.ROBOT, 2)
    assert not np.any(agents.agent == 3)  # 0.2 m high
    assert scan.ranges[at(scan, 0.0)] == pytest.approx(3.0 - 0.177, rel=FLOAT32)


def test_a_person_across_the_seam_is_seen(lidar, robot, people):
    seam = World(size=(50.0, 10.0), periodic=(True, False))
    scan, agents = lidar(seam).step(robot(49.0, 5.0), people((1.0, 5.0)), ())
    assert agents.agent[at(scan, 0.0)] == 101
    assert scan.ranges[at(scan, 0.0)] == pytest.approx(2.0 + AHEAD - HEAD, rel=FLOAT32)


def test_a_long_range_sees_several_images_of_one_person(lidar, robot, people):
    """Period 4 m, robot at 1 m, person at 3 m: images 2 and 6 m ahead and behind, and the nearer hides the farther."""
    world = World(size=(50.0, 4.0), periodic=(False, True))
    crowd, own = people((6.0 - AHEAD, 3.0)), robot(5.0, 1.0, math.pi / 2)
    scan, agents = lidar(world, range_max=10.0).step(own, crowd, ())
    for ahead in (-6, -2, 2, 6):
        angle = math.atan2(-1.0, ahead)
        assert agents.agent[at(scan, angle)] == 101
        # The beam misses the axis by at most half the beam spacing, 0.027 m at 6 m, and is then 4 mm longer.
        assert scan.ranges[at(scan, angle)] == pytest.approx(math.hypot(1.0, ahead) - HEAD, abs=0.006)
    scan, agents = lidar(world, range_max=1.8).step(own, crowd, ())
    assert not agents.kind.any()


@settings(max_examples=100, deadline=None)
@given(x=st.floats(0.01, 7.99), y=st.floats(0.01, 4.99), heading=st.floats(-10, 10))
def test_no_beam_leaves_a_closed_room(setup, robot, people, x, y, heading):
    sensor = Lidar(Config(range_min=0.0))
    sensor.reset(setup(box(8.0, 5.0)))
    scan, agents = sensor.step(robot(x, y, heading), people(), ())
    assert np.all(agents.kind == BeamAgents.WALL)
    angles = heading - math.pi + 2 * math.pi / 720 * np.arange(720)
    with np.errstate(divide="ignore"):
        along = np.abs(np.where(np.cos(angles) > 0, 8.0 - x, -x) / np.cos(angles))
        across = np.abs(np.where(np.sin(angles) > 0, 5.0 - y, -y) / np.sin(angles))
    np.testing.assert_allclose(scan.ranges, np.minimum(along, across), rtol=1e-5)


def test_a_corner_looked_at_exactly_is_closed(lidar, robot, people):
    scan, _ = lidar(box(8.0, 8.0)).step(robot(4.0, 4.0), people(), ())
    for angle in (-3, -1, 1, 3):
        assert scan.ranges[at(scan, angle * math.pi / 4)] == pytest.approx(4 * math.sqrt(2), rel=1e-5)


def test_noise_has_the_stated_deviation_and_no_bias(lidar, robot, people):
    """Of n = 72,000 errors the mean is within 5 sigma / sqrt(n), the deviation within 5 sigma / sqrt(2 n) of it.

    Either fails for one seed in a million.
    """
    world, sigma = box(8.0, 5.0), 0.02
    true = lidar(world).step(robot(4.0, 2.5), people(), ())[0].ranges
    sensor = lidar(world, imperfections=gaussian(sigma))
    scans = [sensor.step(robot(4.0, 2.5, nanoseconds=k * 100_000_000), people(), ())[0].ranges for k in range(100)]
    errors = np.array(scans, np.float64) - true
    n = errors.size
    assert abs(errors.mean()) < 5 * sigma / math.sqrt(n)
    assert abs(errors.std() - sigma) < 5 * sigma / math.sqrt(2 * n)
    # Neither neighbouring beams nor successive scans share their noise: correlations are within 5 / sqrt(n).
    assert abs(np.corrcoef(errors[:, 1:].ravel(), errors[:, :-1].ravel())[0, 1]) < 5 / math.sqrt(n)
    assert abs(np.corrcoef(errors[1:].ravel(), errors[:-1].ravel())[0, 1]) < 5 / math.sqrt(n)


def test_noise_depends_on_seed_and_time_only(lidar, robot, people):
    def ranges(sensor, tick):
        return sensor.step(robot(4.0, 2.5, nanoseconds=tick * 100_000_000), people(), ())[0].ranges.tolist()

    world = box(8.0, 5.0)
    sensor = lidar(world, imperfections=gaussian(0.02))
    scans = [ranges(sensor, tick) for tick in range(5)]
    assert ranges(lidar(world, imperfections=gaussian(0.02)), 4) == scans[4]
    assert ranges(lidar(world, imperfections=gaussian(0.02), seed=2), 4) != scans[4]
    assert len({tuple(scan) for scan in scans}) == 5


def test_noise_never_makes_a_range_that_the_device_does_not_measure(lidar, robot, people):
    sensor = lidar(box(8.0, 5.0), imperfections=gaussian(0.3), range_min=2.4, range_max=4.0)
    for tick in range(10):
        scan, agents = sensor.step(robot(4.0, 2.5, nanoseconds=tick * 100_000_000), people(), ())
        assert np.any(scan.ranges == -np.inf)
        measured = scan.ranges[np.isfinite(scan.ranges)]
        assert np.all((scan.range_min <= measured) & (measured <= scan.range_max))
        np.testing.assert_array_equal(scan.ranges == np.inf, agents.kind == BeamAgents.NOTHING)
        np.testing.assert_array_equal(agents.kind == BeamAgents.NOTHING, agents.agent == 0)
        np.testing.assert_array_equal(agents.kind == BeamAgents.PERSON, agents.body_part != BeamAgents.NO_PART)


def test_who_is_hit_is_told_by_the_line_of_sight_and_nobody_by_a_beam_that_is_lost(lidar, robot, people):
    """Errors that move ranges leave identities alone; a dropped beam says nobody."""
    crowd, own = people((6.0, 5.2), (7.0, 4.5), (8.0, 5.0)), robot(5.0, 5.0)
    true, agents = lidar(box(10.0, 10.0)).step(own, crowd, ())
    spikes = (MixedPixels(kind="mixed_pixels", probability=1.0), *gaussian(0.05))
    scan, noisy = lidar(box(10.0, 10.0), imperfections=spikes).step(own, crowd, ())
    assert np.count_nonzero(np.abs(scan.ranges - true.ranges) > 0.3) >= 4
    np.testing.assert_array_equal(noisy.agent, agents.agent)
    np.testing.assert_array_equal(noisy.body_part, agents.body_part)
    dropout = (Dropout(kind="dropout", probability=0.5),)
    scan, left = lidar(box(10.0, 10.0), imperfections=dropout).step(own, crowd, ())
    lost = scan.ranges == np.inf
    assert 300 < np.count_nonzero(lost) < 420
    assert not left.kind[lost].any() and not left.agent[lost].any() and not left.body_part[lost].any()
    np.testing.assert_array_equal(left.agent[~lost], agents.agent[~lost])


@pytest.mark.parametrize("field_of_view", [2 * math.pi, 4.0])
def test_a_clockwise_scan_has_the_same_beams_in_the_other_order(lidar, robot, people, field_of_view):
    crowd, own = people((6.0, 5.5), (3.0, 8.0), (5.0, 3.0)), robot(5.0, 5.0, 0.3)
    left, left_agents = lidar(box(10.0, 10.0), field_of_view=field_of_view).step(own, crowd, ())
    right, right_agents = lidar(box(10.0, 10.0), field_of_view=field_of_view, clockwise=True).step(own, crowd, ())
    assert right.angle_increment == -left.angle_increment
    assert right.angle_max == pytest.approx(right.angle_min + 719 * right.angle_increment, abs=1e-5)

    def by_angle(scan, values):
        angles = scan.angle_min + scan.angle_increment * np.arange(720)
        turns = np.rint((angles + math.pi) / abs(scan.angle_increment)).astype(int) % 720
        return dict(zip(turns.tolist(), values.tolist(), strict=True))

    if field_of_view == 4.0:
        np.testing.assert_array_equal(right.ranges, left.ranges[::-1])
        np.testing.assert_array_equal(right_agents.agent, left_agents.agent[::-1])
    else:  # All around, beam 0 is behind in both.
        ranges, expected = by_angle(right, right.ranges), by_angle(left, left.ranges)
        assert ranges == pytest.approx(expected, rel=1e-6)
        assert by_angle(right, right_agents.agent) == by_angle(left, left_agents.agent)


def test_nothing_may_be_told_as_the_farthest_range(lidar, robot, people):
    scan, agents = lidar(no_hit="range_max", range_max=8.0).step(robot(5.0, 5.0), people((8.0, 5.0)), ())
    assert scan.ranges.max() == 8.0
    np.testing.assert_array_equal(scan.ranges == 8.0, agents.kind == BeamAgents.NOTHING)


def test_obstacles_are_seen_if_they_are_as_high_as_the_scanner(lidar, robot, people):
    low = Box(shape="box", centre=(7.0, 5.0), size=(0.2, 2.0), height=0.4)
    pillar = Disc(shape="disc", centre=(9.0, 5.0), radius=0.3)
    world = World(size=(50.0, 50.0), obstacles=(low, pillar))
    scan, agents = lidar(world, position=(0.0, 0.0, 0.5)).step(robot(5.0, 5.0), people(), ())
    assert (agents.kind[at(scan, 0.0)], agents.agent[at(scan, 0.0)]) == (BeamAgents.WALL, 2)
    assert scan.ranges[at(scan, 0.0)] == pytest.approx(3.7, abs=0.0015)  # a polygon of 32 edges around the disc
    scan, agents = lidar(world, position=(0.0, 0.0, 0.3)).step(robot(5.0, 5.0), people(), ())
    assert agents.agent[at(scan, 0.0)] == 1
    assert scan.ranges[at(scan, 0.0)] == pytest.approx(1.9, rel=FLOAT32)


def test_scans_come_at_their_rate_and_bear_the_time_at_which_they_were_taken(lidar, robot, people):
    sensor = lidar(rate=5.0)
    stamps = []
    for tick in range(6):
        own = robot(5.0 + 0.1 * tick, 5.0, nanoseconds=tick * 100_000_000)
        scan, agents = sensor.step(own, people((8.0, 5.0)), ())
        stamps.append(scan.header.stamp.nanosec)
        assert agents.header == scan.header
        assert scan.ranges[at(scan, 0.0)] == pytest.approx(3.0 - 0.1 * (tick // 2 * 2) + AHEAD - HEAD, rel=FLOAT32)
    assert stamps == [0, 0, 200_000_000, 200_000_000, 400_000_000, 400_000_000]
    assert scan.scan_time == np.float32(0.2)


def test_a_mount_of_the_robots_own_is_found_by_name(setup, robot, people):
    scenario_setup = setup(OPEN)
    model = dataclasses.replace(
        scenario_setup.own_robot.model, mounts={"mast": Mount(position=(1.0, 0.5, EYES), yaw=math.pi)}
    )
    me = dataclasses.replace(scenario_setup.own_robot, model=model)
    sensor = Lidar(Config(mount="mast"))
    sensor.reset(dataclasses.replace(scenario_setup, robots=(me, *scenario_setup.robots[1:])))
    scan, agents = sensor.step(robot(5.0, 5.0, math.pi / 2), people((4.5, 2.0), heading=math.pi / 2), ())
    assert agents.agent[at(scan, 0.0)] == 101
    with pytest.raises(ValueError, match=r"mount is 'mats', expected one of the robot's \(mast\)"):
        Lidar(Config(mount="mats")).reset(dataclasses.replace(scenario_setup, robots=(me,)))


def test_a_mount_that_is_not_level_is_refused(setup):
    with pytest.raises(ValueError, match="pitch of 0.1, expected 0"):
        Config(mount=Mount(position=(0.0, 0.0, 1.0), pitch=0.1))
