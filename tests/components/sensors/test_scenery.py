"""Walls with doors are covered from end to end and from floor to top, once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.sensors.rendering.scenery import DOOR, WALL, world_scenery
from crowdcosim.world import Door, Wall, World


def areas(world: World) -> dict[int, float]:
    """Area of what is painted alike [m2]."""
    scenery = world_scenery(world)
    u, v = scenery.corner[:, 1] - scenery.corner[:, 0], scenery.corner[:, 2] - scenery.corner[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(u, v), axis=1)
    return {paint: float(area[scenery.paint == paint].sum()) for paint in (WALL, DOOR)}


@given(st.lists(st.floats(0.2, 1.5), max_size=4), st.floats(0.0, 6.3))
def test_doors_take_the_place_of_the_wall(gaps: list[float], yaw: float) -> None:
    doors, free = [], 0.0
    for gap in gaps:
        doors.append(Door(at=free + gap + 0.45))
        free += gap + 0.9
    end = (3.0 + 12.0 * np.cos(yaw), 4.0 + 12.0 * np.sin(yaw))
    wall = Wall(start=(3.0, 4.0), end=end, doors=tuple(doors), height=2.5)
    found = areas(World(size=(20, 20), walls=(wall,)))
    assert found[DOOR] == pytest.approx(len(doors) * 0.9 * 2.1)
    assert found[WALL] + found[DOOR] == pytest.approx(12.0 * 2.5)


def test_a_door_may_fill_its_wall() -> None:
    wall = Wall(start=(0, 0), end=(1, 0), doors=(Door(at=0.5, width=1.0, height=2.5),))
    assert areas(World(size=(2, 2), walls=(wall,))) == {WALL: 0.0, DOOR: 2.5}


@pytest.mark.parametrize(
    ("doors", "words"),
    [
        ((Door(at=0.3),), r"doors\[0\] takes up -0.15 m to 0.75 m"),
        ((Door(at=4.8),), "the wall's length of 5 m"),
        ((Door(at=1.0), Door(at=1.5)), r"doors\[1\] takes up 1.05 m to 1.95 m .* between 1.45 m"),
        ((Door(at=2.0, height=3.0),), "at most its height of 2.5 m"),
    ],
)
def test_doors_that_do_not_fit_are_refused(doors: tuple[Door, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Wall(start=(0, 0), end=(5, 0), doors=doors)
