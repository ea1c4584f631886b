"""What is drawn is distributed as asked."""

import numpy as np
import pytest

from components.crowd.distributions import Bell, Normal, Uniform, bounds, draw

ALL = np.arange(20_000)


def drawn(distribution, who=ALL):
    return draw(distribution, np.random.default_rng(0), len(ALL), who)


def test_normal_draws_are_clipped():
    distribution = Normal(normal=Bell(mean=1.3, deviation=0.2, limits=(0.8, 1.8)))
    value = drawn(distribution)
    assert (value.min(), value.max()) == bounds(distribution) == (0.8, 1.8)
    # Standard errors: 1.4 mm/s and 1 mm/s; clipping at 2.5 standard deviations takes 1% of the deviation away.
    assert value.mean() == pytest.approx(1.3, abs=6e-3)
    assert value.std() == pytest.approx(0.2, abs=6e-3)


def test_uniform_draws_fill_their_range_evenly():
    value = drawn(Uniform(uniform=(0.5, 2.5)))
    assert bounds(Uniform(uniform=(0.5, 2.5))) == (0.5, 2.5)
    # 5,000 in each quarter, with a standard deviation of 61.
    assert np.histogram(value, 4, (0.5, 2.5))[0] == pytest.approx([5000] * 4, abs=250)


def test_a_number_is_for_all_and_a_list_has_one_for_each():
    who = np.array([3, 1, 4])
    assert drawn(0.3, who).tolist() == [0.3, 0.3, 0.3]
    assert drawn((1.0, 2.0, 3.0), who).tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(ValueError, match="a list of 2 values, expected one for each of 3 people"):
        drawn((1.0, 2.0), who)


@pytest.mark.parametrize(
    "distribution", [Uniform(uniform=(0.5, 2.5)), Normal(normal=Bell(mean=1, deviation=1, limits=(0, 2)))]
)
def test_what_somebody_draws_does_not_depend_on_who_else_is_asked(distribution):
    assert np.array_equal(drawn(distribution, np.array([7, 12])), drawn(distribution)[[7, 12]])
