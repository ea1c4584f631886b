"""Scans equal those of embree, an independent ray caster, on fine triangles."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from components.sensors.lidar import Config, Lidar
from crowdcosim.avatar import pose
from crowdcosim.body import BODY_PART
from crowdcosim.messages import BeamAgents
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World

AROUND, ALONG = 128, 10  # corners of a capsule's circle, and of the arc over its two ends


def capsule_triangles(a, b, radius):
    """(T, 3, 3) triangles with corners on the capsule; along it at most radius (1 - cos(pi / 128)) deep, 0.04 mm."""
    axis = (b - a) / np.linalg.norm(b - a)
    side = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.5 else (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    angle = np.linspace(0.0, 2.0 * math.pi, AROUND + 1)
    ring = np.outer(np.cos(angle), side) + np.outer(np.sin(angle), np.cross(axis, side))
    latitude = np.linspace(-math.pi / 2, math.pi / 2, 2 * ALONG + 1)
    ends = [(a, latitude[: ALONG + 1]), (b, latitude[ALONG:])]
    grid = np.array([centre + radius * (math.cos(t) * ring + math.sin(t) * axis) for centre, arc in ends for t in arc])
    first = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:]], axis=2)
    second = np.stack([grid[:-1, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
    return np.concatenate([first.reshape(-1, 3, 3), second.reshape(-1, 3, 3)])


def cylinder_triangles(centre, radius, height):
    angle = np.linspace(0.0, 2.0 * math.pi, 721)
    low = np.column_stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle), 0.0 * angle])
    high = low + np.array((0.0, 0.0, height))
    return np.concatenate([np.stack([low[:-1], low[1:], high[1:]], 1), np.stack([low[:-1], high[1:], high[:-1]], 1)])


def wall_triangles(wall):
    a, b = (np.array([*end, 0.0]) for end in (wall.start, wall.end))
    up = np.array([0.0, 0.0, wall.height])
    return np.array([(a, b, b + up), (a, b + up, a + up)])


def embree_scan(things, origin, directions):
    """Distance to, and label of, what each ray meets first; `things` are (triangles, label)."""
    labels = np.concatenate([np.full(len(triangles), k) for k, (triangles, _) in enumerate(things)])
    triangles = np.concatenate([triangles for triangles, _ in things]) - origin
    scene = rtcore_scene.EmbreeScene(robust=True)
    TriangleMesh(scene, triangles.astype(np.float32))
    rays = np.ascontiguousarray(directions, np.float32)
    hits = scene.run(np.zeros_like(rays), rays, output=1)
    met = hits["primID"] >= 0
    distance = np.where(met, hits["tfar"].astype(np.float64), np.inf)
    nobody = (BeamAgents.NOTHING, 0, BeamAgents.NO_PART)
    return distance, [things[labels[p]][1] if p >= 0 else nobody for p in hits["primID"].tolist()]


def near_the_robot(x, y):
    """Within somebody a scan tells 0, embree the way out."""
    return abs(y - 4.0) < 0.8 and min(abs(x - 15.5), abs(x + 0.5)) < 0.8


@pytest.mark.parametrize("height", [0.1, 0.3, 1.3])
def test_a_crowd_that_walks_is_seen_as_embree_sees_it(setup, robot, people, height):
    """A corridor at the paper's density of 0.7 /m2, across its seam; ids of 99.9% of the beams, ranges to 1 mm."""
    rng = np.random.default_rng(7)
    size, count, limit = (16.0, 8.0), 90, 4.0
    walls = tuple(Wall(start=(-99.0, y), end=(99.0, y)) for y in (0.0, 8.0))
    world = World(size=size, periodic=(True, False), walls=walls)
    places = [place for place in rng.uniform((0, 0), size, (count + 20, 2)) if not near_the_robot(*place)][:count]
    crowd = dataclasses.replace(
        people(*places),
        velocity=rng.uniform((-1.5, -0.5), (1.5, 0.5), (count, 2)),
        heading=rng.uniform(0.0, 2 * math.pi, count),
        stature=rng.uniform(1.5, 1.9, count),
        gait_phase=rng.random(count),
    )
    lidar = Lidar(Config(beams=2160, range_min=0.0, range_max=limit, mount=Mount(position=(0.0, 0.0, height))))
    lidar.reset(setup(world, heights=(2.0, 1.0, 1.0)))
    bodies = pose(crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)
    x, heading = 15.5, 0.3
    own, other = robot(x, 4.0, heading), robot(math.fmod(x + 1.5, 16.0), 3.0, number=2)
    things = [(wall_triangles(wall), (BeamAgents.WALL, k, 0)) for k, wall in enumerate(walls, 1)]
    for shift in (-16.0, 0.0, 16.0):
        centre = other.position + np.array((shift, 0.0))
        things.append((cylinder_triangles(centre, other.radius, 1.0), (BeamAgents.ROBOT, 2, 0)))
        along = np.array((shift, 0.0, 0.0))
        for n, c in itertools.product(range(count), range(bodies.shape[1])):
            a, b, radius = bodies[n, c, :3] + along, bodies[n, c, 3:6] + along, bodies[n, c, 6]
            tall = min(a[2], b[2]) - radius <= height <= max(a[2], b[2]) + radius
            if tall and math.hypot(a[0] - x, a[1] - 4.0) < limit + 0.5:
                label = (BeamAgents.PERSON, int(crowd.id[n]), int(BODY_PART[c]))
                things.append((capsule_triangles(a, b, radius), label))
    scan, agents = lidar.step(own, crowd, (other,))
    angles = heading + scan.angle_min + 2 * math.pi / 2160 * np.arange(2160)
    directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(2160)])
    distance, labels = embree_scan(things, (x, 4.0, height), directions)
    within = distance <= limit - 0.01
    ours = list(zip(agents.kind.tolist(), agents.agent.tolist(), agents.body_part.tolist(), strict=True))
    same = np.array([mine == theirs for mine, theirs in zip(ours, labels, strict=True)]) & within
    agree, beams = np.count_nonzero(same), np.count_nonzero(within)
    errors = np.abs(scan.ranges[same] - distance[same])
    assert beams > 700
    assert agree >= 0.999 * beams
    assert np.quantile(errors, 0.99) < 1e-3
    assert errors.max() < 5e-3  # a ray that grazes a facet is longer by up to sqrt(2 radius * 0.04 mm)
