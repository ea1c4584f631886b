"""The neighbour search finds what a comparison of all with all finds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.crowd.cells import gather, sort_into_cells


def neighbours(position, period, reach, size, *, after_self=False):
    """Person -> {neighbour: (dx, dy)} by the cells."""
    cells = sort_into_cells(position, period, size)
    n = len(position)
    found, dx, dy = np.empty(n + 1, np.int64), np.empty(n + 1), np.empty(n + 1)
    result = {}
    for k in range(n):
        count = gather(cells, k, k + 1 if after_self else 0, reach, found, dx, dy)
        result[int(cells.order[k])] = {
            int(cells.order[j]): (x, y) for j, x, y in zip(found[:count], dx, dy, strict=False)
        }
        assert len(set(found[:count])) == count, "nobody is found twice"
    return result


def by_comparing_all(position, period, reach):
    d = position[None, :] - position[:, None]
    wraps = np.where(period > 0, period, 1.0)
    d -= np.where(period > 0, np.round(d / wraps) * wraps, 0.0)
    near = np.hypot(d[..., 0], d[..., 1]) <= reach
    np.fill_diagonal(near, False)
    return {i: {int(j): tuple(d[i, j]) for j in np.flatnonzero(near[i])} for i in range(len(position))}


worlds = st.tuples(st.sampled_from([0.0, 3.0, 10.0, 50.0]), st.sampled_from([0.0, 3.0, 10.0, 50.0]))


@settings(deadline=None, max_examples=60)
@given(
    period=worlds,
    count=st.integers(0, 60),
    reach=st.sampled_from([0.6, 2.0, 5.0]),
    size=st.sampled_from([0.6, 2.5, 7.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_cells_find_the_same_neighbours_as_comparing_all_with_all(period, count, reach, size, seed):
    period = np.array(period)
    extent = np.where(period > 0, period, 30.0)
    offset = np.where(period > 0, 0.0, -11.0)
    position = np.random.default_rng(seed).random((count, 2)) * extent + offset
    found, expected = neighbours(position, period, reach, size), by_comparing_all(position, period, reach)
    assert {i: set(f) for i, f in found.items()} == {i: set(f) for i, f in expected.items()}
    for i, those in found.items():
        for j, d in those.items():
            # Differences of coordinates below 64 m carry a few units of 2^-48.
            assert d == pytest.approx(expected[i][j], abs=1e-13)


def test_every_pair_is_met_once_when_only_later_places_are_asked_for():
    position = np.random.default_rng(1).random((80, 2)) * 10
    period = np.array([10.0, 10.0])
    once = neighbours(position, period, 2.0, 1.0, after_self=True)
    pairs = [frozenset((i, j)) for i, those in once.items() for j in those]
    expected = {frozenset((i, j)) for i, those in by_comparing_all(position, period, 2.0).items() for j in those}
    assert len(pairs) == len(expected)
    assert set(pairs) == expected


def test_the_order_of_places_does_not_depend_on_the_order_of_people():
    position = np.random.default_rng(2).random((100, 2)) * (50, 10)
    shuffled = np.random.default_rng(3).permutation(100)
    a = sort_into_cells(position, np.array([50.0, 10.0]), 2.5)
    b = sort_into_cells(position[shuffled], np.array([50.0, 10.0]), 2.5)
    assert np.array_equal(a.x, b.x)
    assert np.array_equal(a.y, b.y)
    assert np.array_equal(a.order, shuffled[b.order])


def test_an_almost_empty_plane_keeps_a_small_grid():
    position = np.array([[0.0, 0.0], [1e6, 1e6]])
    cells = sort_into_cells(position, np.zeros(2), 2.5)
    assert cells.columns * cells.rows <= 2 * 8 + 64
