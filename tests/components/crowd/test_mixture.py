"""Several policies in one crowd: everybody follows their own, and sees the robots in their own way."""

import numpy as np
import pytest

from components.crowd.mixture import Mixture, mix
from components.crowd.orca import Orca
from components.crowd.policies import RECIPES, make_policy, recipe
from components.crowd.reactions import HIDDEN, MOVING, STILL
from components.crowd.scene import Scene
from components.crowd.social_force import SocialForce
from components.crowd.steering import Steering
from tests.components.crowd.crowds import random_scene, scene


def test_everybody_follows_their_own_policy():
    now = random_scene(9, 50)
    which = np.random.default_rng(0).integers(0, 3, 50)
    parts = [SocialForce(), Steering(recipe("rvo")), Orca(time_horizon=1.5)]
    mixed = Mixture(parts, which).accelerate(now, np.full(50, MOVING, np.int8))
    for p, policy in enumerate(parts):
        assert np.array_equal(mixed[which == p], policy.accelerate(now)[which == p])


@pytest.mark.parametrize("name", ["orca", "social_force", *RECIPES])
def test_everybody_sees_the_robots_in_their_own_way(name):
    now = random_scene(3, 30)
    policy = make_policy(name, time_horizon=1.5)
    sight = np.random.default_rng(1).permutation(np.repeat(np.array([MOVING, STILL, HIDDEN], np.int8), 10))
    mixed = Mixture([policy], np.zeros(30, np.int64)).accelerate(now, sight)
    resting = now.robots.copy()
    resting[:, 2:4] = 0
    for view, robots in ((MOVING, now.robots), (STILL, resting), (HIDDEN, np.empty((0, 5)))):
        fields = {field: getattr(now, field) for field in Scene.__dataclass_fields__}
        expected = policy.accelerate(Scene(**fields | {"robots": robots}))
        assert np.array_equal(mixed[sight == view], expected[sight == view])


def test_populations_of_one_policy_are_computed_at_once_each_with_a_horizon_of_its_own():
    now = scene([(0, 0), (4, 0.1), (0, 9), (4, 9.1)], [(1, 0), (-1, 0)] * 2, [(1, 0), (-1, 0)] * 2)
    horizon = np.array([1.0, 1.0, 5.0, 5.0])
    mixture = mix(["orca", "orca"], np.array([0, 0, 1, 1]), np.array([0, 3, 1, 7]), horizon)
    assert len(mixture._parts) == 1
    acceleration = mixture.accelerate(now, np.full(4, MOVING, np.int8))
    # They would touch after 1.7 s.
    assert np.abs(acceleration[:2]).max() == 0
    assert np.abs(acceleration[2:]).max() > 0.1
