"""Random placing keeps people apart, across the seam too, and says when there is no room."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.crowd.placement import check, place
from crowdcosim.obstacles import Disc, Polygon
from crowdcosim.world import Wall, World

CORRIDOR = World(size=(50.0, 10.0), periodic=(True, True))
NO_ROBOTS = np.empty((0, 3))


def gaps(position, world):
    d = world.displacement(position[:, None], position[None, :])
    distance = np.hypot(d[..., 0], d[..., 1])
    np.fill_diagonal(distance, np.inf)
    return distance


@settings(deadline=None, max_examples=25)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.sampled_from([0, 1, 50, 350]),
    periodic=st.tuples(st.booleans(), st.booleans()),
)
def test_nobody_overlaps_with_anybody_at_the_benchmarks_densities(seed, count, periodic):
    world = World(size=(50.0, 10.0), periodic=periodic)
    robots = np.array([[0.1, 5.0, 0.5]])
    position = place(np.random.default_rng(seed), np.full(count, 0.3), world, robots)
    assert position.shape == (count, 2)
    assert (gaps(position, world) >= 0.6).all()
    margin = np.where(periodic, 0.0, 0.3)
    assert ((position >= margin) & (position <= np.array([50, 10]) - margin)).all()
    assert (np.hypot(*world.displacement(robots[0, :2], position).T) >= 0.8).all()
    check(position, np.full(count, 0.3), world, robots)


def test_people_keep_off_walls_that_stop_them_and_only_those():
    walls = (
        Wall(start=(0.0, 5.0), end=(20.0, 5.0)),
        Wall(start=(30.0, 5.0), end=(50.0, 5.0), stops_people=False),
    )
    world = World(size=(50.0, 10.0), periodic=(True, True), walls=walls)
    position = place(np.random.default_rng(0), np.full(350, 0.3), world, NO_ROBOTS)
    near = np.abs(position[:, 1] - 5.0) < 0.3
    assert not near[position[:, 0] < 20].any()
    assert near[position[:, 0] > 30].any()


def test_places_are_spread_evenly():
    position = place(np.random.default_rng(0), np.full(350, 0.3), CORRIDOR, NO_ROBOTS)
    # Five parts of the corridor: 70 people each; people who exclude each other spread more evenly than by chance.
    assert np.histogram(position[:, 0], 5, (0, 50))[0] == pytest.approx([70] * 5, abs=20)


def test_a_full_world_is_an_error_that_says_so():
    with pytest.raises(ValueError, match=r"no room for person \d+ of 1500 .* 85%.*lower `count`"):
        place(np.random.default_rng(0), np.full(1500, 0.3), CORRIDOR, NO_ROBOTS)


def test_a_world_that_is_smaller_than_a_person_is_an_error():
    with pytest.raises(ValueError, match="no room for person 1 of 1"):
        place(np.random.default_rng(0), np.full(1, 0.3), World(size=(0.5, 10.0)), NO_ROBOTS)


@pytest.mark.parametrize("size", [(0.5, 0.5), (1.0, 50.0)])
def test_a_narrow_periodic_world_holds_whom_it_can(size):
    world = World(size=size, periodic=(True, True))
    assert place(np.random.default_rng(0), np.full(1, 0.3), world, NO_ROBOTS).shape == (1, 2)


@pytest.mark.parametrize(
    ("positions", "message"),
    [
        ([(1, 1), (50, 1)], r"positions\[1\] is \[50.0, 1.0\], expected within the world of 50 x 10 m"),
        ([(1, 1), (-0.1, 1)], r"positions\[1\]"),
        ([(1, 1), (3, 3), (1.5, 1)], r"positions\[2\] .* 0.500 m from positions\[0\], expected at least 0.6 m"),
        ([(0.1, 0.1), (49.9, 9.9)], r"positions\[1\] .* 0.283 m from positions\[0\]"),
        ([(25, 5)], r"positions\[0\] .* on a robot's start"),
    ],
)
def test_given_positions_that_do_not_fit_are_named(positions, message):
    with pytest.raises(ValueError, match=message):
        check(np.array(positions, np.float64), np.full(len(positions), 0.3), CORRIDOR, np.array([[25.0, 5.2, 0.3]]))


def test_given_positions_may_be_rounded():
    check(np.array([[1.0, 1.0], [1.595, 1.0]]), np.full(2, 0.3), CORRIDOR, NO_ROBOTS)


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), periodic=st.tuples(st.booleans(), st.booleans()))
def test_discs_of_any_size_keep_apart_and_parties_together(seed, periodic):
    world = World(size=(20.0, 10.0), periodic=periodic)
    rng = np.random.default_rng(seed)
    radius = rng.uniform(0.15, 0.45, 60)
    parties = np.array([1, 3, 2] * 10)
    # Two metres apart, in a row.
    offset = np.concatenate([np.arange(n)[:, None] * (0.0, 2.0) for n in parties])
    position = place(rng, radius, world, NO_ROBOTS, offset=offset, parties=parties)
    gap = gaps(position, world)
    assert (gap >= (radius[:, None] + radius - 1e-12)).all()
    margin = np.where(periodic, 0.0, radius[:, None])
    assert ((position >= margin) & (position <= np.array([20, 10]) - margin)).all()
    first = np.cumsum(parties) - parties
    for begin, n in zip(first, parties, strict=True):
        step = world.displacement(position[begin], position[begin : begin + n])
        assert np.allclose(step[:, 0], 0, atol=1e-9)
        assert np.allclose(step[:, 1], 2.0 * np.arange(n), atol=1e-9)
    check(position, radius, world, NO_ROBOTS)


def test_people_are_placed_outside_of_obstacles_and_their_images():
    obstacles = (
        Disc(shape="disc", centre=(0.0, 0.0), radius=3.0),
        Polygon(shape="polygon", corners=((20.0, 2.0), (30.0, 2.0), (30.0, 8.0))),
    )
    world = World(size=(50.0, 10.0), periodic=(True, True), obstacles=obstacles)
    position = place(np.random.default_rng(0), np.full(250, 0.3), world, NO_ROBOTS)
    assert not world.obstructed(position).any()
    assert (np.hypot(*world.displacement(np.zeros(2), position).T) >= 3.3).all()
    with pytest.raises(ValueError, match=r"positions\[1\] is \[49.0, 9.0\], inside an obstacle"):
        check(np.array([(10.0, 5.0), (49.0, 9.0)]), np.full(2, 0.3), world, NO_ROBOTS)
