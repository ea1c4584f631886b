"""The world wraps around where it is periodic, and nowhere else."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from crowdcosim.obstacles import Box, Disc, Polygon
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


def test_edges_of_obstacles_follow_the_walls_and_know_whose_they_are() -> None:
    box = Box(shape="box", centre=(5.0, 5.0), size=(2.0, 1.0), height=0.8)
    corners = Polygon(shape="polygon", corners=((0.0, 0.0), (0.0, 1.0), (1.0, 0.0)))
    world = World(size=(9, 9), walls=(Wall(start=(0, 0), end=(9, 0), stops_people=False),), obstacles=(box, corners))
    assert world.segment_numbers.tolist() == [1, 2, 2, 2, 2, 3, 3, 3]
    assert world.segment_heights.tolist() == [2.5, 0.8, 0.8, 0.8, 0.8, 2.5, 2.5, 2.5]
    assert len(world.segments_for_people) == 7
    assert world.segments[1].tolist() == [[4.0, 4.5], [6.0, 4.5]]


@given(point)
def test_what_is_obstructed_is_inside_an_obstacle_or_its_image(p: np.ndarray) -> None:
    disc = Disc(shape="disc", centre=(49.5, 5.0), radius=1.0)
    away = np.hypot(*TORUS.displacement(p, np.array(disc.centre)))
    world = World(size=TORUS.size, periodic=TORUS.periodic, obstacles=(disc,))
    # The polygon around the disc is up to 0.5% farther out.
    if not 1.0 - 1e-9 <= away <= 1.005:
        assert world.obstructed(p[None])[0] == (away < 1.0)
