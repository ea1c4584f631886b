"""ORCA: its half-planes against the definition, its published trajectories, and what it guarantees."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.crowd.motion import move
from components.crowd.orca import Orca, half_plane, wall_half_plane
from components.crowd.scene import Scene
from components.crowd.walls import Walls

DT = 0.1
NO_ROBOTS = np.empty((0, 5))
NO_WALLS = np.empty((0, 2, 2))
UNLIMITED = 1e9

coordinate = st.floats(-3.0, 3.0, allow_subnormal=False)
speed = st.floats(-1.8, 1.8, allow_subnormal=False)


def scene(
    position,
    velocity,
    preferred,
    *,
    robots=NO_ROBOTS,
    walls=NO_WALLS,
    period=(0.0, 0.0),
    max_speed=1.6,
    max_acceleration=5.0,
):
    return Scene(
        position=np.asarray(position, np.float64),
        velocity=np.asarray(velocity, np.float64),
        preferred=np.asarray(preferred, np.float64),
        radius=np.full(len(position), 0.3),
        robots=robots,
        pushed_by_robots=np.ones(len(position), np.bool_),
        walls=Walls(np.asarray(walls), np.asarray(period)),
        period=np.asarray(period, np.float64),
        max_speed=np.full(len(position), max_speed),
        max_acceleration=np.full(len(position), max_acceleration),
        stream=np.zeros(len(position), np.uint64),
        dt=DT,
    )


def walk_to(goal, position, *, horizon, max_acceleration, steps, **options):
    """(steps + 1, N, 2) positions of people who walk to their goals at 1.3 m/s and start at rest."""
    position, goal = np.asarray(position, np.float64), np.asarray(goal, np.float64)
    velocity, track = np.zeros_like(position), [position]
    for _ in range(steps):
        way = goal - position
        distance = np.hypot(way[:, 0], way[:, 1])[:, None]
        preferred = np.where(distance > 0.3, way / np.maximum(distance, 1e-12) * 1.3, 0.0)
        now = scene(position, velocity, preferred, max_acceleration=max_acceleration, **options)
        position, velocity = move(now, Orca(time_horizon=horizon).accelerate(now))
        track.append(position)
    return np.array(track)


# The example scenes of the UMANS library: radius 0.3 m, preferred speed 1.3 m/s, maximum 1.6 m/s and 5 m/s2, time
# horizon 5 s, dt 0.1 s; everybody walks to the opposite point. Agent 0 at t = 5 s, as printed (six digits).
CIRCLE = np.array(
    [
        (5.0, 0.0),
        (4.0425, 2.9425),
        (1.5368, 4.758),
        (-1.5575, 4.7512),
        (-4.0553, 2.9248),
        (-5.0, -0.0218),
        (-4.0296, -2.9601),
        (-1.516, -4.7646),
        (1.5783, -4.7444),
        (4.0681, -2.907),
    ]
)


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        pytest.param([(-5, 0), (5, 0)], (1.33929, -0.227194), id="1to1-180Degrees"),
        pytest.param([(-5, 0), (0, 5)], (1.60883, -0.158185), id="1to1-90Degrees"),
        pytest.param(CIRCLE, (2.44663, 0.00332118), id="Circle10"),
    ],
)
def test_trajectories_are_those_of_umans(start, expected):
    start = np.array(start, np.float64)
    track = walk_to(-start, start, horizon=5.0, max_acceleration=5.0, steps=50)
    # UMANS computes in single precision, RVO2 too; they agree with each other to 1.1e-5 m.
    assert track[50, 0] == pytest.approx(expected, abs=2e-5)


def distance_within(px, py, wx, wy, horizon):
    """Least distance of the origin from the point p - w t, 0 <= t <= horizon."""
    squared = wx * wx + wy * wy
    t = min(max((px * wx + py * wy) / squared, 0.0), horizon) if squared > 0 else 0.0
    return math.hypot(px - wx * t, py - wy * t)


@settings(deadline=None, max_examples=300)
@given(px=coordinate, py=coordinate, vx=speed, vy=speed, ox=speed, oy=speed, horizon=st.sampled_from([0.5, 1.5, 5.0]))
def test_the_line_is_half_way_to_the_nearest_point_of_the_velocity_obstacle(px, py, vx, vy, ox, oy, horizon):
    R = 0.6
    assume(math.hypot(px, py) > R + 1e-3)
    nx, ny, b = half_plane(px, py, vx, vy, ox, oy, R, horizon, DT)
    assert math.hypot(nx, ny) == pytest.approx(1.0, abs=1e-12)
    # u: twice the way from the current velocity to the line, both people together.
    u = 2 * (b - nx * vx - ny * vy)
    wx, wy = vx - ox, vy - oy
    on_boundary = distance_within(px, py, wx + u * nx, wy + u * ny, horizon)
    assert on_boundary == pytest.approx(R, abs=1e-9)
    colliding = distance_within(px, py, wx, wy, horizon) < R
    assert colliding == (u > 0) or abs(u) < 1e-9
    for angle in np.linspace(0, 2 * np.pi, 48, endpoint=False):
        x, y = wx + 0.999 * u * math.cos(angle), wy + 0.999 * u * math.sin(angle)
        # Nothing nearer than u is on the other side of the boundary.
        assert (distance_within(px, py, x, y, horizon) < R) == colliding or abs(u) < 1e-6


@settings(deadline=None, max_examples=200)
@given(px=coordinate, py=coordinate, vx=speed, vy=speed, ox=speed, oy=speed)
def test_both_of_a_pair_get_opposite_half_planes_and_equal_shares(px, py, vx, vy, ox, oy):
    mine = half_plane(px, py, vx, vy, ox, oy, 0.6, 1.5, DT)
    other = half_plane(-px, -py, ox, oy, vx, vy, 0.6, 1.5, DT)
    assume(math.isfinite(mine[2]))
    # A head-on pair lies on the border between the two legs: both pass on the same side.
    assume(abs(px * (vy - oy) - py * (vx - ox)) > 1e-9)
    assert mine[0] == pytest.approx(-other[0], abs=1e-12)
    assert mine[1] == pytest.approx(-other[1], abs=1e-12)
    my_share = mine[2] - mine[0] * vx - mine[1] * vy
    other_share = other[2] - other[0] * ox - other[1] * oy
    assert my_share == pytest.approx(other_share, abs=1e-12)


def test_an_overlap_ends_within_one_step():
    # 0.5 m apart at rest with R = 0.6 m: each has to leave by 0.05 m in 0.1 s, which is 0.5 m/s.
    nx, ny, b = half_plane(0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 1.5, DT)
    assert (nx, ny, b) == pytest.approx((-1.0, 0.0, 0.5))


def wall_distance(ax, ay, bx, by, wx, wy, horizon):
    """Least distance from the segment of the way w t, 0 <= t <= horizon, which begins at the origin."""
    a, b, end = np.array([ax, ay]), np.array([bx, by]), np.array([wx, wy]) * horizon

    def cross(u, v):
        return u[0] * v[1] - u[1] * v[0]

    if cross(b - a, -a) * cross(b - a, end - a) < 0 and cross(end, a) * cross(end, b) < 0:
        return 0.0

    def to_segment(p, s, e):
        d = e - s
        share = np.clip((p - s) @ d / (d @ d), 0, 1) if d @ d > 0 else 0.0
        return np.linalg.norm(p - s - share * d)

    zero = np.zeros(2)
    return min(to_segment(zero, a, b), to_segment(end, a, b), to_segment(a, zero, end), to_segment(b, zero, end))


@settings(deadline=None, max_examples=300)
@given(
    ax=coordinate,
    ay=coordinate,
    bx=coordinate,
    by=coordinate,
    vx=speed,
    vy=speed,
    horizon=st.sampled_from([0.5, 1.5]),
)
def test_a_walls_line_touches_its_velocity_obstacle_where_that_is_nearest(ax, ay, bx, by, vx, vy, horizon):
    r = 0.3
    assume(math.hypot(ax - bx, ay - by) > 1e-2)
    assume(wall_distance(ax, ay, bx, by, 0.0, 0.0, horizon) > r + 1e-3)
    nx, ny, b = wall_half_plane(ax, ay, bx, by, vx, vy, r, horizon)
    assert b <= 0.0, "standing still is always permitted"
    assert math.hypot(nx, ny) == pytest.approx(1.0, abs=1e-12)
    # A wall does nothing: the whole way, not half of it.
    u = b - nx * vx - ny * vy
    assert wall_distance(ax, ay, bx, by, vx + u * nx, vy + u * ny, horizon) == pytest.approx(r, abs=1e-7)
    colliding = wall_distance(ax, ay, bx, by, vx, vy, horizon) < r
    for angle in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        x, y = vx + 0.999 * u * math.cos(angle), vy + 0.999 * u * math.sin(angle)
        assert (wall_distance(ax, ay, bx, by, x, y, horizon) < r) == colliding or abs(u) < 1e-6


@settings(deadline=None, max_examples=60)
@given(angle=st.floats(0, 2 * np.pi), offset=st.floats(-0.6, 0.6), lead=st.floats(-1, 1), horizon=st.floats(0.5, 5.0))
def test_two_discs_head_on_or_crossing_never_overlap(angle, offset, lead, horizon):
    ways = np.array([[1.0, 0.0], [math.cos(angle), math.sin(angle)]])
    start = -4.0 * ways
    start[1] += offset * np.array([-ways[1, 1], ways[1, 0]]) + lead * ways[1]
    assume(np.linalg.norm(start[0] - start[1]) > 0.6)
    track = walk_to(start + 8 * ways, start, horizon=horizon, max_acceleration=UNLIMITED, steps=80)
    gap = np.linalg.norm(track[:, 0] - track[:, 1], axis=1) - 0.6
    # The linear program is met to 1e-10 m/s; the overlap of a step is dt times that, and rounding.
    assert gap.min() > -1e-9


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_everybody_gets_the_same_whatever_the_order_of_the_list(seed):
    rng = np.random.default_rng(seed)
    n = 60
    position, velocity, preferred = rng.random((n, 2)) * (12, 10), rng.normal(0, 1, (n, 2)), rng.normal(0, 1, (n, 2))
    shuffled = rng.permutation(n)
    a = Orca(time_horizon=1.5).accelerate(scene(position, velocity, preferred, period=(12, 10)))
    b = Orca(time_horizon=1.5).accelerate(
        scene(position[shuffled], velocity[shuffled], preferred[shuffled], period=(12, 10))
    )
    assert np.array_equal(a[shuffled], b)


def test_a_robot_is_avoided_as_a_person_is():
    person = scene([(0, 0)], [(1.3, 0)], [(1.3, 0)], robots=np.array([[3.0, 0.1, -1.0, 0.0, 0.3]]))
    people = scene([(0, 0), (3, 0.1)], [(1.3, 0), (-1, 0)], [(1.3, 0), (-1, 0)])
    policy = Orca(time_horizon=1.5)
    assert np.array_equal(policy.accelerate(person)[0], policy.accelerate(people)[0])
    assert policy.accelerate(person)[0, 1] < 0


def test_a_robot_beyond_the_seam_is_avoided_too():
    policy = Orca(time_horizon=1.5)
    near = scene([(10, 5)], [(1.3, 0)], [(1.3, 0)], robots=np.array([[13.0, 5.1, -1.0, 0.0, 0.3]]), period=(50, 10))
    seam = scene([(49, 5)], [(1.3, 0)], [(1.3, 0)], robots=np.array([[2.0, 5.1, -1.0, 0.0, 0.3]]), period=(50, 10))
    assert policy.accelerate(near) == pytest.approx(policy.accelerate(seam), abs=1e-12)


def test_people_wait_in_front_of_a_wall_and_keep_their_distance():
    walls = np.array([[[5.0, -5.0], [5.0, 5.0]]])
    track = walk_to([(9, 0)], [(0, 0.0)], horizon=1.5, max_acceleration=5.0, steps=150, walls=walls)
    assert track[..., 0].max() <= 5 - 0.3 + 1e-9
    assert track[-1, 0, 0] > 4.6


def test_people_walk_through_a_door_at_full_speed():
    # 1.2 m wide; its jambs are not in the way of somebody who walks straight through the middle.
    walls = np.array([[[5.0, -5.0], [5.0, -0.6]], [[5.0, 0.6], [5.0, 5.0]]])
    track = walk_to([(20, 0)], [(0, 0.0)], horizon=1.5, max_acceleration=5.0, steps=80, walls=walls)
    speeds = np.diff(track[:, 0, 0]) / DT
    assert speeds[5:] == pytest.approx(1.3, abs=1e-9)


def test_people_walk_round_the_end_of_a_wall():
    walls = np.array([[[5.0, -5.0], [5.0, 0.1]]])
    track = walk_to([(10, 0.2)], [(0, 0.2)], horizon=1.5, max_acceleration=5.0, steps=150, walls=walls)
    assert track[-1, 0, 0] > 9.6
    gap = np.hypot(track[:, 0, 0] - 5.0, np.maximum(track[:, 0, 1] - 0.1, 0))
    # Acceleration is limited, so a graze of some millimetres is possible.
    assert gap.min() > 0.3 - 5e-3
