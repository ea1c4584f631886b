"""Limits, contacts, walls and the seam."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.crowd.motion import STABLE, STIFFNESS, contact_accelerations, move
from components.crowd.scene import Scene
from components.crowd.walls import Walls

NO_ROBOTS = np.empty((0, 5))
NO_WALLS = np.empty((0, 2, 2))


def scene(
    position,
    velocity,
    *,
    robots=NO_ROBOTS,
    walls=NO_WALLS,
    period=(0.0, 0.0),
    max_speed=1.8,
    max_acceleration=5.0,
    dt=0.1,
):
    return Scene(
        position=np.asarray(position, np.float64),
        velocity=np.asarray(velocity, np.float64),
        preferred=np.zeros((len(position), 2)),
        radius=np.full(len(position), 0.3),
        robots=robots,
        pushed_by_robots=np.ones(len(position), np.bool_),
        walls=Walls(walls, period),
        period=np.asarray(period, np.float64),
        max_speed=np.full(len(position), max_speed),
        max_acceleration=np.full(len(position), max_acceleration),
        stream=np.zeros(len(position), np.uint64),
        dt=dt,
    )


def push(position, *, robots=NO_ROBOTS, walls=NO_WALLS, period=(0.0, 0.0), dt=0.1):
    now = scene(position, np.zeros_like(position), robots=robots, walls=walls, period=period)
    return contact_accelerations(
        now.position, now.radius, now.robots, now.pushed_by_robots, now.walls.within(1.0), now.period, dt
    )


def test_acceleration_and_speed_are_limited_in_that_order():
    position, velocity = move(scene([(0, 0)], [(1.5, 0)], max_acceleration=2.0), np.array([[30.0, 0.0]]))
    assert velocity == pytest.approx(np.array([(1.7, 0.0)]))
    assert position == pytest.approx(np.array([(0.17, 0.0)]))
    _, velocity = move(scene([(0, 0)], [(1.5, 0)]), np.array([[30.0, 0.0]]))
    assert velocity == pytest.approx(np.array([(1.8, 0.0)]))


def test_contact_is_a_spring_of_5000_newton_per_metre_on_80_kilograms():
    assert push([(0, 0), (0.5, 0)]) == pytest.approx(np.array([(-6.25, 0), (6.25, 0)]))


def test_contact_reaches_across_a_corner_of_the_seam():
    d = 0.4 / np.sqrt(2)
    p = push([(0.1, 0.1), (10.1 - d, 10.1 - d)], period=(10, 10))
    assert p[0] == pytest.approx(np.full(2, STIFFNESS * 0.2 / np.sqrt(2)))


def test_those_who_do_not_touch_are_not_pushed():
    assert not push([(0, 0), (0.6, 0), (5, 5)]).any()


def test_two_in_one_place_part():
    assert push([(1, 1), (1, 1)]) == pytest.approx(np.array([(-37.5, 0), (37.5, 0)]))


def test_robots_and_walls_push_with_the_same_spring():
    robot = np.array([[0.4, 0.0, 0.0, 0.0, 0.2]])
    assert push([(0, 0)], robots=robot) == pytest.approx(np.array([(-6.25, 0)]))
    assert push([(0, 0.2)], walls=[[(-5, 0), (5, 0)]]) == pytest.approx(np.array([(0, 6.25)]))


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), periodic=st.booleans())
def test_contacts_conserve_momentum(seed, periodic):
    position = np.random.default_rng(seed).random((60, 2)) * 4
    p = push(position, period=(4, 4) if periodic else (0, 0))
    assert p.sum(axis=0) == pytest.approx([0, 0], abs=1e-10)


@pytest.mark.parametrize("dt", [0.01, 0.1, 0.2, 0.5])
def test_a_squeezed_jam_does_not_explode(dt):
    # A periodic hexagonal lattice, 10% denser than touching discs, disturbed by a tenth of a millimetre.
    rows, columns, spacing = 10, 10, 0.54
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    size = np.array([columns * spacing, rows * spacing * np.sqrt(3) / 2])
    lattice = np.column_stack([((i + 0.5 * (j % 2)) * spacing).ravel(), (j * spacing * np.sqrt(3) / 2).ravel()])
    position = (lattice + np.random.default_rng(0).normal(0, 1e-4, lattice.shape)) % size
    velocity = np.zeros_like(position)
    for _ in range(200):
        position, velocity = move(scene(position, velocity, period=size, dt=dt), np.zeros_like(position))
    # The disturbance of 1e-4 m vibrates with omega <= sqrt(6 k / m): speeds stay of the order of their product.
    stiffness = min(STIFFNESS, STABLE / dt**2)
    assert np.abs(velocity).max() < 10 * 1e-4 * np.sqrt(6 * stiffness)


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1))
def test_nobody_passes_a_wall_however_hard_pushed(seed):
    rng = np.random.default_rng(seed)
    walls = np.array([[(0, 0), (4, 0)], [(4, 0), (4, 4)], [(4, 4), (0, 4)], [(0, 4), (0, 0)]], np.float64)
    position, velocity = 0.05 + rng.random((60, 2)) * 3.9, rng.normal(0, 5, (60, 2))
    for _ in range(20):
        position, velocity = move(
            scene(position, velocity, walls=walls, max_speed=20.0, max_acceleration=50.0), rng.normal(0, 50, (60, 2))
        )
        assert (position > 0).all()
        assert (position < 4).all()


def test_whoever_runs_into_a_wall_slides_along_it():
    walls = np.array([[(-5.0, 0.0), (5.0, 0.0)]])
    position, velocity = move(scene([(0, 0.05)], [(1.0, -5.0)], walls=walls, max_speed=9.0), np.zeros((1, 2)))
    assert velocity == pytest.approx(np.array([(1.0, 0.0)]))
    assert position == pytest.approx(np.array([(0.1, 0.05)]))


def test_whoever_leaves_comes_in_at_the_opposite_side():
    position, _ = move(scene([(9.95, 0.05)], [(1, -1)], period=(10, 10)), np.zeros((1, 2)))
    assert position == pytest.approx(np.array([(0.05, 9.95)]))


def test_a_tiny_step_below_zero_stays_below_the_period():
    position, _ = move(scene([(0.0, 5.0)], [(-1e-18, 0)], period=(10, 10)), np.zeros((1, 2)))
    assert (position >= 0).all()
    assert (position < 10).all()


def test_without_a_period_people_leave():
    position, _ = move(scene([(9.95, 5.0)], [(1, 0)]), np.zeros((1, 2)))
    assert position == pytest.approx(np.array([(10.05, 5.0)]))
