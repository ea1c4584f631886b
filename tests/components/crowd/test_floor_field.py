"""Ways: as short as can be, clear of walls, across seams; and none where a body does not fit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from components.crowd.floor_field import COMFORT, Ways
from components.crowd.walls import Walls, nearby, nearest_of_thing
from crowdcosim.obstacles import Box, Disc, Polygon
from crowdcosim.world import Wall, World

RADIUS = 0.3
ROOM = (
    Wall(start=(0.0, 0.0), end=(20.0, 0.0)),
    Wall(start=(20.0, 0.0), end=(20.0, 12.0)),
    Wall(start=(20.0, 12.0), end=(0.0, 12.0)),
    Wall(start=(0.0, 12.0), end=(0.0, 0.0)),
)


def ways_to(area, world):
    return Ways(world, np.array([area], np.float64), RADIUS)


def descend(ways, start, world, *, steps=1200, step=0.05):
    """(steps + 1, 2) a point that follows the directions."""
    track = [np.array([start], np.float64)]
    for _ in range(steps):
        track.append(world.wrap(track[-1] + step * ways.directions(track[-1], np.zeros(1, np.int64))))
    return np.concatenate(track)


def clearance(points, world):
    """(N,) distance to what stops people, 1 m at most."""
    grid = Walls.of(world).within(1.0)
    result = np.ones(len(points))
    for k, (x, y) in enumerate(points):
        q, end = nearby(grid, x, y)
        while q < end:
            q, px, py = nearest_of_thing(grid, q, end, x, y)
            result[k] = min(result[k], np.hypot(px, py))
    return result


def length_on_graph(start, goal, boxes, margin):
    """Of the shortest way from point to point round boxes (x0, y0, x1, y1) that are larger by a margin."""
    grown = np.array(boxes) + margin * np.array([-1, -1, 1, 1])
    nodes = [start, goal] + [(x, y) for a, b, c, d in grown for x in (a, c) for y in (b, d)]
    nodes, count = np.array(nodes), len(nodes)
    share = np.linspace(0, 1, 400)[:, None]
    lengths = np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            x, y = (nodes[i] * share + nodes[j] * (1 - share)).T[:, :, None]
            inner = grown + 1e-9 * np.array([1, 1, -1, -1])
            if not ((inner[:, 0] < x) & (x < inner[:, 2]) & (inner[:, 1] < y) & (y < inner[:, 3])).any():
                lengths[i, j] = lengths[j, i] = np.hypot(*(nodes[i] - nodes[j]))
    return dijkstra(lengths, indices=0)[1]


@settings(deadline=None, max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_times_are_those_of_shortest_ways_on_a_visibility_graph(seed):
    rng = np.random.default_rng(seed)
    # One box in each third of the world: they stay apart by a body's width and more.
    corner = np.column_stack([rng.uniform((2.5, 8.0, 13.5), (3.5, 9.0, 14.5)), rng.uniform(0.8, 4, 3)])
    boxes = [
        (x, y, x + w, y + h) for (x, y), w, h in zip(corner, rng.uniform(1, 3, 3), rng.uniform(2, 7, 3), strict=True)
    ]
    obstacles = tuple(Box(shape="box", centre=((a + c) / 2, (b + d) / 2), size=(c - a, d - b)) for a, b, c, d in boxes)
    world = World(size=(20.0, 12.0), obstacles=obstacles)
    # Cells have their centres at odd multiples of 0.05 m.
    start, goal = (0.45, round(rng.uniform(1, 11), 1) + 0.05), (19.0, rng.uniform(1, 11))
    half = 0.1
    ways = ways_to([(goal[0] - half, goal[1] - half), (goal[0] + half, goal[1] + half)], world)
    time = ways.time[0, int(start[0] / 0.1), int(start[1] / 0.1)]
    # Not shorter than for a point without a body; not longer than round boxes with room for its comfort. The area
    # takes its extent away; second order fast marching is good to half a percent here.
    assert time > (length_on_graph(start, goal, boxes, 0.0) - half * np.sqrt(2)) * 0.995
    assert time < length_on_graph(start, goal, boxes, RADIUS + COMFORT + 0.05) * 1.005


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), periodic=st.tuples(st.booleans(), st.booleans()))
def test_whoever_follows_the_way_arrives_in_that_time_and_touches_nothing(seed, periodic):
    rng = np.random.default_rng(seed)
    obstacles = tuple(
        Disc(shape="disc", centre=tuple(rng.uniform((2, 1), (18, 11))), radius=rng.uniform(0.2, 1.5)) for _ in range(5)
    ) + tuple(
        Box(shape="box", centre=tuple(rng.uniform((2, 1), (18, 11))), size=tuple(rng.uniform(0.5, 3, 2)), yaw=1.0)
        for _ in range(3)
    )
    world = World(size=(20.0, 12.0), periodic=periodic, walls=() if any(periodic) else ROOM, obstacles=obstacles)
    ways = ways_to([(18.5, 4.0), (19.5, 8.0)], world)
    start = np.array((0.75, 6.05))
    time = ways.time[0, 7, 60]
    if not np.isfinite(time) or clearance(start[None], world)[0] < RADIUS:
        return
    track = descend(ways, start, world)
    inside = ((track >= (18.5, 4.0)) & (track <= (19.5, 8.0))).all(axis=1)
    assert inside.any()
    # Slower ground makes up for the difference; steps of 5 cm shake a little beside a wall.
    assert inside.argmax() * 0.05 < time * 1.03 + 0.2
    assert clearance(track, world).min() > RADIUS - 0.06


def test_the_shorter_way_may_lead_across_the_seam():
    world = World(size=(20.0, 12.0), periodic=(True, True), walls=(Wall(start=(10.0, 2.0), end=(10.0, 10.0)),))
    ways = ways_to([(18.0, 5.0), (19.0, 7.0)], world)
    assert ways.directions(np.array([[2.0, 6.0]]), np.zeros(1, np.int64)) == pytest.approx(
        np.array([(-1.0, 0.0)]), abs=0.01
    )
    assert ways.time[0, 20, 60] == pytest.approx(3.05, abs=0.05)
    # Between the wall and the area it is the other way.
    assert ways.directions(np.array([[11.0, 6.0]]), np.zeros(1, np.int64))[0, 0] > 0.99


def test_where_a_body_does_not_fit_there_is_no_way():
    def gap(width):
        return World(
            size=(20.0, 12.0),
            walls=(
                *ROOM,
                Wall(start=(10.0, 0.0), end=(10.0, 6.0)),
                Wall(start=(10.0, 6.0 + width), end=(10.0, 12.0)),
            ),
        )

    west = np.array([(1.0, 1.0), (2.0, 2.0)])
    area = [(18.0, 1.0), (19.0, 11.0)]
    assert not ways_to(area, gap(0.55)).reachable(west, 0)
    # A body's width and a cell.
    assert ways_to(area, gap(0.75)).reachable(west, 0)
    full = World(size=(20.0, 12.0), obstacles=(Box(shape="box", centre=(18.5, 6.0), size=(3.0, 12.0)),))
    assert not ways_to(area, full).reachable(west, 0)


def test_whoever_is_pressed_against_a_wall_is_led_off_and_on():
    world = World(size=(20.0, 12.0), walls=ROOM)
    ways = ways_to([(18.0, 5.0), (19.0, 7.0)], world)
    x, y = ways.directions(np.array([[5.0, 0.12]]), np.zeros(1, np.int64))[0]
    assert x > 0.2
    assert y > 0.5


def test_without_walls_the_way_is_straight_to_the_nearest_point():
    ways = ways_to([(8.0, 2.0), (9.0, 4.0)], World(size=(20.0, 12.0), periodic=(True, False)))
    position = np.array([[2.0, 3.0], [8.5, 3.0], [5.0, 8.0], [19.0, 3.0]])
    # From x = 19 it is 9 m across the seam, 10 m without.
    expected = np.array([(1.0, 0.0), (0.0, 0.0), (0.6, -0.8), (1.0, 0.0)])
    assert ways.directions(position, np.zeros(4, np.int64)) == pytest.approx(expected)


def test_polygons_and_their_images_are_closed_inside():
    corners = ((-2.0, 5.0), (2.0, 5.0), (2.0, 7.0), (-2.0, 7.0))
    world = World(size=(20.0, 12.0), periodic=(True, False), obstacles=(Polygon(shape="polygon", corners=corners),))
    time = ways_to([(10.0, 1.0), (11.0, 2.0)], world).time[0]
    assert np.isinf(time[[0, 10, 190, 199], 60]).all()
    assert np.isfinite(time[[30, 170], 60]).all()
