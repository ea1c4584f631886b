"""Scenes for the tests of policies."""

import numpy as np

from components.crowd.motion import move
from components.crowd.scene import Scene
from components.crowd.walls import Walls


def scene(
    position,
    velocity=None,
    preferred=None,
    *,
    robots=(),
    walls=(),
    period=(0.0, 0.0),
    max_speed=1.8,
    max_acceleration=5.0,
    **options,
):
    """A scene of people of radius 0.3 m; arrays default to zeros."""
    position = np.array(position, np.float64).reshape(-1, 2)
    n = len(position)
    fields = {
        "position": position,
        "velocity": np.zeros((n, 2)) if velocity is None else np.array(velocity, np.float64),
        "preferred": np.zeros((n, 2)) if preferred is None else np.array(preferred, np.float64),
        "radius": np.full(n, 0.3),
        "robots": np.array(robots, np.float64).reshape(-1, 5),
        "walls": walls if isinstance(walls, Walls) else Walls(np.array(walls, np.float64), np.array(period)),
        "period": np.array(period, np.float64),
        "pushed_by_robots": np.ones(n, np.bool_),
        "stream": np.arange(n, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15),
        "max_speed": np.full(n, max_speed),
        "max_acceleration": np.full(n, max_acceleration),
        "dt": 0.1,
    }
    return Scene(**(fields | options))


def random_scene(seed, count=40, size=(12.0, 10.0), *, periodic=True, walls=()):
    """People at random places with random velocities; some overlap."""
    rng = np.random.default_rng(seed)
    return scene(
        rng.random((count, 2)) * size,
        rng.normal(0, 0.8, (count, 2)),
        rng.normal(0, 1, (count, 2)),
        period=size if periodic else (0.0, 0.0),
        walls=walls,
        robots=[(3.0, 3.0, 0.5, 0.2, 0.25)],
        stream=rng.integers(0, 2**64, count, np.uint64),
    )


def walk_to(policy, goal, position, *, steps, speed=1.3, **options):
    """(steps + 1, N, 2) positions of people who walk to their goals and start at rest."""
    position, goal = np.array(position, np.float64), np.array(goal, np.float64)
    velocity, track = np.zeros_like(position), [position]
    for _ in range(steps):
        way = goal - position
        distance = np.hypot(way[:, 0], way[:, 1])[:, None]
        preferred = np.where(distance > 0.3, way / np.maximum(distance, 1e-12) * speed, 0.0)
        now = scene(position, velocity, preferred, **options)
        position, velocity = move(now, policy.accelerate(now))
        track.append(position)
    return np.array(track)
