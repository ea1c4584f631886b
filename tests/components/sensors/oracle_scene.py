"""The world of a camera as fine triangles in embree, an independent ray caster."""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from components.sensors.rendering.people import TAPER
from crowdcosim.avatar import pose
from crowdcosim.body import BODY_PART

SEGMENTS, RINGS = 40, 8


class OracleScene:
    """People, robots and rectangles, each with a label per triangle."""

    def __init__(self, origin):
        self._origin = np.asarray(origin, np.float64)
        self._corners, self._agents, self._parts = [], [], []

    def add(self, corners, agent, part):
        """Triangles (T, 3, 3) in the map [m]."""
        self._corners.append(corners - self._origin)
        self._agents.append(np.full(len(corners), agent))
        self._parts.append(np.full(len(corners), part))

    def add_people(self, crowd, shifts=((0.0, 0.0),), within=np.inf):
        """Everybody, and their images displaced by `shifts` [m], who are `within` a distance [m]."""
        bodies = pose(crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)
        for number, body, position in zip(crowd.id.tolist(), bodies, crowd.position, strict=True):
            near = [s for s in shifts if np.hypot(*(position + s - self._origin[:2])) < within]
            for c, capsule in enumerate(body if near else ()):
                limb = hull_of_balls(capsule[0:3], capsule[6] * TAPER[c, 0], capsule[3:6], capsule[6] * TAPER[c, 1])
                for shift in near:
                    self.add(limb + np.array([*shift, 0.0]), number, int(BODY_PART[c]))

    def add_rectangle(self, a, b, c, d, agent=0):
        self.add(np.array([(a, b, c), (a, c, d)], np.float64), agent, 0)

    def add_cylinder(self, centre, radius, height, agent):
        angle = np.linspace(0.0, 2.0 * np.pi, 721)
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius + centre
        low, high = np.column_stack([ring, 0.0 * angle]), np.column_stack([ring, 0.0 * angle + height])
        middle = np.tile((*centre, height), (720, 1))
        fans = [(low[:-1], low[1:], high[1:]), (low[:-1], high[1:], high[:-1]), (middle, high[:-1], high[1:])]
        self.add(np.concatenate([np.stack(fan, axis=1) for fan in fans]), agent, 0)

    def see(self, directions):
        """Distance in units of the directions (N, 3), infinite for nothing, agent and part of what is first met."""
        scene = rtcore_scene.EmbreeScene(robust=True)
        TriangleMesh(scene, np.concatenate(self._corners).astype(np.float32))
        rays = np.ascontiguousarray(directions, np.float32)
        hits = scene.run(np.zeros_like(rays), rays, output=1)
        primitive = hits["primID"]
        met = primitive >= 0
        distance = np.where(met, hits["tfar"].astype(np.float64), np.inf)
        agents, parts = np.concatenate(self._agents), np.concatenate(self._parts)
        return distance, np.where(met, agents[primitive], 0), np.where(met, parts[primitive], 0)


def hull_of_balls(a, p, b, q):
    """(T, 3, 3): a point per normal n: on whichever ball is farther out that way, and on both where they are equal."""
    axis = b - a
    length = np.linalg.norm(axis)
    axis = axis / length
    side = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.5 else (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    switch = np.arccos((p - q) / length)  # angle from the axis beyond which a's ball is farther out
    angle = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    around = np.outer(np.cos(angle), side) + np.outer(np.sin(angle), up)
    rings = []
    for centre, radius, low, high in ((b, q, 0.0, switch), (a, p, switch, np.pi)):
        for away in np.linspace(low, high, RINGS + 1):
            rings.append(centre + radius * (np.cos(away) * axis + np.sin(away) * around))
    grid = np.array(rings)
    first = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:]], axis=2)
    second = np.stack([grid[:-1, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
    return np.concatenate([first.reshape(-1, 3, 3), second.reshape(-1, 3, 3)])
