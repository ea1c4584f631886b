"""Recorded people come, walk as they walked, and go."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from components.crowd.replay import Replay, _sample
from crowdcosim.component import make, ports_of
from crowdcosim.gait import phase_rate
from crowdcosim.message import check_finite
from crowdcosim.setup import Setup
from crowdcosim.world import World

SETUP = Setup(component="crowd", period=100_000_000, seed=1, world=World(size=(40.0, 20.0)))


def track(number, times, ways):
    return "".join(f"{number},{t!r},{x!r},{y!r}\n" for t, (x, y) in zip(times, ways, strict=True))


@pytest.fixture
def file(tmp_path):
    """Person 1 from 0 to 4 s in a parabola; person 2 from 1 to 3 s straight; person 5 for an instant."""
    t = [0.0, 0.4, 0.8, 1.4, 2.0, 2.5, 3.1, 4.0]
    text = track(1, t, [(1.0 + 2.0 * s, 2.0 + 0.25 * s * s) for s in t])
    text += track(2, [1.0, 2.0, 3.0], [(10.0, 5.0), (10.0, 6.0), (10.0, 7.0)]) + track(5, [2.0], [(20.0, 10.0)])
    path = tmp_path / "tracks.csv"
    path.write_text("id,t,x,y\n" + text)
    return str(path)


def run(setup=SETUP, steps=45, **options):
    model = make(Replay, options)
    return [model.reset(setup), *(model.step() for _ in range(steps))]


def of(states, number):
    """Times and states of one person: position, velocity, heading, phase, pace."""
    rows = []
    for k, state in enumerate(states):
        for i in np.flatnonzero(state.id == number):
            rows.append(
                (
                    0.1 * k,
                    *state.position[i],
                    *state.velocity[i],
                    state.heading[i],
                    state.gait_phase[i],
                    state.gait_speed[i],
                )
            )
    return np.array(rows).T


def test_it_moves_the_crowd_and_sees_nobody():
    ports = ports_of(Replay)
    assert ports.kind == "mover"
    assert ports.inputs == ()


def test_people_come_and_go_with_their_first_and_last_sample(file):
    states = run(file=file)
    ids = [state.id.tolist() for state in states]
    assert ids[0] == [1]
    assert ids[9:11] == [[1], [1, 2]]
    assert ids[20] == [1, 2, 5]
    assert ids[19] == ids[21] == [1, 2]
    assert ids[30:32] == [[1, 2], [1]]
    assert ids[40:42] == [[1], []]
    for state in states:
        check_finite(state)


@pytest.mark.parametrize("period", [40_000_000, 100_000_000, 250_000_000])
def test_a_parabola_is_resampled_exactly_whatever_the_time_step(file, period):
    states = run(replace(SETUP, period=period), steps=int(4e9 / period), file=file)
    assert len(states[-1].id) == 1
    for k, state in enumerate(states):
        t = k * period * 1e-9
        assert state.position[0] == pytest.approx((1 + 2 * t, 2 + 0.25 * t * t))
        assert state.velocity[0] == pytest.approx((2, 0.5 * t))
        if k:
            assert state.heading[0] == pytest.approx(math.atan2(0.5 * t, 2))


def test_linear_interpolation_goes_straight_from_sample_to_sample(file):
    states = run(file=file, interpolation="linear")
    t, x, y, _, vy, *_ = of(states, 1)
    assert x == pytest.approx(1 + 2 * t)
    samples = np.array([0.0, 0.4, 0.8, 1.4, 2.0, 2.5, 3.1, 4.0])
    assert y == pytest.approx(np.interp(t, samples, 2 + 0.25 * samples**2))
    # From 2.0 to 2.5 s: 0.25 (2.5^2 - 2^2) / 0.5.
    assert vy[22] == pytest.approx(1.125)


@settings(deadline=None, max_examples=25)
@given(
    ways=st.lists(st.tuples(st.floats(1, 39), st.floats(1, 19)), min_size=3, max_size=12),
    gaps=st.lists(st.floats(0.2, 2.0), min_size=12, max_size=12),
)
def test_the_velocity_is_the_derivative_of_the_position_and_the_samples_are_met(tmp_path_factory, ways, gaps):
    times = np.cumsum(gaps[: len(ways)])
    path = tmp_path_factory.mktemp("tracks") / "t.csv"
    path.write_text("id,t,x,y\n" + track(3, times.tolist(), ways))
    world = World(size=(400.0, 400.0))
    model = make(Replay, {"file": str(path), "offset": [180, 190]})
    model.reset(replace(SETUP, world=world))
    who, h = np.zeros(1, np.int64), 1e-6
    for t, way in zip(times - times[0], ways, strict=True):
        assert _sample(model._spline, who, t)[0][0] == pytest.approx((way[0] + 180, way[1] + 190))
    for t in np.linspace(0.01, times[-1] - times[0] - 0.01, 7):
        ahead, behind = _sample(model._spline, who, t + h)[0], _sample(model._spline, who, t - h)[0]
        # h^2 times a third derivative of up to 1e4 m/s3, across a sample h times the jump of the second, and rounding.
        assert _sample(model._spline, who, t)[1] == pytest.approx((ahead - behind) / (2 * h), abs=2e-3)


def test_steps_follow_the_speed(file):
    states = run(file=file)
    _, _, _, vx, vy, _, phase, pace = of(states, 2)
    stature = states[15].stature[states[15].id == 2][0]
    # Whoever comes is walking already; the steps are those of gait.py.
    assert pace == pytest.approx(np.hypot(vx, vy))
    assert np.diff(phase) % 1.0 == pytest.approx(phase_rate(1.0, stature) * 0.1)


def test_tracks_are_scaled_turned_and_moved(file):
    states = run(file=file, scale=0.5, rotation=math.pi / 2, offset=[20.0, 3.0])
    t, x, y, vx, vy, heading, *_ = of(states, 2)
    assert x == pytest.approx(20.0 - 0.5 * (5.0 + (t - 1.0)))
    assert y == pytest.approx(3.0 + 0.5 * 10.0)
    assert vx == pytest.approx(-0.5)
    assert vy == pytest.approx(0.0, abs=1e-12)
    assert np.abs(heading) == pytest.approx(math.pi)


def test_whoever_is_replaced_is_left_out_and_the_episode_begins_when_they_come(file):
    states = run(file=file, replace=2)
    assert all(2 not in state.id for state in states)
    # One second later than without.
    assert states[0].position[0] == pytest.approx(run(file=file)[10].position[0])
    assert run(file=file, replace=2, begin=0.0)[0].position[0] == pytest.approx((1.0, 2.0))
    with pytest.raises(ValueError, match="replace is 3, expected an id of .*: 1, 2, 5"):
        run(file=file, replace=3)


def test_visits_tell_where_everybody_comes_and_goes(file):
    visits = make(Replay, {"file": file, "offset": [1, 1]}).visits()
    assert [v.id for v in visits] == [1, 2, 5]
    assert (visits[1].begin, visits[1].end, visits[1].length) == pytest.approx((1.0, 3.0, 2.0))
    assert (*visits[1].start, *visits[1].goal) == pytest.approx((11.0, 6.0, 11.0, 8.0))


def test_people_outside_of_the_world_are_an_error_that_says_where_all_are(file):
    with pytest.raises(ValueError, match=r"person 1 is at \(-4.00, 2.00\) at 0.00 s, outside .* x -4.00 to 15.00"):
        run(file=file, offset=[-5, 0])


def test_people_wrap_around_where_the_world_does(file):
    world = World(size=(8.0, 20.0), periodic=(True, False))
    states = run(replace(SETUP, world=world), file=file)
    (
        t,
        x,
        *_,
    ) = of(states, 1)
    assert x == pytest.approx((1 + 2 * t) % 8.0)


def test_id_zero_is_somebody(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("id,t,x,y\n0,0,1,1\n0,1,2,1\n4,0,1,3\n4,1,2,3\n")
    assert run(file=str(path), steps=0)[0].id.tolist() == [1, 5]


def test_alone_means_that_nobody_is_there(file):
    assert all(len(state.id) == 0 for state in run(replace(SETUP, alone=True), file=file))


def test_episodes_are_the_same_again_and_bodies_depend_on_the_seed(file):
    model = make(Replay, {"file": file})
    first = [model.reset(SETUP), *(model.step() for _ in range(20))]
    assert [model.reset(SETUP), *(model.step() for _ in range(20))] == first
    assert model.reset(replace(SETUP, seed=2)).stature != pytest.approx(first[0].stature)


@pytest.mark.parametrize(
    ("options", "message"),
    [({"scale": 0}, "scale is 0.0"), ({"frame_rate": -1}, "frame_rate is -1.0"), ({"radius": 0}, "radius is 0")],
)
def test_options_that_make_no_sense_are_refused(options, message):
    with pytest.raises(ValidationError, match=message):
        make(Replay, {"file": "t.csv"} | options)
