"""The people drawn are adults."""

import numpy as np
import pytest

from components.crowd.people import draw_bodies, draw_speeds


def test_statures_have_the_published_medians():
    bodies = draw_bodies(np.random.default_rng(0), 20_000)
    # A mixture of men (1.759 m) and women (1.618 m), half of each; the median's standard error is 0.7 mm.
    assert np.median(bodies.stature) == pytest.approx((1.759 + 1.618) / 2, abs=3e-3)
    assert bodies.stature.min() > 1.2
    assert bodies.stature.max() < 2.2


def test_masses_go_with_statures():
    bodies = draw_bodies(np.random.default_rng(0), 20_000)
    index = bodies.mass / bodies.stature**2
    assert np.median(index) == pytest.approx(25.0, abs=0.2)
    assert index.min() > 12
    assert np.corrcoef(bodies.mass, bodies.stature)[0, 1] > 0.3


def test_speeds_are_normal_and_clipped():
    speed = draw_speeds(np.random.default_rng(0), 20_000, 1.3, 0.2, 0.8, 1.8)
    assert speed.min() == 0.8
    assert speed.max() == 1.8
    # Standard errors: 1.4 mm/s and 1 mm/s; clipping at 2.5 standard deviations takes 1% of the deviation away.
    assert speed.mean() == pytest.approx(1.3, abs=6e-3)
    assert speed.std() == pytest.approx(0.2, abs=6e-3)
