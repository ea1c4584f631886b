"""Each cost function: its formula by hand, its gradient by numerical differentiation, and what all of them share."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.crowd.cells import sort_into_cells
from components.crowd.costs import SHIPPED, CostError, make_cost
from components.crowd.costs.cost import STEP
from components.crowd.costs.foe import _view
from components.crowd.costs.karamouzas import greatest_turn
from components.crowd.costs.paris import blocked_speeds
from components.crowd.costs.power_law import disc_force, wall_force
from components.crowd.costs.ttca_dca import approach
from components.crowd.orca import half_plane
from components.crowd.surroundings import Surveyor, in_order
from tests.components.crowd.crowds import random_scene, scene

coordinate = st.floats(-3.0, 3.0, allow_subnormal=False)
speed = st.floats(-1.8, 1.8, allow_subnormal=False)


def around(now, *, relaxation_time=0.5):
    """Everybody's surroundings, in the order of the list."""
    cells = sort_into_cells(now.position, now.period, 2.5)
    places = np.empty(len(cells.order), np.int64)
    places[cells.order] = np.arange(len(cells.order))
    return Surveyor(reach=5.0, relaxation_time=relaxation_time).surroundings(
        now, cells, in_order(cells, now.velocity, now.radius), places
    )


def prices(name, now, velocities, *, coefficient=1.0, relaxation_time=0.5, **options):
    """(B, K) costs of the same velocities (K, 2) for everybody."""
    _, cost = make_cost({"name": name, **options})
    count = len(now.position)
    candidates = np.ascontiguousarray(
        np.broadcast_to(np.array(velocities, float).T[:, None], (2, count, len(velocities)))
    )
    total = np.zeros((count, len(velocities)))
    cost.add(around(now, relaxation_time=relaxation_time), candidates, coefficient, total)
    return total


def push(name, now, *, coefficient=1.0, **options):
    """(B, 2) accelerations."""
    _, cost = make_cost({"name": name, **options})
    total = np.zeros((2, len(now.position)))
    cost.push(around(now), coefficient, total)
    return total.T


@pytest.mark.parametrize("name", SHIPPED)
def test_costs_add_up_with_their_coefficients(name):
    now = random_scene(3, walls=[[(0, 5), (4, 6)]])
    velocities = np.random.default_rng(0).normal(0, 0.8, (30, 2))
    once, twice = prices(name, now, velocities), prices(name, now, velocities, coefficient=2.0)
    assert twice == pytest.approx(2 * once, rel=1e-12)
    assert not np.isnan(once).any()
    assert push(name, now, coefficient=2.0) == pytest.approx(2 * push(name, now), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", ["generic", "karamouzas", "moussaid", "orca", "paris", "pledestrians", "van_toll"])
def test_a_cost_without_a_slope_of_its_own_gets_central_differences(name):
    now = random_scene(4)
    i, d = 7, STEP
    vx, vy = now.velocity[i]
    row = prices(name, now, [(vx + d, vy), (vx - d, vy), (vx, vy + d), (vx, vy - d)])[i]
    expected = [
        -(row[0] - row[1]) / (2 * d) if np.isfinite(row[:2]).all() else 0.0,
        -(row[2] - row[3]) / (2 * d) if np.isfinite(row[2:]).all() else 0.0,
    ]
    assert push(name, now)[i] == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", ["goal_reaching", "power_law", "social_force", "wall_repulsion"])
def test_the_cost_of_a_force_has_minus_the_force_as_its_gradient(name):
    now = random_scene(5, walls=[[(0, 5), (4, 6)]])
    force = push(name, now)
    for i in range(0, 40, 7):
        vx, vy = now.velocity[i]
        # The cost is quadratic: central differences are exact but for rounding of |F|^2 dt.
        row = prices(name, now, [(vx + 0.1, vy), (vx - 0.1, vy), (vx, vy + 0.1), (vx, vy - 0.1)])[i]
        slope = [(row[0] - row[1]) / 0.2, (row[2] - row[3]) / 0.2]
        assert slope == pytest.approx(-force[i], rel=1e-6, abs=1e-9)


# Closed forms.


def test_goal_reaching_relaxes_to_the_preferred_velocity():
    now = scene([(0, 0)], [(0.3, 0.1)], [(1.3, 0.0)])
    assert push("goal_reaching", now) == pytest.approx(np.array([(1.0 / 0.5, -0.1 / 0.5)]))


def test_rvo_is_the_way_off_the_preferred_velocity_and_one_over_the_time_at_twice_the_change():
    now = scene([(0, 0), (4, 0)], [(1.0, 0), (-1.0, 0)], [(1.3, 0), (-1, 0)])
    # At v = 0.8 the relative velocity is 2 * 0.8 - 1 + 1 = 1.6; the gap is 3.4 m.
    assert prices("rvo", now, [(0.8, 0)], w=2.0)[0] == pytest.approx([2 * 1.6 / 3.4 + 0.5])
    assert prices("rvo", now, [(1.0, 1.6), (1.9, 0)])[0, 1] == np.inf
    assert prices("rvo", now, [(1.0, 1.49)])[0] == pytest.approx([math.hypot(0.3, 1.49)])


def test_rvo_expects_nothing_of_a_wall():
    now = scene([(0, 0)], [(1.0, 0)], [(1.0, 0)], walls=[[(2, -1), (2, 1)]])
    assert prices("rvo", now, [(0.5, 0)])[0] == pytest.approx([0.5 / 1.7 + 0.5])


def test_karamouzas_adds_turn_speed_difference_and_collision():
    now = scene([(0, 0), (4, 0)], [(1.0, 0), (-1.0, 0)], [(1.0, 0), (-1, 0)])
    # Preferred: collision in 3.4 / 2 = 1.7 s, so that turns of up to 30 + 60 (1 - 1.7 / 2.5)^2 deg are allowed.
    t = 3.4 / 1.5
    assert prices("karamouzas", now, [(0.5, 0)])[0] == pytest.approx([0.5 * 0.5 / 1.8 + 0.5 / 3.6 + 1 - t / 8])
    turn = math.radians(35.0)
    v = (math.cos(turn), math.sin(turn))
    off = math.hypot(v[0] - 1, v[1])
    assert prices("karamouzas", now, [v])[0] == pytest.approx([5 * (1 - math.cos(turn)) / 2 + off / 3.6])
    assert prices("karamouzas", now, [(math.cos(0.8), math.sin(0.8))])[0] == [np.inf]


def test_karamouzas_limits_turns_by_the_time_to_collision():
    T = 8.0
    assert greatest_turn(0.0, T) == pytest.approx(math.radians(90))
    for t in (2.5, 4.0, 6.0):
        assert greatest_turn(t, T) == pytest.approx(math.radians(30))
    assert greatest_turn(7.0, T) == pytest.approx(math.radians(15))
    assert greatest_turn(8.0, T) == greatest_turn(np.inf, T) == 0.0


def test_whoever_is_free_must_keep_the_preferred_velocity_by_karamouzas():
    now = scene([(0, 0)], [(1.0, 0)], [(1.3, 0)])
    assert np.isfinite(prices("karamouzas", now, [(1.3, 0), (1.0, 0), (1.2, 0.4)])[0]).tolist() == [True, False, False]


def test_moussaid_weighs_the_free_way_in_a_direction_at_the_preferred_speed():
    now = scene([(0, 0), (4, 0)], preferred=[(1.0, 0), (0, 0)])
    free = 3.4
    # S = min(1, 3.4 / 0.5) = 1.
    expected = (64 + free**2 - 16 * free + 1) * (1 + 0.5**2)
    assert prices("moussaid", now, [(0.5, 0)])[0] == pytest.approx([expected])
    aside = (0.0, 1.0)
    assert prices("moussaid", now, [aside])[0] == pytest.approx([64 + 64 + 1])
    near = scene([(0, 0), (0.8, 0)], preferred=[(1.0, 0), (0, 0)])
    # S = 0.2 / 0.5 = 0.4.
    assert prices("moussaid", near, [(0.4, 0)])[0] == pytest.approx([64 + 0.2**2 - 16 * 0.2 + 1])


def test_van_toll_adds_free_way_angles_and_speed():
    now = scene([(0, 0), (4, 0)], [(0, 1.0), (0, 0)], [(1.0, 0), (0, 0)])
    assert prices("van_toll", now, [(0.5, 0)])[0] == pytest.approx([8 - 3.4 + 0 + 0.5 + math.pi / 2])
    assert prices("van_toll", now, [(0, 1.2)])[0] == pytest.approx([0 + math.pi / 2 + 0.2 + 0])


def test_pledestrians_is_cheapest_at_the_preferred_velocity_and_forbids_collisions_within_half_a_second():
    now = scene([(0, 0), (1.2, 0)], preferred=[(1.3, 0), (0, 0)])
    row = prices("pledestrians", now, [(1.3, 0.0), (1.19, 0.0), (-1.3, 0), (0, 0)])[0]
    assert row[0] == np.inf
    # 3 s at w_b (v0^2 + v^2 - 2 v . v0).
    assert row[1:] == pytest.approx([3 * 1.26 * 0.11**2, 3 * 1.26 * 2.6**2, 3 * 1.26 * 1.3**2])


def test_pledestrians_differs_from_the_energy_of_a_far_goal_by_a_constant():
    g, v0, w_b = 1e5, 1.3, 1.26
    w_a = w_b * v0**2
    velocities = np.random.default_rng(1).normal(0, 1, (20, 2))
    exact = 3 * (w_a + w_b * (velocities**2).sum(axis=1)) + 2 * np.hypot(*((g, 0) - 3 * velocities).T) * math.sqrt(
        w_a * w_b
    )
    ours = prices("pledestrians", scene([(0, 0)], preferred=[(v0, 0)]), velocities)[0]
    # The distance is straight to second order: 9 v^2 / (2 g).
    assert exact - exact[0] == pytest.approx(ours - ours[0], abs=1e-3)


def test_orca_is_the_distance_to_the_preferred_velocity_where_that_is_permitted():
    now = scene([(0, 0), (4, 0)], [(1.0, 0), (-1.0, 0)], [(1.3, 0), (-1, 0)])
    nx, ny, b = half_plane(4, 0, 1.0, 0, -1.0, 0, 0.6, 5.0, 0.1)
    velocities = np.random.default_rng(0).uniform(-1.2, 1.2, (50, 2))
    lacking = b - velocities @ (nx, ny)
    expected = np.where(lacking <= 0, np.hypot(*(velocities - (1.3, 0)).T), 3.6 + lacking)
    assert prices("orca", now, velocities)[0] == pytest.approx(expected)
    assert (lacking <= 0).any()
    assert (lacking > 0).any()
    assert prices("orca", now, [(-1.9, 0)])[0] == pytest.approx([3.7])


def test_random_costs_are_uniform_and_others_for_everybody():
    now = random_scene(0, 200)
    row = prices("random", now, np.zeros((50, 2)))
    # 10,000 draws: standard error 0.6%.
    assert abs(row.mean()) < 0.02
    assert row.std() == pytest.approx(1 / math.sqrt(3), abs=0.01)
    assert np.abs(row).max() <= 1
    assert len(np.unique(row)) == row.size


# Gradients.


def energy(t, t0=3.0):
    return math.exp(-t / t0) / t**2


def time_of_discs(px, py, wx, wy, R):
    a, b = wx * wx + wy * wy, px * wx + py * wy
    return (b - math.sqrt(b * b - a * (px * px + py * py - R * R))) / a


@settings(deadline=None, max_examples=200)
@given(
    distance=st.floats(0.8, 4.0),
    bearing=st.floats(0, 2 * math.pi),
    miss=st.floats(-0.9, 0.9),
    seconds=st.floats(0.3, 2.9),
)
def test_the_power_law_is_minus_the_gradient_of_its_energy(distance, bearing, miss, seconds):
    # Passing at `miss` times the sum of radii; at 1, where discs graze, the gradient is infinite.
    way = bearing + math.asin(miss * 0.6 / distance)
    px, py = distance * math.cos(bearing), distance * math.sin(bearing)
    pace = time_of_discs(px, py, math.cos(way), math.sin(way), 0.6) / seconds
    wx, wy = pace * math.cos(way), pace * math.sin(way)
    t, fx, fy = disc_force(px, py, wx, wy, 0.6, 3.0)
    assert t == pytest.approx(seconds)
    h = 1e-6
    # p is the neighbour's position: moving on by h brings it nearer.
    gx = (energy(time_of_discs(px - h, py, wx, wy, 0.6)) - energy(time_of_discs(px + h, py, wx, wy, 0.6))) / (2 * h)
    gy = (energy(time_of_discs(px, py - h, wx, wy, 0.6)) - energy(time_of_discs(px, py + h, wx, wy, 0.6))) / (2 * h)
    # Rounding of 1e-16 E / h, with E up to 10, and h^2 times the third derivative.
    assert (fx, fy) == pytest.approx((-gx, -gy), rel=1e-4, abs=1e-6)


@settings(deadline=None, max_examples=200)
@given(angle=st.floats(0, 2 * math.pi), along=speed, t=st.floats(0.1, 2.9), distance=st.floats(0.4, 4.0))
def test_the_power_law_of_a_wall_is_minus_the_gradient_of_its_energy(angle, along, t, distance):
    nx, ny = math.cos(angle), math.sin(angle)
    towards = (distance - 0.3) / t
    vx, vy = towards * nx - along * ny, towards * ny + along * nx
    ends = [(distance * nx - s * 100 * ny, distance * ny + s * 100 * nx) for s in (-1, 1)]
    seconds, fx, fy = wall_force(*ends[0], *ends[1], vx, vy, 0.3, 3.0)
    assert seconds == pytest.approx(t, rel=1e-9)
    h = 1e-6
    slope = (energy((distance - h - 0.3) / towards) - energy((distance + h - 0.3) / towards)) / (2 * h)
    assert (fx, fy) == pytest.approx((-slope * nx, -slope * ny), rel=1e-5, abs=1e-6)


def test_the_end_of_a_wall_pushes_as_a_disc_without_extent():
    assert wall_force(2.0, 0.1, 2.0, 3.0, 1.0, 0.0, 0.3, 3.0)[1:] != (0.0, 0.0)
    assert wall_force(2.0, 0.1, 4.0, 3.0, 1.0, 0.0, 0.3, 3.0) == pytest.approx(disc_force(2, 0.1, 1, 0, 0.3, 3.0))


@settings(deadline=None, max_examples=200)
@given(px=coordinate, py=coordinate, wx=speed, wy=speed)
def test_the_slope_of_an_approach_is_its_numerical_derivative(px, py, wx, wy):
    assume(math.hypot(px, py) > 0.1)
    assume(wx * wx + wy * wy > 0.05)
    # A kink where the approach begins.
    assume(abs(px * wx + py * wy) > 1e-3)
    _, gx, gy = approach(px, py, wx, wy, 1.0, 0.3)
    h = 1e-6
    # w is the neighbour's velocity less the person's.
    fx = (approach(px, py, wx - h, wy, 1.0, 0.3)[0] - approach(px, py, wx + h, wy, 1.0, 0.3)[0]) / (2 * h)
    fy = (approach(px, py, wx, wy - h, 1.0, 0.3)[0] - approach(px, py, wx, wy + h, 1.0, 0.3)[0]) / (2 * h)
    assert (gx, gy) == pytest.approx((fx, fy), rel=1e-5, abs=1e-6)


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1))
def test_ttca_dca_goes_down_its_slope_in_angle_and_speed(seed):
    now = random_scene(seed, 12)
    i, h = 0, 1e-6
    vx, vy = now.velocity[i]
    s, theta = math.hypot(vx, vy), math.atan2(vy, vx)
    assume(s > 0.2)

    def at(ds, dtheta):
        return ((s + ds) * math.cos(theta + dtheta), (s + ds) * math.sin(theta + dtheta))

    row = prices("ttca_dca", now, [at(h, 0), at(-h, 0), at(0, h), at(0, -h)])[i]
    by_speed, by_angle = (row[0] - row[1]) / (2 * h), (row[2] - row[3]) / (2 * h)
    a = push("ttca_dca", now)[i]
    along = a @ (math.cos(theta), math.sin(theta))
    across = a @ (-math.sin(theta), math.cos(theta))
    near = around(now)
    w = near.near[2:4, near.first[i] : near.first[i + 1]].T - (vx, vy)
    p = near.near[:2, near.first[i] : near.first[i + 1]].T
    assume((np.abs((p * w).sum(axis=1)) > 1e-3).all())
    assume(((w * w).sum(axis=1) > 0.01).all())
    assume(abs(abs(math.atan2(now.preferred[i, 1], now.preferred[i, 0]) - theta) - math.pi) > 1e-3)
    assert (along, across) == pytest.approx((-by_speed, -s * by_angle), rel=1e-4, abs=1e-6)


@settings(deadline=None, max_examples=100)
@given(px=st.floats(0.2, 4.0), py=coordinate, ox=st.floats(-1.8, 0.4), oy=speed, s=st.floats(0.3, 1.8))
def test_the_slope_of_the_focus_of_expansion_is_its_numerical_derivative(px, py, ox, oy, s):
    near = np.array([[px], [py], [ox], [oy], [0.6]])

    def off(theta, ds):
        # To the right of x.
        v = (s + ds) * math.cos(theta), -(s + ds) * math.sin(theta)
        matters, image, focus, closing, _, _ = _view(near, 0, *v, s + ds)
        return matters, image - focus, image, focus, closing

    matters, _, image, focus, closing = off(0.0, 0.0)
    assume(matters)
    assume(closing < -0.1)
    h = 1e-6
    by_angle = (off(h, 0)[1] - off(-h, 0)[1]) / (2 * h)
    by_speed = (off(0, h)[1] - off(0, -h)[1]) / (2 * h)
    assert focus**2 - image**2 + s / closing == pytest.approx(by_angle, rel=1e-5, abs=1e-5)
    assert -focus / closing == pytest.approx(by_speed, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("aside", [0.2, -0.2])
def test_foe_turns_away_from_whom_it_would_meet(aside):
    now = scene([(0, 0), (4, aside)], [(1.3, 0), (-1.3, 0)])
    assert push("foe", now)[0, 1] * aside < 0
    # 0.1 per radian at 1.3 m/s, at most.
    assert abs(push("foe", now)[0, 1]) <= 0.13 + 1e-12


# Paris.


@settings(deadline=None, max_examples=300)
@given(px=coordinate, py=coordinate, ox=speed, oy=speed, angle=st.floats(0, 2 * math.pi), s=st.floats(0.0, 2.0))
def test_speeds_within_the_blocked_ones_collide_and_no_others(px, py, ox, oy, angle, s):
    R = 0.6
    assume(math.hypot(px, py) > R + 1e-3)
    hx, hy = math.cos(angle), math.sin(angle)
    slow, fast = blocked_speeds(px, py, ox, oy, R, hx, hy)
    assume(min(abs(s - slow), abs(s - fast)) > 1e-6)
    wx, wy = s * hx - ox, s * hy - oy
    collides = px * wx + py * wy > 0 and (px * wy - py * wx) ** 2 < R * R * (wx * wx + wy * wy)
    assume(abs(R * R - (px * hy - py * hx) ** 2) > 1e-6)
    assert (slow < s < fast) == collides


def test_paris_prefers_to_pass_behind_or_before():
    # The other crosses 3 m ahead, when the person would be there too.
    now = scene([(0, 0), (3, -3)], [(1, 0), (0, 1)], [(1.0, 0), (0, 1)])
    row = prices("paris", now, [(1.0, 0), (0.6, 0), (1.4, 0), (0.9, 0)])[0]
    assert row[1] < row[3] < row[0]
    assert row[2] < row[0]


# Mistakes.


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"name": "rov"}, "there is no cost 'rov': did you mean 'rvo'?"),
        ({}, "name is None, expected"),
        ({"name": "rvo", "wieght": 2}, "rvo: wieght: Unexpected keyword argument .it has w."),
        ({"name": "rvo", "w": "2"}, "rvo: w: Input should be a valid number"),
        ({"name": "rvo", "w": -1}, "rvo: .*w is -1.0, expected zero or a positive number"),
        ({"name": "rvo", "coefficient": "2"}, "rvo: coefficient is '2', expected a number"),
        ({"name": "./nowhere.py:Mine"}, "there is no file .*nowhere.py"),
        ({"name": "components.crowd.orca:Orca"}, "has no class 'Orca' that is a components.crowd.costs.cost.Cost"),
        ({"name": "components.crowd.nothing:Orca"}, "there is no module 'components.crowd.nothing'"),
    ],
)
def test_costs_that_are_not_there_are_named(entry, message):
    with pytest.raises(CostError, match=message):
        make_cost(entry)
