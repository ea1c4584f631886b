"""Lists of what is near: complete, short, across seams; obstacles count as one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.crowd.walls import Walls, nearby, nearest_of_thing, nearest_on_segment
from crowdcosim.obstacles import Box, Disc, Polygon
from crowdcosim.world import Wall, World


def listed(grid, x, y):
    begin, end = nearby(grid, x, y)
    return grid.listed[begin:end]


@settings(deadline=None, max_examples=25)
@given(
    seed=st.integers(0, 2**32 - 1),
    periodic=st.tuples(st.booleans(), st.booleans()),
    reach=st.sampled_from([0.3, 1.0, 5.0, 9.0]),
)
def test_everything_within_reach_is_listed_at_every_image(seed, periodic, reach):
    rng, size = np.random.default_rng(seed), np.array([12.0, 7.0])
    period = np.where(periodic, size, 0.0)
    # Some are longer than the world.
    start = rng.random((12, 2)) * size
    segments = np.stack([start, start + rng.normal(0, 4, (12, 2))], axis=1)
    grid = Walls(segments, period).within(reach)
    shifts = [(i, j) for i in range(-4, 5) for j in range(-4, 5) if (not i or periodic[0]) and (not j or periodic[1])]
    for x, y in rng.random((10, 2)) * size:
        expected = 0
        for shift in shifts:
            for a, b in segments + period * shift:
                px, py, _ = nearest_on_segment(*a, *b, x, y)
                expected += np.hypot(px - x, py - y) <= reach
        ends = grid.ends[listed(grid, x, y)]
        gaps = [np.hypot(*np.subtract(nearest_on_segment(*e, x, y)[:2], (x, y))) for e in ends]
        assert sum(gap <= reach for gap in gaps) == expected
        # A cell's diagonal more than the reach at most, once for the cell and once for its circle.
        assert all(gap <= reach + 2 * grid.size * np.sqrt(2) for gap in gaps)


def test_what_lies_behind_an_obstacles_front_is_left_out():
    world = World(size=(40.0, 40.0), obstacles=(Disc(shape="disc", centre=(20.0, 20.0), radius=3.0),))
    grid = Walls.of(world).within(5.0)
    seen = grid.ends[listed(grid, 15.0, 20.0)]
    assert 8 <= len(seen) <= 20
    assert (seen[:, 0] < 20.5).all()
    assert len(listed(grid, 1.0, 1.0)) == 0
    assert len(listed(grid, -300.0, 1e9)) == 0


def test_an_obstacle_is_one_thing_with_one_nearest_point():
    world = World(
        size=(20.0, 20.0),
        walls=(Wall(start=(0.0, 12.0), end=(20.0, 12.0), stops_people=False), Wall(start=(0.0, 5.0), end=(20.0, 5.0))),
        obstacles=(
            Box(shape="box", centre=(10.0, 10.0), size=(2.0, 2.0)),
            Disc(shape="disc", centre=(14, 8), radius=1),
        ),
    )
    grid = Walls.of(world).within(5.0)
    x, y = 11.5, 8.0
    q, end = nearby(grid, x, y)
    ways = []
    while q < end:
        q, px, py = nearest_of_thing(grid, q, end, x, y)
        ways.append((px, py))
    # The wall that stops people, the corner of the box, the disc (0.5% larger at most).
    assert ways[0] == pytest.approx((0.0, -3.0))
    assert ways[1] == pytest.approx((-0.5, 1.0))
    assert np.hypot(*ways[2]) == pytest.approx(1.5, abs=0.005)
    assert len(ways) == 3


def test_ten_thousand_edges_make_short_lists():
    rng = np.random.default_rng(0)
    obstacles = tuple(
        Polygon(shape="polygon", corners=((x, y), (x + 0.5, y), (x, y + 0.5))) for x, y in rng.random((3300, 2)) * 398
    )
    walls = Walls.of(World(size=(400.0, 400.0), obstacles=obstacles))
    assert len(walls) == 9900
    # 3,300 obstacles on 160,000 m2: 2.5 within 6 m, with at most 3 edges each.
    assert walls.within(5.0).most < 60
    assert np.diff(walls.within(5.0).first).mean() < 8
