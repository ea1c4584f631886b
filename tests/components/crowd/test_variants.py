"""People differ in the options of their costs."""

import numpy as np
import pytest
from pydantic import ValidationError

from components.crowd.crowd import CrowdModel
from components.crowd.distributions import Bell, Normal, Uniform, draw, quantile
from components.crowd.mixture import mix
from components.crowd.reactions import MOVING
from components.crowd.steering import Recipe, Steering
from components.crowd.variants import VARIANTS, of_variant
from crowdcosim.component import make
from crowdcosim.message import check_finite
from crowdcosim.setup import Setup
from crowdcosim.world import World
from tests.components.crowd.crowds import random_scene

SETUP = Setup(component="crowd", period=100_000_000, seed=1, world=World(size=(20.0, 10.0)))
VARIED = Recipe(
    optimiser="gradient",
    relaxation_time=0.5,
    costs=(
        {"name": "power_law", "k": {"uniform": [1.0, 3.0]}},
        {"name": "goal_reaching", "coefficient": {"normal": {"mean": 1.0, "deviation": 0.2, "limits": [0.5, 1.5]}}},
    ),
)


@pytest.mark.parametrize(
    "distribution", [Uniform(uniform=(1.0, 3.0)), Normal(normal=Bell(mean=1.0, deviation=0.2, limits=(0.8, 1.5)))]
)
@pytest.mark.parametrize("share", [0.05, 0.3, 0.5, 0.9])
def test_a_quantile_is_greater_than_its_share_of_those_drawn(distribution, share):
    drawn = draw(distribution, np.random.default_rng(0), 100_000, np.arange(100_000))
    # Standard error of the share: at most 0.16%; below the limit of 0.8 nobody is drawn, and 16% are at it.
    below = np.mean(drawn < quantile(distribution, share))
    assert below == pytest.approx(share if quantile(distribution, share) > 0.8 else 0.0, abs=0.006)


def test_the_variants_are_quantiles_of_the_distribution():
    k = [of_variant(VARIED.costs[0], v, 0)["k"] for v in range(VARIANTS)]
    # One in each eighth of the range.
    assert sorted(((np.array(k) - 1.0) / 2.0 * VARIANTS).astype(int)) == list(range(VARIANTS))
    pairs = [(v.costs[0]["k"], v.costs[1]["coefficient"]) for v in map(VARIED.variant, range(VARIANTS))]
    assert abs(np.corrcoef(np.array(pairs).T)[0, 1]) < 0.6


def test_everybody_follows_their_own_variant():
    now = random_scene(3, 40)
    variant = np.random.default_rng(0).integers(0, VARIANTS, 40)
    mixed = mix([VARIED], np.zeros(40, np.int64), variant, np.ones(40)).accelerate(now, np.full(40, MOVING, np.int8))
    for v in range(VARIANTS):
        expected = Steering(VARIED.variant(v)).accelerate(now)
        assert np.array_equal(mixed[variant == v], expected[variant == v])


def test_distributed_options_are_written_in_a_scenario():
    policy = {"optimiser": "gradient", "relaxation_time": 0.5, "costs": [dict(cost) for cost in VARIED.costs]}
    model = make(CrowdModel, {"count": 30, "policy": policy})
    check_finite(model.reset(SETUP))
    check_finite(model.step(()))
    assert len(model._mixture._parts) == VARIANTS


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"uniform": [3.0, 1.0]}, r"costs\[0\]: w: uniform is \[3.0, 1.0\], expected two numbers in ascending order"),
        ({"uniform": [-1.0, 1.0]}, r"costs\[0\]: rvo: .*w is -0.875, expected zero or a positive number"),
        ({"uniform": 1.0}, r"costs\[0\]: w: .*expected \{uniform: \[LEAST, GREATEST\]\}"),
        ({"normal": {"mean": 1.0}}, r"costs\[0\]: w: .*expected \{uniform"),
    ],
)
def test_distributions_that_make_no_sense_are_refused(option, message):
    policy = {"optimiser": "global", "costs": [{"w": option, "name": "rvo"}]}
    with pytest.raises(ValidationError, match=message):
        make(CrowdModel, {"count": 3, "policy": policy})
