"""A people tracker sees who is not hidden, with the stated errors, misses and false alarms, and keeps its tracks."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from components.sensors.detections import Config, PeopleTracker
from crowdcosim.component import ports_of
from crowdcosim.message import check_finite
from crowdcosim.messages import Detections
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World

OPEN = World(size=(50.0, 50.0))
EYES = Mount(position=(0.0, 0.0, 1.62))  # where a person of 1.75 m is a disc of 84 mm, 17.5 mm ahead of their position


@pytest.fixture
def tracker(setup):
    def build(world=OPEN, seed=1, **options):
        sensor = PeopleTracker(Config(**options))
        sensor.reset(setup(world, seed=seed))
        return sensor

    return build


def ticks(sensor, robot, crowd, count, period=100_000_000):
    return [sensor.step(robot(5.0, 5.0, nanoseconds=k * period), crowd, ()) for k in range(count)]


def test_ports_are_those_that_scenarios_wire():
    ports = ports_of(PeopleTracker)
    assert [port.name for port in ports.inputs] == ["robot", "crowd", "others"]
    assert [(port.name, port.type) for port in ports.outputs] == [("detections", Detections)]


def test_by_default_it_tells_where_people_are_and_go_seen_from_the_robot(tracker, robot, people):
    crowd = dataclasses.replace(people((5.0, 7.0), (3.0, 5.0)), velocity=[(1.0, 0.0), (0.0, -0.5)])
    own = robot(5.0, 5.0, math.pi / 2, velocity=(0.0, 1.0), nanoseconds=200_000_000)
    found = tracker().step(own, crowd, ())
    assert found.header.frame_id == "robot1/base_link"
    assert found.header.stamp == own.header.stamp
    np.testing.assert_allclose(found.position, [(2.0, 0.0), (0.0, 2.0)], atol=1e-12)
    np.testing.assert_allclose(found.velocity, [(0.0, -1.0), (-0.5, 0.0)], atol=1e-12)
    assert found.radius.tolist() == [0.3, 0.3]
    assert found.track.tolist() == [1, 2]
    assert not found.position_deviation.any() and not found.velocity_deviation.any()
    check_finite(found)


def test_an_empty_world_has_nobody(tracker, robot, people):
    assert len(tracker().step(robot(5.0, 5.0), people(), ()).track) == 0


@pytest.mark.parametrize(("aside", "seen"), [(0.0, False), (0.05, False), (0.17, True), (0.6, True)])
def test_somebody_behind_another_is_seen_once_enough_of_them_shows(tracker, robot, people, aside, seen):
    """At the height of the eyes, discs of 84 mm at 2 and 4 m: the first hides 168 mm to either side of the line."""
    found = tracker(mount=EYES).step(robot(5.0, 5.0), people((7.0, 5.0), (9.0, 5.0 + aside)), ())
    assert len(found.track) == 1 + seen


@pytest.mark.parametrize("aside", np.linspace(0.0, 0.3, 7).tolist())
def test_the_share_that_must_show_is_that_of_the_width(tracker, robot, people, aside):
    """Of the farther disc, from -84 to 84 mm about `aside`, what is beyond 168 mm shows (all at 4 m)."""
    share = np.clip((aside + 0.084 - 0.168) / 0.168, 0.0, 1.0)
    crowd = people((7.0, 5.0), (9.0, 5.0 + aside))
    for least in (share - 0.25, share + 0.25):  # a disc is five beams wide: each is a fifth
        if 0.0 < least < 1.0:
            found = tracker(mount=EYES, least_visible=float(least)).step(robot(5.0, 5.0), crowd, ())
            assert len(found.track) == 1 + (least < share)


def test_walls_and_robots_hide_people(tracker, robot, people):
    wall = World(size=(50.0, 50.0), walls=(Wall(start=(7.0, 4.0), end=(7.0, 6.0)),))
    assert len(tracker(wall).step(robot(5.0, 5.0), people((9.0, 5.0)), ()).track) == 0
    assert len(tracker(wall).step(robot(5.0, 5.0), people((9.0, 9.0)), ()).track) == 1
    in_front = (robot(6.0, 5.0, number=2, radius=0.5),)
    assert len(tracker().step(robot(5.0, 5.0), people((9.0, 5.0)), in_front).track) == 0


def test_nobody_is_detected_beyond_the_range_or_outside_the_field_of_view(tracker, robot, people):
    crowd = people((9.0, 5.0), (14.0, 5.0), (5.0, 9.0), (1.0, 5.0))
    assert len(tracker(range_max=8.0).step(robot(5.0, 5.0), crowd, ()).track) == 3
    ahead = tracker(range_max=8.0, field_of_view=2.0).step(robot(5.0, 5.0), crowd, ())
    np.testing.assert_allclose(ahead.position, [(4.0, 0.0)], atol=1e-12)


def test_a_person_across_the_seam_is_where_they_appear(tracker, robot, people):
    seam = World(size=(50.0, 10.0), periodic=(True, False))
    found = tracker(seam).step(robot(49.0, 5.0), people((1.0, 5.5)), ())
    np.testing.assert_allclose(found.position, [(2.0, 0.5)], atol=1e-12)


def test_somebody_around_the_scanner_is_seen(tracker, robot, people):
    assert len(tracker(mount=EYES).step(robot(5.0, 5.0), people((5.0, 5.0)), ()).track) == 1


@pytest.mark.parametrize("correlation_time", [0.0, 0.3])
def test_errors_have_the_deviations_that_the_message_tells(tracker, robot, people, correlation_time):
    """Two coordinates of 5 people in 400 readings."""
    crowd = dataclasses.replace(
        people(*[(5 + 4 * math.cos(a), 5 + 4 * math.sin(a)) for a in range(5)]), velocity=np.full((5, 2), 0.7)
    )
    sensor = tracker(
        position_deviation=0.05,
        position_deviation_per_metre=0.01,
        velocity_deviation=0.1,
        velocity_deviation_per_metre=0.05,
        correlation_time=correlation_time,
    )
    found = ticks(sensor, robot, crowd, 400, period=1_000_000_000)
    assert np.allclose(found[0].position_deviation, 0.09) and np.allclose(found[0].velocity_deviation, 0.3)
    position = np.array([f.position for f in found]) - (crowd.position - (5.0, 5.0))
    velocity = np.array([f.velocity for f in found]) - 0.7
    # Neighbours share exp(-1 / 0.3) = 4% at most: counted as independent.
    assert position.std() == pytest.approx(0.09, rel=5 / math.sqrt(2 * position.size))
    assert velocity.std() == pytest.approx(0.3, rel=5 / math.sqrt(2 * velocity.size))


@pytest.mark.parametrize("period", [50_000_000, 250_000_000])
def test_errors_are_forgotten_at_the_same_pace_at_any_rate(tracker, robot, people, period):
    """Correlation over 1 s is exp(-1 / tau)."""
    sensor = tracker(position_deviation=0.1, correlation_time=2.0)
    crowd = people(*[(5 + 6 * math.cos(a), 5 + 6 * math.sin(a)) for a in np.arange(0.0, 6.2, 0.2)])
    found = ticks(sensor, robot, crowd, round(30e9 / period), period=period)
    errors = np.array([f.position for f in found]) - (crowd.position - (5.0, 5.0))
    lag = round(1e9 / period)
    correlation = np.mean(errors[lag:] * errors[:-lag]) / np.mean(errors**2)
    assert correlation == pytest.approx(math.exp(-0.5), abs=0.06)  # 62 series of 15 correlation times


def test_misses_and_false_alarms_come_at_their_rates(tracker, robot, people):
    sensor = tracker(miss=0.2, false_alarms=0.5, range_max=8.0, field_of_view=2.0)
    found = ticks(sensor, robot, people((9.0, 5.0)), 2000)
    true = np.array([(np.abs(f.position - (4.0, 0.0)) < 1e-9).all(axis=1).sum() for f in found])
    false = np.array([len(f.track) for f in found]) - true
    assert true.mean() == pytest.approx(0.8, abs=5 * math.sqrt(0.8 * 0.2 / 2000))
    assert false.mean() == pytest.approx(0.5, abs=5 * math.sqrt(0.5 / 2000))
    assert false.var() == pytest.approx(0.5, rel=0.2)  # Poisson: the variance is the mean
    places = np.concatenate([f.position for f in found])
    places = places[(np.abs(places - (4.0, 0.0)) > 1e-9).any(axis=1)]
    away = np.hypot(*places.T)
    assert np.abs(np.arctan2(places[:, 1], places[:, 0])).max() <= 1.0
    # Uniform over the area: the mean distance is 2/3 of the range, its deviation sqrt(1/18).
    assert away.mean() == pytest.approx(16 / 3, abs=5 * 8 / math.sqrt(18 * len(away)))


def test_tracks_outlast_short_gaps_and_begin_anew_after_long_ones(tracker, robot, people):
    sensor, here, away = tracker(memory=0.5), people((8.0, 5.0)), people((30.0, 5.0))
    tracks = []
    for tick in range(20):
        crowd = here if tick in (0, 1, 6, 7, 13) else away  # gaps of 0.5 and 0.6 s
        tracks += sensor.step(robot(5.0, 5.0, nanoseconds=tick * 100_000_000), crowd, ()).track.tolist()
    assert tracks == [1, 1, 1, 1, 2]


def test_every_false_alarm_has_a_track_of_its_own(tracker, robot, people):
    found = ticks(tracker(false_alarms=3.0), robot, people((8.0, 5.0)), 50)
    false = [t for f in found for t in f.track.tolist() if t != found[0].track[0]]
    assert len(set(false)) == len(false) > 100
    assert all(len(set(f.track.tolist())) == len(f.track) for f in found)


def test_the_same_seed_gives_the_same_detections(tracker, robot, people):
    options = {"miss": 0.3, "false_alarms": 1.0, "position_deviation": 0.1, "velocity_deviation": 0.1}
    crowd = people((8.0, 5.0), (5.0, 9.0))
    assert ticks(tracker(**options), robot, crowd, 20) == ticks(tracker(**options), robot, crowd, 20)
    assert ticks(tracker(**options), robot, crowd, 20) != ticks(tracker(seed=2, **options), robot, crowd, 20)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("field_of_view", 7.0),
        ("range_max", 0.0),
        ("least_visible", 1.1),
        ("miss", -0.1),
        ("false_alarms", -1.0),
        ("position_deviation", -1.0),
        ("memory", math.nan),
        ("rate", 0.0),
    ],
)
def test_options_without_meaning_are_refused(option, value):
    with pytest.raises(ValueError, match=rf"{option} is .*, expected"):
        Config(**{option: value})
