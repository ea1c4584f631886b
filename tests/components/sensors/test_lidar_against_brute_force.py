"""The LiDAR's scans equal those of an oracle that intersects every beam with every object."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.sensors.lidar import Config, Lidar
from crowdcosim.messages import BeamAgents
from crowdcosim.world import Wall, World


class Seen(NamedTuple):
    distance: np.ndarray
    kind: np.ndarray
    agent: np.ndarray


def brute_force(config, world, robot, crowd, others, grow=0.0, shift=0.0):
    """Every beam against every image of every disc and against every wall.

    Objects are larger by `grow` [m], and the scanner is displaced by `shift` [m], to see what hangs by a hair.
    """
    origin = place(config, robot) + shift
    full = config.field_of_view == 2 * math.pi
    offsets = np.linspace(-0.5, 0.5, config.beams, endpoint=not full) * config.field_of_view
    angles = robot.heading + config.yaw + offsets
    beams = np.exp(1j * angles)
    found = [(np.full(config.beams, np.inf), BeamAgents.NOTHING, 0)]
    for number, wall in enumerate(world.walls, 1):
        a, b = complex(*wall.start) - complex(*origin), complex(*wall.end) - complex(*origin)
        a, b = a - (b - a) / abs(b - a) * grow, b + (b - a) / abs(b - a) * grow
        # In the beam's own frame the wall runs from p to q; the beam meets it where it crosses the real axis.
        p, q = a / beams, b / beams
        with np.errstate(divide="ignore", invalid="ignore"):
            met = p.real - p.imag * (q.real - p.real) / (q.imag - p.imag)
        met[(p.imag > 0) == (q.imag > 0)] = np.inf
        met[~(met >= 0)] = np.inf
        found.append((met, BeamAgents.WALL, number))
    discs = [(BeamAgents.PERSON, int(i), p, r) for i, p, r in zip(crowd.id, crowd.position, crowd.radius, strict=True)]
    discs += [(BeamAgents.ROBOT, int(o.name.removeprefix("robot")), o.position, o.radius) for o in others]
    for kind, number, position, radius in discs:
        for centre in images(position - origin, radius + config.range_max + 1.0, world):
            at = centre / beams
            with np.errstate(invalid="ignore"):
                met = at.real - np.sqrt((radius + grow) ** 2 - at.imag**2)
            met[~(met >= 0)] = np.inf
            found.append((np.zeros(config.beams) if abs(centre) <= radius + grow else met, kind, number))
    table = np.array([met for met, _, _ in found])
    table[table > config.range_max] = np.inf
    first = table.argmin(axis=0)
    kinds, agents = np.array([kind for _, kind, _ in found]), np.array([number for _, _, number in found])
    return Seen(table.min(axis=0), kinds[first], agents[first])


def place(config, robot):
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    return robot.position + np.array([[cos, -sin], [sin, cos]]) @ config.position[:2]


def is_on(wall, point):
    start, end = complex(*wall.start) - complex(*point), complex(*wall.end) - complex(*point)
    return abs(start) + abs(end) - abs(end - start) < 1e-9


def images(offset, reach, world):
    """All places, as complex numbers, at which a periodic world shows `offset`, as far as `reach`."""
    most = [
        int((reach + abs(o)) / size) + 1 if wraps else 0
        for o, size, wraps in zip(offset, world.size, world.periodic, strict=True)
    ]
    for i in range(-most[0], most[0] + 1):
        for j in range(-most[1], most[1] + 1):
            centre = complex(offset[0] + i * world.size[0], offset[1] + j * world.size[1])
            if abs(centre) <= reach:
                yield centre


coordinate = st.floats(-1.0, 13.0)
scenes = st.fixed_dictionaries(
    {
        "people": st.lists(st.tuples(coordinate, coordinate, st.floats(0.05, 0.6)), max_size=12),
        "others": st.lists(st.tuples(coordinate, coordinate), max_size=2),
        "walls": st.lists(
            st.tuples(coordinate, coordinate, coordinate, coordinate).filter(
                lambda w: math.hypot(w[0] - w[2], w[1] - w[3]) > 0.1
            ),
            max_size=4,
        ),
        "pose": st.tuples(st.floats(-20.0, 30.0), coordinate, st.floats(-10.0, 10.0)),
        "periodic": st.tuples(st.booleans(), st.booleans()),
        "beams": st.integers(2, 200),
        "field_of_view": st.just(2 * math.pi) | st.floats(0.01, 6.28),
        "range_max": st.floats(0.5, 30.0),
        "mount": st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)),
        "yaw": st.floats(-7.0, 7.0),
    }
)


@settings(max_examples=150, deadline=None)
@given(scene=scenes)
def test_scan_equals_brute_force(setup, robot, people, scene):
    walls = tuple(Wall(start=w[:2], end=w[2:]) for w in scene["walls"])
    world = World(size=(12.0, 11.0), periodic=scene["periodic"], walls=walls)
    config = Config(
        beams=scene["beams"],
        field_of_view=scene["field_of_view"],
        range_min=0.0,
        range_max=scene["range_max"],
        position=(*scene["mount"], 0.1),
        yaw=scene["yaw"],
    )
    own, crowd = robot(*scene["pose"]), people(*scene["people"])
    others = tuple(robot(*where, number=n) for n, where in enumerate(scene["others"], 2))
    assume(not any(is_on(wall, place(config, own)) for wall in walls))
    lidar = Lidar(config)
    lidar.reset(setup(world))
    scan, agents = lidar.step(own, crowd, others)

    expected = brute_force(config, world, own, crowd, others)
    clear = np.ones(config.beams, bool)
    # Where a hair's breadth decides who is hit, rounding decides; all other beams must agree.
    for grow, shift in itertools.product((-1e-7, 1e-7), repeat=2):
        shaken = brute_force(config, world, own, crowd, others, grow, np.array([shift, 0.7 * shift]))
        clear &= (shaken.kind == expected.kind) & (shaken.agent == expected.agent)
        with np.errstate(invalid="ignore"):  # inf - inf
            clear &= ~(np.abs(shaken.distance - expected.distance) > 1e-6 + 1e-6 * expected.distance)
    np.testing.assert_array_equal(agents.kind[clear], expected.kind[clear])
    np.testing.assert_array_equal(agents.agent[clear], expected.agent[clear])
    # float32 holds 7 digits.
    np.testing.assert_allclose(scan.ranges[clear], expected.distance[clear], rtol=1e-5, atol=1e-6)


def test_a_dense_corridor_equals_brute_force(setup, robot, people):
    """The paper's densest scenario, seen from near its seam; hardly a beam is left to rounding."""
    corners = [(0.0, 0.0), (50.0, 0.0), (50.0, 10.0), (0.0, 10.0)]
    walls = tuple(Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    rng = np.random.default_rng(3)
    config = Config(range_min=0.0)
    for periodic in ((True, True), (False, False)):
        world = World(size=(50.0, 10.0), periodic=periodic, walls=walls[1::2] if periodic[0] else walls)
        lidar = Lidar(config)
        lidar.reset(setup(world))
        for _ in range(5):
            crowd = people(*rng.uniform((0, 0), (50, 10), (350, 2)))
            own, others = robot(49.0, 5.0, rng.uniform(-4, 4)), (robot(1.0, 6.0, number=2),)
            scan, agents = lidar.step(own, crowd, others)
            expected = brute_force(config, world, own, crowd, others)
            assert np.count_nonzero(agents.kind != expected.kind) == 0
            assert np.count_nonzero(agents.agent != expected.agent) == 0
            np.testing.assert_allclose(scan.ranges, expected.distance, rtol=1e-5)
