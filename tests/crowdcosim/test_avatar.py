"""The walking body: feet that stand still, published gait figures, and a skeleton that holds together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowdcosim.avatar import LEGS, LEGS_ONLY, REACH, pose, pose_legs, pose_one
from crowdcosim.body import BODY_PART, MASS, RADIUS, SEGMENTS, SHANK, THIGH
from crowdcosim.gait import HIP, cycle_time, duty, phase_rate
from crowdcosim.messages import Contacts

ROUNDING = 1e-12  # of coordinates of a few metres
INDEX = {name: k for k, name in enumerate(SEGMENTS)}
FEET = [INDEX["left foot"], INDEX["right foot"]]
SPEEDS = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.34, 1.5, 1.7, 1.9)
SAMPLES = 400


def bodies(x=0.0, y=0.0, vx=0.0, vy=0.0, heading=0.0, stature=1.75, phase=0.0):
    columns = np.broadcast_arrays(*(np.atleast_1d(np.float64(c)) for c in (x, y, vx, vy, heading, stature, phase)))
    x, y, vx, vy, heading, stature, phase = (c.copy() for c in columns)
    return pose(np.column_stack([x, y]), np.column_stack([vx, vy]), heading, stature, phase)


def walk(speed, stature=1.75, heading=0.0, cycles=1.0):
    """Times and capsules of somebody who walks straight on, from the left heel's landing on."""
    rate = phase_rate(speed, stature)
    t = np.arange(round(SAMPLES * cycles)) / SAMPLES / rate
    way = speed * t
    return t, bodies(
        way * math.cos(heading),
        way * math.sin(heading),
        speed * math.cos(heading),
        speed * math.sin(heading),
        heading,
        stature,
        rate * t,
    )


def soles(capsules):
    """(T, feet, spheres) lowest points of the heel and the ball above the floor, and (T, feet, spheres, 2) places."""
    feet = capsules[:, FEET]
    return feet[..., [2, 5]] - feet[..., 6:], np.stack([feet[..., 0:2], feet[..., 3:5]], axis=-2)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("stature", [1.45, 1.75, 2.05])
def test_feet_on_the_floor_do_not_slip(speed, stature):
    """At most 4% of the speed was asked for; where legs reach, nothing is left but the rounding of the samples."""
    t, capsules = walk(speed, stature, heading=0.7)
    height, place = soles(capsules)
    down = height < 1e-9
    still = down[1:] & down[:-1]
    slip = np.linalg.norm(np.diff(place, axis=0), axis=-1) / np.diff(t)[:, None, None]
    assert still.any(axis=(0, 2)).all()
    assert slip[still].max() < 1e-9 * speed


@pytest.mark.parametrize("speed", SPEEDS)
def test_each_foot_stands_for_the_published_share_of_the_cycle(speed):
    _, capsules = walk(speed)
    height, _ = soles(capsules)
    standing = (height < 1e-9).any(axis=2).mean(axis=0)
    assert standing == pytest.approx(duty(cycle_time(speed, 1.75)), abs=2.5 / SAMPLES)


@pytest.mark.parametrize("speed", SPEEDS)
def test_the_heels_land_a_stride_apart_and_half_a_cycle_after_each_other(speed):
    t, capsules = walk(speed, cycles=2.5)
    height, place = soles(capsules)
    down = (height < 1e-9).any(axis=2)
    left, right = (np.flatnonzero(down[1:, foot] & ~down[:-1, foot]) + 1 for foot in (0, 1))
    period, stride = cycle_time(speed, 1.75), speed * cycle_time(speed, 1.75)
    sampling = 2.0 / SAMPLES * period
    assert np.diff(t[right]) == pytest.approx(period, abs=sampling)
    assert t[left[0]] - t[right[0]] == pytest.approx(0.5 * period, abs=sampling)
    heel = place[:, 1, 0, 0]
    assert np.diff(heel[right]) == pytest.approx(stride, abs=speed * sampling)


def test_published_figures_of_an_average_walk():
    """H = 1.75 m, v = 1.34 m/s: stride 1.50 m, period 1.12 s, support 0.752 T - 0.143 s; given to three digits."""
    period = cycle_time(1.34, 1.75)
    assert period == pytest.approx(1.12, abs=5e-3)
    assert 1.34 * period == pytest.approx(1.50, abs=5e-3)
    assert 120.0 / period == pytest.approx(107, abs=0.5)
    assert duty(period) * period == pytest.approx(0.752 * period - 0.143, abs=ROUNDING)


@settings(max_examples=200, deadline=None)
@given(
    phase=st.floats(0, 1),
    speed=st.floats(0, 4),
    way=st.floats(-math.pi, math.pi),
    heading=st.floats(-10, 10),
    stature=st.floats(1.2, 2.2),
)
def test_whatever_the_motion_the_body_stays_whole_and_above_the_floor(phase, speed, way, heading, stature):
    capsules = bodies(3.0, -2.0, speed * math.cos(way), speed * math.sin(way), heading, stature, phase)[0]
    ends = capsules[:, :6].reshape(17, 2, 3)
    assert np.isfinite(capsules).all()
    assert np.all(ends[..., 2] - capsules[:, 6:] > -ROUNDING)
    assert np.all(np.hypot(ends[..., 0] - 3.0, ends[..., 1] + 2.0) + capsules[:, 6:] < REACH * stature)
    assert capsules[:, 6] == pytest.approx(RADIUS * stature)
    for side in ("left", "right"):
        foot, shank, thigh = (ends[INDEX[f"{side} {part}"]] for part in ("foot", "shank", "thigh"))
        assert np.linalg.norm(shank[1] - shank[0]) == pytest.approx(SHANK * stature, abs=1e-9)
        assert np.linalg.norm(thigh[1] - thigh[0]) == pytest.approx(THIGH * stature, abs=1e-9)
        assert shank[1] == pytest.approx(thigh[0])
        assert np.linalg.norm(shank[0] - foot[0]) < 0.05 * stature
        upper_arm, forearm = (ends[INDEX[f"{side} {part}"]] for part in ("upper arm", "forearm"))
        assert upper_arm[1] == pytest.approx(forearm[0])


@pytest.mark.parametrize("speed", [0.05, *SPEEDS])
def test_nothing_jumps_within_a_cycle_nor_from_one_to_the_next(speed):
    """No point of the body moves at more than 5 times the walking speed, or 1 m/s: the swinging foot comes nearest."""
    t, capsules = walk(speed, cycles=1.5)
    ends = capsules[..., :6].reshape(len(t), 17, 2, 3)
    speeds = np.linalg.norm(np.diff(ends, axis=0), axis=-1) / (t[1] - t[0])
    assert speeds.max() < max(5.0 * speed, 1.0)


@pytest.mark.parametrize("speed", SPEEDS)
def test_knees_bend_forwards_as_those_of_walkers_do(speed):
    """Almost straight at some time in the stance, and in the air bent by at most 70 degrees, the healthy maximum."""
    _, capsules = walk(speed)
    thigh = capsules[:, INDEX["left thigh"], 0:3] - capsules[:, INDEX["left thigh"], 3:6]
    shank = capsules[:, INDEX["left shank"], 0:3] - capsules[:, INDEX["left shank"], 3:6]
    cosine = (thigh * shank).sum(1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
    bend = np.degrees(np.arccos(cosine))
    assert bend.min() < 12.0
    assert bend.max() < 70.0
    assert np.all(thigh[:, 0] * shank[:, 2] - thigh[:, 2] * shank[:, 0] < 0.0)  # to the left: thigh ahead of shank


def test_hips_bob_and_sway_about_as_published():
    """Up and down twice a cycle by 0.030 nu h: the legs' reach adds, at most a half. Sideways 0.032 h either way."""
    speed, stature = 1.34, 1.75
    _, capsules = walk(speed, stature)
    pelvis = 0.5 * (capsules[:, INDEX["pelvis"], 0:3] + capsules[:, INDEX["pelvis"], 3:6])
    hip = HIP * stature
    assert 1.0 < np.ptp(pelvis[:, 2]) / (0.030 * speed) < 1.5
    assert np.abs(pelvis[:, 1]).max() == pytest.approx(0.032 * hip, rel=1e-3)
    assert pelvis[SAMPLES * 35 // 100, 1] == pytest.approx(0.032 * hip, rel=1e-3)  # over the left foot, which stands


def test_arms_swing_against_the_legs():
    _, capsules = walk(1.34)
    landing = capsules[0]
    assert landing[INDEX["left foot"], 0] > 0.2 > -0.2 > landing[INDEX["right foot"], 0]
    assert landing[INDEX["left hand"], 0] < -0.05 < 0.15 < landing[INDEX["right hand"], 0]


def test_the_second_half_of_a_cycle_mirrors_the_first():
    phase = np.linspace(0, 0.5, 20, endpoint=False)
    first, second = bodies(vx=1.2, phase=phase), bodies(vx=1.2, phase=phase + 0.5)
    twin = [
        INDEX[f"{ ({'left': 'right', 'right': 'left'}[name.split()[0]]) } {name.split(maxsplit=1)[1]}"]
        if name.startswith(("left", "right"))
        else k
        for k, name in enumerate(SEGMENTS)
    ]
    mirrored = second[:, twin] * (1, -1, 1, 1, -1, 1, 1)
    pelvis = INDEX["pelvis"]  # runs from left to right
    mirrored[:, pelvis] = mirrored[:, pelvis][:, [3, 4, 5, 0, 1, 2, 6]]
    np.testing.assert_allclose(mirrored, first, atol=ROUNDING)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.8])
def test_whoever_stands_has_both_feet_flat_side_by_side_below_the_body(phase):
    capsules = bodies(phase=phase)
    height, place = soles(capsules)
    assert height == pytest.approx(0.0, abs=ROUNDING)
    assert place[0, 0] == pytest.approx(place[0, 1] * (1, -1), abs=ROUNDING)
    assert place[0, :, 0, 0].max() < 0.0 < place[0, :, 1, 0].min()  # heels behind, balls ahead
    assert capsules[0, :, [2, 5]].max() + RADIUS[INDEX["head"]] * 1.75 == pytest.approx(1.75, rel=0.01)


def test_the_pose_changes_little_from_standing_to_the_slowest_walk():
    phase = np.linspace(0, 1, 50)
    np.testing.assert_allclose(bodies(vx=0.01, phase=phase), bodies(phase=phase), atol=0.02)


def test_the_body_turns_with_its_heading_and_walks_where_its_velocity_points():
    turned = bodies(1.0, 2.0, 0.0, 1.3, math.pi / 2, 1.75, 0.2)[0]
    straight = bodies(0.0, 0.0, 1.3, 0.0, 0.0, 1.75, 0.2)[0]
    for end in (0, 3):
        assert turned[:, end] == pytest.approx(1.0 - straight[:, end + 1], abs=ROUNDING)
        assert turned[:, end + 1] == pytest.approx(2.0 + straight[:, end], abs=ROUNDING)
        assert turned[:, end + 2] == pytest.approx(straight[:, end + 2], abs=ROUNDING)


@pytest.mark.parametrize("way", [math.pi / 2, math.pi, -2.0])
def test_steps_aside_and_back_do_not_slip_either(way):
    speed, stature = 0.5, 1.75
    rate = phase_rate(speed, stature)
    t = np.arange(SAMPLES) / SAMPLES / rate
    vx, vy = speed * math.cos(way), speed * math.sin(way)
    height, place = soles(bodies(vx * t, vy * t, vx, vy, 0.0, stature, rate * t))
    down = height < 1e-9
    still = down[1:] & down[:-1]
    slip = np.linalg.norm(np.diff(place, axis=0), axis=-1) / np.diff(t)[:, None, None]
    assert slip[still].max() < 1e-9


def test_somebody_who_turns_slips_no_more_than_the_turn_moves_their_feet():
    """On a circle of 5 m; a foot is never farther than 0.65 m from the axis about which the body turns."""
    speed, radius, stature = 1.3, 5.0, 1.75
    rate = phase_rate(speed, stature)
    t = np.arange(SAMPLES) / SAMPLES / rate
    angle = speed * t / radius
    cos, sin = np.cos(angle), np.sin(angle)
    height, place = soles(bodies(radius * sin, -radius * cos, speed * cos, speed * sin, angle, stature, rate * t))
    down = height < 1e-9
    still = down[1:] & down[:-1]
    slip = np.linalg.norm(np.diff(place, axis=0), axis=-1) / np.diff(t)[:, None, None]
    assert slip[still].max() < 0.65 * speed / radius
    assert slip[still].mean() < 0.06 * speed


def test_body_parts_are_those_of_the_contacts():
    parts = dict(zip(SEGMENTS, BODY_PART.tolist(), strict=True))
    assert parts["left foot"] == parts["right foot"] == Contacts.FEET
    assert parts["left shank"] == Contacts.LOWER_LEGS
    assert parts["right thigh"] == Contacts.UPPER_LEGS
    assert {parts[name] for name in SEGMENTS[6:]} == {Contacts.UPPER_BODY}


def test_masses_add_up_and_balance_as_in_the_literature():
    """The centre of mass of somebody who stands is at 0.53 to 0.58 H, above the feet."""
    assert MASS.sum() == pytest.approx(1.0, abs=ROUNDING)
    capsules = bodies(stature=1.0)[0]
    centre = MASS @ (0.5 * (capsules[:, 0:3] + capsules[:, 3:6]))
    assert 0.53 < centre[2] < 0.58
    assert capsules[FEET[0], 0] < centre[0] < capsules[FEET[0], 3]
    assert centre[1] == pytest.approx(0.0, abs=ROUNDING)


def test_legs_alone_are_those_of_the_whole_body_and_nothing_else_is_as_low():
    rng = np.random.default_rng(9)
    for _ in range(3000):
        x, y, heading, phase = rng.uniform(-5, 5, 4)
        vx, vy = rng.normal(0.0, 1.5, 2)
        stature = rng.uniform(1.4, 2.1)
        whole, legs = np.empty((17, 7)), np.empty((17, 7))
        pose_one(x, y, vx, vy, heading, stature, phase, whole)
        pose_legs(x, y, vx, vy, heading, stature, phase, legs)
        np.testing.assert_array_equal(legs[:LEGS], whole[:LEGS])
        others = whole[LEGS:]
        assert (np.minimum(others[:, 2], others[:, 5]) - others[:, 6]).min() > LEGS_ONLY * stature
    assert [segment.split()[1] for segment in SEGMENTS[:LEGS]] == ["foot"] * 2 + ["shank"] * 2 + ["thigh"] * 2
