"""Obstacles are simple polygons that go round counter-clockwise."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crowdcosim.obstacles import Box, Disc, Polygon, inside

coordinate = st.floats(-10.0, 10.0)
L_SHAPE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))


def area(outline: np.ndarray) -> float:
    x, y = outline.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@given(coordinate, coordinate, st.floats(-7.0, 7.0))
def test_a_box_has_the_area_of_its_sides_whatever_its_yaw(x: float, y: float, yaw: float) -> None:
    outline = Box(shape="box", centre=(x, y), size=(2.0, 0.5), yaw=yaw).outline
    assert area(outline) == pytest.approx(1.0)
    np.testing.assert_allclose(outline.mean(axis=0), (x, y), atol=1e-12)
    np.testing.assert_allclose(outline[1] - outline[0], (2.0 * math.cos(yaw), 2.0 * math.sin(yaw)), atol=1e-12)


def test_the_polygon_of_a_disc_touches_it_from_outside() -> None:
    outline = Disc(shape="disc", centre=(1.0, 2.0), radius=0.5).outline
    middles = 0.5 * (outline + np.roll(outline, -1, axis=0))
    np.testing.assert_allclose(np.hypot(*(middles - (1.0, 2.0)).T), 0.5)
    assert area(outline) == pytest.approx(math.pi * 0.25, rel=0.005)


def test_corners_may_be_given_in_either_order_round() -> None:
    ccw = Polygon(shape="polygon", corners=L_SHAPE)
    assert area(ccw.outline) == area(Polygon(shape="polygon", corners=L_SHAPE[::-1]).outline) == 3.0


def test_the_notch_of_a_polygon_is_outside_of_it() -> None:
    outline = Polygon(shape="polygon", corners=L_SHAPE).outline
    points = np.array([(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5), (-0.5, 0.5)])
    assert inside(outline, points).tolist() == [True, True, True, False, False]


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        (((0, 0), (1, 0)), "corners are 2, expected at least 3"),
        (((0, 0), (1, 0), (2, 0)), "corners enclose no area"),
        (((0, 0), (2, 2), (2, 0), (0, 1)), r"edges after corners\[0\] and corners\[2\] meet"),
        (((0, 0), (2, 0), (1, 0), (1, 1)), r"edges after corners\[0\] and corners\[1\] meet"),
        (((0, 0), (1, 0), (1, 1), (0, 0)), "meet"),
    ],
)
def test_polygons_that_are_none_are_refused(corners: tuple[tuple[float, float], ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Polygon(shape="polygon", corners=corners)
