"""Depths and labels of a camera equal those of an oracle that casts rays at fine triangles."""

from __future__ import annotations

import numpy as np
import pytest

from components.sensors.camera import Config, LabelledCamera
from components.sensors.rendering.picture import ROBOT_NUMBERS
from crowdcosim.messages import Crowd
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World
from tests.components.sensors.oracle_scene import OracleScene

SIZE = (14.0, 8.0)
NEAR = 7.0
CORNERS = [(0.0, 0.0), (14.0, 0.0), (14.0, 8.0), (0.0, 8.0)]


def walkers(count, seed):
    rng = np.random.default_rng(seed)
    table = rng.uniform((0, 0, -1.3, -1.3, -3, 0, 0), (*SIZE, 1.3, 1.3, 3, 1, 1), (count, 7))
    return Crowd(
        id=np.arange(101, 101 + count),
        group=np.zeros(count, np.uint32),
        position=table[:, 0:2],
        velocity=table[:, 2:4],
        heading=table[:, 4],
        radius=np.full(count, 0.3),
        stature=1.4 + 0.6 * table[:, 5],
        mass=np.full(count, 70.0),
        gait_phase=table[:, 6],
        gait_speed=np.hypot(*table[:, 2:4].T),
    )


def rays(config, mount, heading):
    """(H W, 3) in the map, one unit ahead; from the intrinsics alone."""
    u, v = np.meshgrid(np.arange(config.width), np.arange(config.height))
    focal = 0.5 * config.width / np.tan(0.5 * config.field_of_view)
    x, y = (u - 0.5 * (config.width - 1)) / focal, (v - 0.5 * (config.height - 1)) / focal
    level = np.stack([np.ones_like(x), -x, -y], axis=-1).reshape(-1, 3)
    turn, nod = heading + mount.yaw, mount.pitch
    pitched = level @ np.array([(np.cos(nod), 0, np.sin(nod)), (0, 1, 0), (-np.sin(nod), 0, np.cos(nod))]).T
    return pitched @ np.array([(np.cos(turn), -np.sin(turn), 0), (np.sin(turn), np.cos(turn), 0), (0, 0, 1)]).T


def inside_edges(distance, agents):
    """(H, W) True where neither agent nor depth jumps among the eight neighbours."""
    clear = np.ones(agents.shape, bool)
    clear[[0, -1]] = clear[:, [0, -1]] = False
    for dv, du in ((0, 1), (1, 0), (1, 1), (1, -1)):
        for sign in (1, -1):
            moved = np.roll(distance, (sign * dv, sign * du), (0, 1))
            with np.errstate(invalid="ignore"):
                clear &= np.roll(agents, (sign * dv, sign * du), (0, 1)) == agents
                clear &= ~(np.abs(moved - distance) > 0.03)
    return clear


@pytest.mark.parametrize(
    ("periodic", "pose", "mount"),
    [
        ((False, False), (1.0, 4.0, 0.2), Mount(position=(0.0, 0.0, 1.2))),
        ((True, True), (13.0, 7.0, 0.6), Mount(position=(0.1, -0.1, 0.4), yaw=-0.3, pitch=-0.15)),
        ((True, False), (7.0, 4.0, -2.5), Mount(position=(0.0, 0.0, 2.2), pitch=0.5)),
    ],
)
def test_depths_and_labels_equal_those_of_embree(setup, robot, periodic, pose, mount):
    walls = tuple(Wall(start=a, end=b, height=2.4) for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True))
    if any(periodic):
        walls = walls[:1]  # else nobody is seen across a seam
    world = World(size=SIZE, periodic=periodic, walls=walls)
    config = Config(width=240, height=180, field_of_view=1.3, range_min=0.0, range_max=60.0, mount=mount)
    camera = LabelledCamera(config)
    camera.reset(setup(world))
    crowd, own, other = walkers(16, 7), robot(*pose), robot(*(pose[0] % 9 + 2.5, 4.5), 0.3, number=2, radius=0.25)
    images = camera.step(own, crowd, (other,))
    shape = (config.height, config.width)
    depth = np.frombuffer(images.depth.data, np.float32).reshape(shape)
    agents = np.frombuffer(images.agents.data, np.uint16).reshape(shape)
    parts = images.body_parts.data.reshape(shape)

    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    ahead, left, up = mount.position
    eye = np.array([pose[0] + cos * ahead - sin * left, pose[1] + sin * ahead + cos * left, up])
    oracle = OracleScene(eye)
    shifts = [[-size, 0.0, size] if wraps else [0.0] for size, wraps in zip(SIZE, periodic, strict=True)]
    oracle.add_people(crowd, [(i, j) for i in shifts[0] for j in shifts[1]], within=NEAR + 2.0)
    for wall in walls:
        (ax, ay), (bx, by) = wall.start, wall.end
        oracle.add_rectangle((ax, ay, 0), (bx, by, 0), (bx, by, 2.4), (ax, ay, 2.4))
    oracle.add_cylinder(other.position, 0.25, 1.2, ROBOT_NUMBERS - 2)
    oracle.add_rectangle((-99, -99, 0), (99, -99, 0), (99, 99, 0), (-99, 99, 0))
    distance, who, part = (array.reshape(shape) for array in oracle.see(rays(config, mount, pose[2])))
    near = np.minimum(distance, depth) < NEAR  # farther away the oracle has nobody

    assert len(np.unique(agents[near])) >= 5
    assert np.mean((agents == who)[near]) >= 0.999
    assert np.mean((parts == part)[near]) >= 0.998  # limbs' joints, too, are edges
    clear = inside_edges(distance, who) & near & (agents == who)
    error = np.abs(depth[clear] - distance[clear])
    assert clear.sum() > 4000
    assert np.quantile(error, 0.99) < 1e-3
