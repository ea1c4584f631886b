"""Policies of one's own: recipes, cost functions in a file, and what their sum is."""

import dataclasses
import textwrap

import numpy as np
import pytest
from pydantic import ValidationError

from components.crowd.crowd import CrowdModel
from components.crowd.orca import Orca
from components.crowd.policies import RECIPES, recipe
from components.crowd.sampling import GLOBAL
from components.crowd.social_force import SocialForce
from components.crowd.steering import Recipe, Steering
from crowdcosim.component import make
from crowdcosim.message import check_finite
from crowdcosim.setup import Setup
from crowdcosim.world import World
from tests.components.crowd.crowds import random_scene, scene

SETUP = Setup(component="crowd", period=100_000_000, seed=1, world=World(size=(20.0, 10.0)))

MINE = '''
"""People who like to walk in one direction."""

from dataclasses import dataclass

from components.crowd.costs.cost import Cost


@dataclass(frozen=True, kw_only=True)
class East(Cost):
    speed: float = 1.0

    def add(self, around, candidates, coefficient, total):
        total += coefficient * ((candidates[0] - self.speed) ** 2 + candidates[1] ** 2)
'''


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "my_cost.py"
    path.write_text(textwrap.dedent(MINE))
    return f"{path}:East"


def test_a_cost_of_ones_own_is_one_file(mine):
    policy = Steering(Recipe(optimiser="global", costs=({"name": mine, "speed": 0.9},)))
    a = policy.accelerate(scene([(0, 0)], [(0.2, 0.0)]))
    assert a == pytest.approx(np.array([(7.0, 0.0)]))


def test_a_cost_without_a_slope_can_be_gone_down(mine):
    policy = Steering(Recipe(optimiser="gradient", costs=({"name": mine},)))
    # -grad of (vx - 1)^2 + vy^2; central differences are exact for squares.
    a = policy.accelerate(scene([(0, 0)], [(0.2, 0.3)]))
    assert a == pytest.approx(np.array([(1.6, -0.6)]))


def test_a_policy_is_written_in_a_scenario(mine):
    model = make(
        CrowdModel,
        {
            "count": 3,
            "policy": {
                "optimiser": {"sampling": "random", "samples": 50, "radius": "max_speed"},
                "relaxation_time": 0.5,
                "range": 3,
                "costs": [{"name": "rvo", "w": 2}, {"name": mine, "coefficient": 0.5}],
            },
        },
    )
    check_finite(model.reset(SETUP))
    check_finite(model.step(()))


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        ({"optimiser": "gradient", "costs": []}, "costs is empty"),
        ({"optimiser": "gradient", "costs": [{"name": "rov"}]}, "did you mean 'rvo'"),
        ({"optimiser": "gradient", "costs": [{"name": "rvo"}, {"name": "rvo", "v": 1}]}, r"costs\[1\]: rvo: v"),
        ({"optimiser": "newton", "costs": [{"name": "rvo"}]}, "gradient"),
        ({"optimiser": {"sampling": "regular", "speed": 3}, "costs": [{"name": "rvo"}]}, "speed"),
        ({"optimiser": "global", "range": 0, "costs": [{"name": "rvo"}]}, "range is 0.0, expected a positive number"),
        ({"optimiser": "global", "relaxation_time": -1, "costs": [{"name": "rvo"}]}, "relaxation_time is -1.0"),
    ],
)
def test_policies_that_make_no_sense_are_refused(policy, message):
    with pytest.raises(ValidationError, match=message):
        make(CrowdModel, {"count": 3, "policy": policy})


def test_forces_add_up():
    now = random_scene(1)
    both = Steering(recipe("power_law")).accelerate(now)
    one = Steering(dataclasses.replace(recipe("power_law"), costs=({"name": "power_law"},))).accelerate(now)
    other = Steering(dataclasses.replace(recipe("power_law"), costs=({"name": "goal_reaching"},))).accelerate(now)
    assert both == pytest.approx(one + other, abs=1e-12)


def test_social_forces_as_costs_are_the_policy_of_that_name():
    now = random_scene(2, walls=[[(0, 5), (4, 6)]])
    costs = Recipe(
        optimiser="gradient", relaxation_time=0.5, costs=({"name": "social_force"}, {"name": "goal_reaching"})
    )
    assert Steering(costs).accelerate(now) == pytest.approx(SocialForce().accelerate(now), abs=1e-9)


def test_the_best_of_many_orca_costs_is_near_the_one_of_the_linear_programs():
    now = random_scene(6, 15)
    tried = dataclasses.replace(GLOBAL, speeds=61, angles=180)
    sampled = Steering(Recipe(optimiser=tried, costs=({"name": "orca", "time_horizon": 1.5},))).accelerate(now)
    exact = Orca(time_horizon=1.5).accelerate(now)
    free = (np.hypot(*(now.velocity + 0.1 * exact).T) < 1.79) & (np.abs(exact) < 1e6).all(axis=1)
    near = np.hypot(*(0.1 * (sampled - exact))[free].T)
    # Candidates are at most 0.05 m/s apart; where nothing is permitted, the cost is flatter than that.
    assert np.median(near) < 0.06


@pytest.mark.parametrize("name", RECIPES)
def test_blocks_of_any_size_give_the_same_bits(name, monkeypatch):
    now = random_scene(7, 30, walls=[[(0, 5), (4, 6)]])
    whole = Steering(recipe(name)).accelerate(now)
    monkeypatch.setattr("components.crowd.steering.GRADIENT_BLOCK", 7)
    monkeypatch.setattr("components.crowd.steering.CANDIDATES_BLOCK", 1000)
    assert np.array_equal(Steering(recipe(name)).accelerate(now), whole)


def test_more_neighbours_than_ever_before_are_all_met():
    crowd = random_scene(8, 400, size=(6.0, 6.0))
    policy = Steering(recipe("power_law"))
    policy.accelerate(random_scene(0, 5))
    grown = policy.accelerate(crowd)
    assert np.array_equal(grown, policy.accelerate(crowd))
