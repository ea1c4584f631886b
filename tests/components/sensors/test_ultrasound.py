"""Ultrasound tells the nearest thing in each cone, in scenes that can be worked out by hand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from components.sensors.imperfections import Dropout, Quantisation
from components.sensors.lidar import Config as LidarConfig
from components.sensors.lidar import Lidar
from components.sensors.ultrasound import Config, Ring, Ultrasound
from crowdcosim.component import make
from crowdcosim.message import check_finite
from crowdcosim.messages import BeamAgents, Range
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World

OPEN = World(size=(50.0, 50.0))
ROOM = World(
    size=(50.0, 50.0),
    walls=tuple(
        Wall(start=a, end=b)
        for a, b in [((0, 0), (50, 0)), ((50, 0), (50, 50)), ((50, 50), (0, 50)), ((0, 50), (0, 0))]
    ),
)


@pytest.fixture
def sonar(setup):
    def build(world=OPEN, **options):
        sensor = Ultrasound(Config(**options))
        sensor.reset(setup(world))
        return sensor

    return build


def told(output):
    return np.array([reading.range for reading in output.ranges.ranges])


def test_twelve_are_spread_evenly_around_the_robot_and_have_frames_of_their_own(sonar, setup, robot, people):
    output = sonar(ROOM).step(robot(2.0, 3.0, math.pi / 6, nanoseconds=500_000_000), people(), ())
    assert len(output.ranges.ranges) == len(output.agents.kind) == 12
    assert [r.header.frame_id for r in output.ranges.ranges] == [f"robot1/sensor/{i}" for i in range(12)]
    assert {r.radiation_type for r in output.ranges.ranges} == {Range.ULTRASOUND}
    assert output.ranges.header.frame_id == "robot1/base_link"
    assert output.ranges.ranges[3].header.stamp.nanosec == 500_000_000
    mounts = Config().frames(setup(OPEN).own_robot.model)
    assert [round(math.degrees(mount.yaw)) for mount in mounts.values()] == list(range(0, 360, 30))
    for mount in mounts.values():
        assert mount.position[:2] == pytest.approx((0.177 * math.cos(mount.yaw), 0.177 * math.sin(mount.yaw)))


def test_a_wall_is_as_far_as_the_nearest_side_of_the_cone_is_from_it(sonar, robot, people):
    """Wall 2 m behind the robot: straight back 2 - 0.177; 30 degrees off, the cone's side is 22.5 degrees off."""
    ranges = told(sonar(ROOM).step(robot(2.0, 25.0), people(), ()))
    assert ranges[6] == pytest.approx(2.0 - 0.177, rel=1e-6)
    for i in (5, 7):
        expected = (2.0 - 0.177 * math.cos(math.radians(30))) / math.cos(math.radians(22.5))
        assert ranges[i] == pytest.approx(expected, rel=1e-6)
    assert np.all(ranges[[0, 1, 2, 3, 9, 10, 11]] == np.inf)


def test_a_person_is_told_by_distance_and_by_the_truth_about_who_it_is(sonar, robot, people):
    output = sonar(mounts=Ring(count=12, height=1.62)).step(robot(5.0, 5.0), people((5.0, 7.0), (5.0, 7.5)), ())
    ranges = told(output)
    # The head's axis is 17.5 mm ahead, its radius 84 mm.
    assert ranges[3] == pytest.approx(math.hypot(2.0 - 0.177, 0.0175) - 0.084, abs=1e-4)
    assert (output.agents.kind[3], output.agents.agent[3]) == (BeamAgents.PERSON, 101)
    assert np.count_nonzero(np.isfinite(ranges)) == 1
    check_finite(output.ranges)


def test_other_robots_and_people_across_the_seam_are_seen(sonar, robot, people):
    seam = World(size=(50.0, 10.0), periodic=(True, False))
    output = sonar(seam).step(robot(49.5, 5.0), people((1.5, 5.0)), (robot(48.0, 5.0, number=2),))
    assert (output.agents.kind[0], output.agents.agent[0]) == (BeamAgents.PERSON, 101)
    assert (output.agents.kind[6], output.agents.agent[6]) == (BeamAgents.ROBOT, 2)
    assert told(output)[6] == pytest.approx(1.5 - 2 * 0.177, abs=1e-6)


def test_too_near_is_minus_infinity_and_within_somebody_too(sonar, robot, people):
    output = sonar(mounts=Ring(count=4, height=1.62)).step(robot(5.0, 5.0), people((5.0, 5.177)), ())
    assert told(output)[1] == -np.inf
    assert output.agents.agent[1] == 101


def test_it_equals_the_nearest_beam_of_a_lidar_at_each_place(setup, robot, people):
    """The rays of a cone are those of a scan; culling for the ring changes nothing."""
    rng = np.random.default_rng(5)
    world = World(size=(20.0, 10.0), periodic=(True, True), walls=(Wall(start=(3.0, 0.0), end=(3.0, 10.0)),))
    crowd = dataclasses.replace(
        people(*rng.uniform((0, 0), (20, 10), (60, 2))), velocity=rng.uniform(-1, 1, (60, 2)), gait_phase=rng.random(60)
    )
    ring = Ultrasound(Config(mounts=Ring(count=12, height=0.15)))
    ring.reset(setup(world))
    seen = 0
    for own in (robot(19.0, 9.0, 0.4), robot(2.0, 0.5, -2.0), robot(10.0, 5.0, 1.0)):
        output = ring.step(own, crowd, (robot(9.0, 4.0, number=2),))
        for mount, reading, kind, agent in zip(
            ring.config.frames(setup(world).own_robot.model).values(),
            told(output),
            output.agents.kind,
            output.agents.agent,
            strict=True,
        ):
            options = LidarConfig(mount=mount, beams=45, field_of_view=math.radians(15), range_min=0.02, range_max=4.0)
            lidar = Lidar(options)
            lidar.reset(setup(world))
            scan, agents = lidar.step(own, crowd, (robot(9.0, 4.0, number=2),))
            k = np.argmin(scan.ranges)
            assert (reading, kind, agent) == (scan.ranges[k], agents.kind[k], agents.agent[k])
            seen += kind == BeamAgents.PERSON
    assert seen > 5


def test_imperfections_apply_to_each_range_finder(sonar, robot, people):
    kinds = (Quantisation(kind="quantisation", step=0.1), Dropout(kind="dropout", probability=0.5))
    sensor, steps = sonar(ROOM, imperfections=kinds), 200
    all_ranges = []
    for tick in range(steps):
        output = sensor.step(robot(2.0, 2.0, nanoseconds=tick * 100_000_000), people(), ())
        all_ranges.append(told(output))
        np.testing.assert_array_equal(np.isinf(all_ranges[-1]), output.agents.kind == BeamAgents.NOTHING)
    facing = np.array(all_ranges)[:, [6, 9]]  # the two walls straight ahead of a cone
    assert set(facing[np.isfinite(facing)]) == {np.float32(1.8)}
    assert np.count_nonzero(np.isfinite(facing)) == pytest.approx(steps, abs=5 * math.sqrt(steps / 2))


def test_mounts_come_from_a_scenario():
    sensor = make(Ultrasound, {"mounts": [{"position": [0.1, 0.0, 0.2], "yaw": 0.3}]})
    assert sensor.config.mounts == (Mount(position=(0.1, 0.0, 0.2), yaw=0.3),)
    assert make(Ultrasound, {"mounts": {"count": 8, "height": 0.2}}).config.mounts == Ring(count=8, height=0.2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"field_of_view": 4.0}, "field_of_view is 4.0, expected"),
        ({"range_max": 0.01}, "range_min is 0.02, expected"),
        ({"mounts": ()}, "mounts is empty, expected"),
        ({"rate": -1.0}, "rate is -1.0, expected"),
    ],
)
def test_options_without_meaning_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        Config(**options)


def test_range_finders_that_are_not_level_or_of_one_height_are_refused(setup):
    model = setup(OPEN).own_robot.model
    low, high = (Mount(position=(0.1, 0.0, z)) for z in (0.1, 0.2))
    with pytest.raises(ValueError, match="mounts have several heights"):
        Config(mounts=(low, high)).frames(model)
    with pytest.raises(ValueError, match="mounts have a pitch"):
        Config(mounts=(Mount(position=(0.1, 0.0, 0.1), pitch=0.1),)).frames(model)
