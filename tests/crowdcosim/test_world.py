"""The world wraps around where it is periodic, and nowhere else."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from crowdcosim.world import Wall, World

coordinate = st.floats(-1e3, 1e3)
point = st.tuples(coordinate, coordinate).map(np.array)
TORUS = World(size=(50, 10), periodic=(True, True))
PIPE = World(size=(50, 10), periodic=(True, False))


@given(point)
def test_wrapped_points_lie_in_the_world(p: np.ndarray) -> None:
    wrapped = TORUS.wrap(p)
    assert (wrapped >= 0).all()
    assert (wrapped < TORUS.size).all()


@given(point, st.integers(-3, 3), st.integers(-3, 3))
def test_a_point_and_its_images_are_one_place(p: np.ndarray, i: int, j: int) -> None:
    image = p + np.array([50.0 * i, 10.0 * j])
    # Rounding of the sums: coordinates up to 1e3 have 1e-13 between them.
    np.testing.assert_allclose(TORUS.displacement(p, image), 0.0, atol=1e-9)


@given(point, point)
def test_a_displacement_is_at_most_half_a_period_and_leads_there(a: np.ndarray, b: np.ndarray) -> None:
    d = TORUS.displacement(a, b)
    assert (np.abs(d) <= np.array([25.0, 5.0]) + 1e-9).all()
    np.testing.assert_allclose(TORUS.displacement(a + d, b), 0.0, atol=1e-9)


@given(point, point)
def test_an_axis_that_is_not_periodic_does_not_wrap(a: np.ndarray, b: np.ndarray) -> None:
    assert PIPE.displacement(a, b)[1] == b[1] - a[1]
    assert PIPE.wrap(a)[1] == a[1]


def test_walls_that_people_walk_through_are_no_walls_for_people() -> None:
    walls = (Wall(start=(0, 0), end=(50, 0), stops_people=False), Wall(start=(0, 10), end=(50, 10)))
    world = World(size=(50, 10), walls=walls)
    assert world.segments.shape == (2, 2, 2)
    assert world.segments_for_people.tolist() == [[[0, 10], [50, 10]]]
    assert World(size=(1, 1)).segments_for_people.shape == (0, 2, 2)
