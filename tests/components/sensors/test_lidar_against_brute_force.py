"""The LiDAR's scans equal those of an oracle that intersects every beam with every object."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.sensors.lidar import Config, Lidar
from crowdcosim.avatar import pose
from crowdcosim.body import BODY_PART
from crowdcosim.messages import BeamAgents, Crowd
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World


class Seen(NamedTuple):
    distance: np.ndarray
    kind: np.ndarray
    agent: np.ndarray
    body_part: np.ndarray


def brute_force(config, world, robot, crowd, others, grow=0.0, shift=(0.0, 0.0)):
    """Every beam against every image of everybody's capsules and of every robot, and against every wall.

    Objects are larger by `grow` [m], and the scanner is displaced by `shift` [m], to see what hangs by a hair.
    """
    origin = place(config, robot) + np.array(shift)
    full = config.field_of_view == 2 * math.pi
    offsets = np.linspace(-0.5, 0.5, config.beams, endpoint=not full) * config.field_of_view
    angles = robot.heading + config.mount.yaw + offsets
    beams = np.exp(1j * angles)
    found = [(np.full(config.beams, np.inf), BeamAgents.NOTHING, 0, 0)]
    for number, wall in enumerate(world.walls, 1):
        a, b = complex(*wall.start) - complex(*origin), complex(*wall.end) - complex(*origin)
        a, b = a - (b - a) / abs(b - a) * grow, b + (b - a) / abs(b - a) * grow
        # In the beam's own frame the wall runs from p to q; the beam meets it where it crosses the real axis.
        p, q = a / beams, b / beams
        with np.errstate(divide="ignore", invalid="ignore"):
            met = p.real - p.imag * (q.real - p.real) / (q.imag - p.imag)
        met[(p.imag > 0) == (q.imag > 0)] = np.inf
        met[~(met >= 0)] = np.inf
        found.append((met, BeamAgents.WALL, number, 0))
    height = config.mount.position[2] + shift[1]
    bodies = pose(np.zeros_like(crowd.position), crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)
    for i, number in enumerate(crowd.id.tolist()):
        for centre in images(crowd.position[i] - origin, config.range_max + 3.0, world):
            for capsule, part in zip(bodies[i], BODY_PART.tolist(), strict=True):
                met = capsule_met(capsule, centre, height, beams, grow)
                if met is not None:
                    found.append((met, BeamAgents.PERSON, number, part))
    for other in others:
        for centre in images(other.position - origin, other.radius + config.range_max + 1.0, world):
            at = centre / beams
            with np.errstate(invalid="ignore"):
                met = at.real - np.sqrt((other.radius + grow) ** 2 - at.imag**2)
            met[~(met >= 0)] = np.inf
            inside = abs(centre) <= other.radius + grow
            number = int(other.name.removeprefix("robot"))
            found.append((np.zeros(config.beams) if inside else met, BeamAgents.ROBOT, number, 0))
    table = np.array([met for met, *_ in found])
    table[table > config.range_max] = np.inf
    first = table.argmin(axis=0)
    kinds, agents, parts = (np.array(column)[first] for column in list(zip(*found, strict=True))[1:])
    return Seen(table.min(axis=0), kinds, agents, parts)


def capsule_met(capsule, centre, height, beams, grow):
    """(B,) where rays at `height` enter the union of two balls and a tube, None if they are too high or too low."""
    a, b, radius = capsule[0:3].copy(), capsule[3:6].copy(), capsule[6] + grow
    if min(a[2], b[2]) - radius > height or max(a[2], b[2]) + radius < height:
        return None
    offset = np.array([centre.real, centre.imag, -height])
    a, b = a + offset, b + offset
    length = np.linalg.norm(b - a)
    axis = (b - a) / length
    if np.linalg.norm(a - np.clip(a @ -axis, 0.0, length) * -axis) <= radius:
        return np.zeros(len(beams))
    rays = np.column_stack([beams.real, beams.imag, np.zeros(len(beams))])
    entries = [entry(1.0, rays @ end, end @ end - radius**2) for end in (a, b)]
    # Across the axis, the tube is a disc.
    across, aside = rays - np.outer(rays @ axis, axis), a - (a @ axis) * axis
    tube = entry((across**2).sum(1), across @ aside, aside @ aside - radius**2)
    with np.errstate(invalid="ignore"):
        along = tube * (rays @ axis) - a @ axis
        tube[~((along >= 0.0) & (along <= length))] = np.inf
    return np.minimum(np.minimum(*entries), tube)


def entry(square, half, constant):
    """(B,) smaller root of square t^2 - 2 half t + constant = 0, infinite unless it is real and positive."""
    with np.errstate(invalid="ignore", divide="ignore"):
        root = (half - np.sqrt(half**2 - square * constant)) / square
    return np.where(root > 0.0, root, np.inf)


def place(config, robot):
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    return robot.position + np.array([[cos, -sin], [sin, cos]]) @ config.mount.position[:2]


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


def walkers(rows):
    """A crowd from rows of x, y, vx, vy and, from 0 to 1, heading, stature and phase; ids from 101."""
    table = np.array(rows, np.float64).reshape(-1, 7)
    n = len(table)
    return Crowd(
        id=np.arange(101, 101 + n),
        group=np.zeros(n, np.uint32),
        position=table[:, 0:2],
        velocity=table[:, 2:4],
        heading=2 * np.pi * table[:, 4],
        radius=np.full(n, 0.3),
        stature=1.4 + 0.6 * table[:, 5],
        mass=np.full(n, 70.0),
        gait_phase=table[:, 6],
        gait_speed=np.hypot(*table[:, 2:4].T),
    )


coordinate = st.floats(-1.0, 13.0)
speed = st.floats(-1.5, 1.5)
scenes = st.fixed_dictionaries(
    {
        "people": st.lists(st.tuples(coordinate, coordinate, speed, speed, *3 * [st.floats(0, 1)]), max_size=8),
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
        "mount": st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.02, 1.9)),
        "yaw": st.floats(-7.0, 7.0),
    }
)


@settings(max_examples=60, deadline=None)
@given(scene=scenes)
def test_scan_equals_brute_force(setup, robot, scene):
    walls = tuple(Wall(start=w[:2], end=w[2:]) for w in scene["walls"])
    world = World(size=(12.0, 11.0), periodic=scene["periodic"], walls=walls)
    config = Config(
        beams=scene["beams"],
        field_of_view=scene["field_of_view"],
        range_min=0.0,
        range_max=scene["range_max"],
        mount=Mount(position=scene["mount"], yaw=scene["yaw"]),
    )
    own, crowd = robot(*scene["pose"]), walkers(scene["people"])
    others = tuple(robot(*where, number=n) for n, where in enumerate(scene["others"], 2))
    assume(not any(is_on(wall, place(config, own)) for wall in walls))
    lidar = Lidar(config)
    lidar.reset(setup(world, heights=(2.0, 2.0, 2.0)))
    scan, agents = lidar.step(own, crowd, others)

    expected = brute_force(config, world, own, crowd, others)
    clear = np.ones(config.beams, bool)
    # Where a hair's breadth decides who is hit, rounding decides; all other beams must agree.
    for grow, shift in itertools.product((-1e-7, 1e-7), repeat=2):
        shaken = brute_force(config, world, own, crowd, others, grow, np.array([shift, 0.7 * shift]))
        clear &= (shaken.kind == expected.kind) & (shaken.agent == expected.agent)
        clear &= shaken.body_part == expected.body_part
        with np.errstate(invalid="ignore"):  # inf - inf
            clear &= ~(np.abs(shaken.distance - expected.distance) > 1e-6 + 1e-6 * expected.distance)
    np.testing.assert_array_equal(agents.kind[clear], expected.kind[clear])
    np.testing.assert_array_equal(agents.agent[clear], expected.agent[clear])
    np.testing.assert_array_equal(agents.body_part[clear], expected.body_part[clear])
    # float32 holds 7 digits.
    np.testing.assert_allclose(scan.ranges[clear], expected.distance[clear], rtol=1e-5, atol=1e-6)


def test_a_dense_corridor_equals_brute_force(setup, robot):
    """The paper's densest scenario, seen from near its seam, at three heights."""
    corners = [(0.0, 0.0), (50.0, 0.0), (50.0, 10.0), (0.0, 10.0)]
    walls = tuple(Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    rng = np.random.default_rng(3)
    for periodic, height in (((True, True), 0.3), ((False, False), 0.06), ((True, False), 1.1)):
        world = World(size=(50.0, 10.0), periodic=periodic, walls=walls[1::2] if periodic[0] else walls)
        config = Config(range_min=0.0, mount=Mount(position=(0.0, 0.0, height)))
        lidar = Lidar(config)
        lidar.reset(setup(world))
        crowd = walkers(rng.uniform((0, 0, -1.3, -0.3, 0, 0, 0), (50, 10, 1.3, 0.3, 1, 1, 1), (350, 7)))
        own, others = robot(49.0, 5.0, rng.uniform(-4, 4)), (robot(1.0, 6.0, number=2),)
        scan, agents = lidar.step(own, crowd, others)
        expected = brute_force(config, world, own, crowd, others)
        assert np.count_nonzero(agents.kind == BeamAgents.PERSON) > 300
        np.testing.assert_array_equal(agents.kind, expected.kind)
        np.testing.assert_array_equal(agents.agent, expected.agent)
        np.testing.assert_array_equal(agents.body_part, expected.body_part)
        np.testing.assert_allclose(scan.ranges, expected.distance, rtol=1e-5)
