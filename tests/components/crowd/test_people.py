"""The people drawn are adults, or what their population says, and some of them walk together."""

import numpy as np
import pytest

from components.crowd.distributions import Uniform
from components.crowd.people import Traits, draw_bodies, draw_people, draw_shares


def rng(stream):
    return np.random.default_rng([5, stream])


def people(count, *populations):
    return draw_people(rng, count, populations)


def test_statures_have_the_published_medians():
    stature, _ = draw_bodies(np.random.default_rng(0), 20_000)
    # A mixture of men (1.759 m) and women (1.618 m), half of each; the median's standard error is 0.7 mm.
    assert np.median(stature) == pytest.approx((1.759 + 1.618) / 2, abs=3e-3)
    assert stature.min() > 1.2
    assert stature.max() < 2.2


def test_masses_go_with_statures():
    stature, mass = draw_bodies(np.random.default_rng(0), 20_000)
    index = mass / stature**2
    assert np.median(index) == pytest.approx(25.0, abs=0.2)
    assert index.min() > 12
    assert np.corrcoef(mass, stature)[0, 1] > 0.3


def test_children_weigh_what_their_stature_and_the_body_mass_index_say():
    adults = people(500, ("", 1.0, Traits()))
    children = people(500, ("", 1.0, Traits(stature=Uniform(uniform=(1.0, 1.4)))))
    assert children.stature.min() >= 1.0
    assert children.stature.max() <= 1.4
    assert children.mass / children.stature**2 == pytest.approx(adults.mass / adults.stature**2)


def test_shares_are_as_near_as_whole_people_are():
    share = draw_shares(np.random.default_rng(0), 50, [3.0, 1.0, 1.0])
    assert np.bincount(share).tolist() == [30, 10, 10]
    assert not np.array_equal(share, np.sort(share))


def test_every_population_has_its_own_traits():
    elderly = Traits(preferred_speed=Uniform(uniform=(0.5, 0.9)), max_speed=1.2, radius=0.25, time_horizon=3.0)
    hurried = Traits(preferred_speed=1.7, max_acceleration=8.0)
    crowd = people(90, ("elderly", 1.0, elderly), ("hurried", 2.0, hurried))
    old = crowd.population == 0
    assert old.sum() == 30
    assert crowd.preferred_speed[old].max() <= 0.9
    assert len(set(crowd.preferred_speed[old])) == 30
    for values, a, b in (
        (crowd.max_speed, 1.2, 1.8),
        (crowd.radius, 0.25, 0.3),
        (crowd.time_horizon, 3.0, 1.5),
        (crowd.max_acceleration, 5.0, 8.0),
    ):
        assert set(values[old]) == {a}
        assert set(values[~old]) == {b}
    assert set(crowd.preferred_speed[~old]) == {1.7}


def test_people_keep_their_luck_when_others_change():
    before = people(60, ("a", 1.0, Traits()), ("b", 1.0, Traits()))
    after = people(60, ("a", 1.0, Traits()), ("b", 1.0, Traits(preferred_speed=1.0, radius=0.2)))
    same = before.population == 0
    assert np.array_equal(before.population, after.population)
    assert np.array_equal(before.preferred_speed[same], after.preferred_speed[same])
    assert np.array_equal(before.stature, after.stature)


def test_a_list_of_the_wrong_length_says_whose():
    with pytest.raises(ValueError, match="radius of elderly is a list of 2 values, expected one for each of 3 people"):
        people(6, ("elderly", 1.0, Traits(radius=(0.2, 0.3))), ("others", 1.0, Traits()))


def test_as_many_walk_together_as_asked():
    crowd = people(200, ("", 1.0, Traits(groups=(0.5, 0.3, 0.2))))
    _, sizes = np.unique(crowd.group[crowd.group > 0], return_counts=True)
    # 60 people in pairs; 40 in threes are 13 groups and one more alone.
    assert np.bincount(sizes).tolist() == [0, 0, 30, 13]
    assert set(crowd.group) == set(range(44))
    assert np.array_equal(np.unique(crowd.party, return_counts=True)[1][crowd.party] > 1, crowd.group > 0)


def test_groups_are_of_one_population_and_have_one_pace():
    friends = Traits(groups=(0.0, 1.0))
    crowd = people(100, ("a", 1.0, friends), ("b", 1.0, friends))
    for g in range(1, crowd.group.max() + 1):
        who = crowd.group == g
        assert len(set(crowd.population[who])) == 1
        assert np.ptp(crowd.preferred_speed[who]) < 1e-12
    alone = people(100, ("a", 1.0, Traits()), ("b", 1.0, Traits()))
    assert crowd.preferred_speed.mean() == pytest.approx(alone.preferred_speed.mean())


def test_without_groups_everybody_is_alone():
    crowd = people(20, ("", 1.0, Traits()))
    assert not crowd.group.any()
    assert crowd.party.tolist() == list(range(20))
