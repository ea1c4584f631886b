"""Journeys: people come, stop, wait, go on, arrive and leave; nobody is lost."""

import re
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from components.crowd.crowd import CrowdModel
from components.crowd.journeys import Journey
from crowdcosim.component import make
from crowdcosim.message import check_finite
from crowdcosim.messages import RobotState
from crowdcosim.obstacles import Disc
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World

EDGES = (
    Wall(start=(0.0, 0.0), end=(20.0, 0.0)),
    Wall(start=(20.0, 0.0), end=(20.0, 10.0)),
    Wall(start=(20.0, 10.0), end=(0.0, 10.0)),
    Wall(start=(0.0, 10.0), end=(0.0, 0.0)),
)
HALL = World(size=(20.0, 10.0), walls=EDGES, obstacles=(Disc(shape="disc", centre=(10.0, 5.0), radius=1.0),))
AREAS = {
    "west": {"x": [0, 3], "y": [2, 8]},
    "east": {"x": [18, 20], "y": [3, 7]},
    "kiosk": {"x": [12, 15], "y": [7, 10]},
}


def setup(world=HALL, **options):
    return Setup(**({"component": "crowd", "period": 100_000_000, "seed": 1, "world": world} | options))


def crowd(*journeys, areas=AREAS, **options):
    return make(CrowdModel, {"areas": areas, "journeys": list(journeys), **options})


def run(model, steps, *, at=None, robots=()):
    """All states from t = 0 on."""
    return [model.reset(at or setup()), *(model.step(robots) for _ in range(steps))]


def gaps(state):
    """Least distance between two bodies' edges [m]."""
    d = np.hypot(*(state.position[:, None] - state.position[None]).transpose(2, 0, 1))
    d -= state.radius[:, None] + state.radius
    np.fill_diagonal(d, np.inf)
    return d


@pytest.mark.parametrize("policy", ["orca", "social_force", "power_law"])
def test_people_walk_round_the_obstacle_to_their_goal_and_leave(policy):
    states = run(crowd({"start": "west", "goal": "east", "count": 12}, policy=policy), 300)
    assert [len(s.id) for s in states[:60]] == [12] * 60
    assert len(states[-1].id) == 0
    for state in states:
        check_finite(state)
        assert not HALL.obstructed(state.position).any()
        # Whoever is in the goal's area is gone.
        assert not ((state.position >= (18, 3)) & (state.position <= (20, 7))).all(axis=1).any()
    last = {i: p for s in states for i, p in zip(s.id.tolist(), s.position.tolist(), strict=True)}
    assert all(x > 17.5 and 2.7 < y < 7.3 for x, y in last.values())


def test_whoever_comes_is_there_has_left_or_waits_outside():
    model = crowd({"start": "west", "goal": "east", "rate": 1.5}, {"start": "east", "goal": "west", "rate": 0.5})
    states = run(model, 600)
    seen = set()
    for before, after in pairwise(states):
        new = after.id[~np.isin(after.id, before.id)]
        # Numbers are in the order in which people come, and never used again.
        assert new.tolist() == list(range(len(seen) + 1, len(seen) + 1 + len(new)))
        seen |= set(new.tolist())
        assert (np.diff(after.id.astype(np.int64)) > 0).all()
    assert model._sources.outside == [0, 0]
    # 120 expected, with the standard deviation of a Poisson process.
    assert len(seen) == pytest.approx(120, abs=4 * np.sqrt(120))
    assert 10 < len(states[-1].id) < 60


def test_regular_arrivals_and_rates_that_change_come_as_scheduled():
    journey = {"start": "west", "goal": "east", "arrivals": "regular", "rate": [[2, 1.0], [5, 0.0], [10, 2.0]]}
    states = run(crowd(journey), 150)
    come = [int(max(s.id, default=0)) for s in states]
    # 1 /s from 2 s to 5 s, nobody until 10 s, then 2 /s; the sum of steps of 0.1 s is good to a step.
    expected = [min(max(t - 2, 0), 3) + max(t - 10, 0) * 2 for t in np.arange(151) * 0.1]
    assert np.abs(np.array(come) - np.floor(np.array(expected) + 1e-9)).max() <= 1
    assert come[-1] == 13


def test_nobody_appears_on_anybody_and_those_without_room_wait_outside():
    # Two square metres for six people a second: they come as fast as the others walk away.
    areas = AREAS | {"door": {"x": [0.3, 1.7], "y": [4, 5.4]}}
    model = crowd({"start": "door", "goal": "east", "rate": 6, "arrivals": "regular"}, areas=areas)
    robot = RobotState(name="robot", position=np.array([1.0, 4.7]), velocity=np.zeros(2), radius=0.2)
    states = run(model, 200, robots=(robot,))
    for before, after in pairwise(states):
        new = ~np.isin(after.id, before.id)
        if new.any():
            assert gaps(after)[new].min() >= -1e-12
            assert np.hypot(*(after.position[new] - robot.position).T).min() >= 0.5
    entered = int(states[-1].id.max())
    assert entered + model._sources.outside[0] == 120
    assert model._sources.outside[0] > 10
    assert entered > 60


def test_people_wait_at_a_stop_and_go_on():
    stop = {"area": "kiosk", "wait": {"uniform": [6.0, 8.0]}}
    states = run(crowd({"start": "west", "via": [stop], "goal": "east", "count": 5}), 500)
    assert len(states[-1].id) == 0
    for i in range(1, 6):
        track = np.array([s.position[s.id == i][0] for s in states if (s.id == i).any()])
        inside = ((track >= (12, 7)) & (track <= (15, 10))).all(axis=1)
        first = inside.argmax()
        assert inside.any()
        # They stand at a place of their own within the area, and take a second or two to leave it.
        still = np.hypot(*(np.diff(track[first : first + 70], axis=0) / 0.1).T)
        assert np.median(still[30:55]) < 0.1
        assert 6.0 <= inside.sum() * 0.1 < 12.0


def test_whoever_is_to_stay_stays_and_whoever_is_to_begin_again_does():
    states = run(
        crowd(
            {"start": "west", "goal": "kiosk", "count": 4, "then": "stay"},
            {"start": "east", "goal": "west", "count": 4, "then": "again"},
        ),
        900,
    )
    assert len(states[-1].id) == 8
    for state in states[400:]:
        x, y = state.position[:4].T
        assert ((x > 11.5) & (x < 15.5) & (y > 6.5)).all()
    x = np.array([s.position[4:, 0] for s in states])
    # There and back is 2 x 15 m or more: after 90 s everybody has been at both ends twice.
    assert ((np.diff((x < 3).astype(int), axis=0) == 1).sum(axis=0) >= 2).all()
    assert ((np.diff((x > 18).astype(int), axis=0) == 1).sum(axis=0) >= 1).all()


def test_the_same_seed_gives_the_same_people_at_the_same_times():
    def once(seed):
        model = crowd({"start": "west", "goal": "east", "rate": 2.0}, preferred_speed={"uniform": [0.8, 1.6]})
        return run(model, 200, at=setup(seed=seed))

    for a, b in zip(once(3), once(3), strict=True):
        assert np.array_equal(a.id, b.id) and np.array_equal(a.position, b.position)
        assert np.array_equal(a.gait_phase, b.gait_phase) and np.array_equal(a.stature, b.stature)
    assert len(once(3)[-1].id) != len(once(4)[-1].id) or not np.array_equal(once(3)[-1].mass, once(4)[-1].mass)


def test_traits_of_populations_hold_for_those_who_come():
    populations = [
        {"name": "slow", "share": 1, "preferred_speed": 0.6, "policy": "social_force"},
        {"name": "fast", "share": 3, "preferred_speed": 1.6, "radius": 0.2},
    ]
    states = run(crowd({"start": "west", "goal": "east", "rate": 2.0}, populations=populations), 320)
    radius = {i: r for s in states for i, r in zip(s.id.tolist(), s.radius.tolist(), strict=True)}
    # Batches of 32 have exactly a quarter of one kind.
    assert sum(radius[i] == 0.3 for i in range(1, 33)) == 8


def test_alone_nobody_comes():
    model = crowd({"start": "west", "goal": "east", "count": 5, "rate": 3.0})
    assert all(len(s.id) == 0 for s in run(model, 50, at=setup(alone=True)))


def test_everybody_walks_to_a_goal_of_their_own_and_stays():
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    circle = 4 * np.column_stack([np.cos(angle), np.sin(angle)]) + (10, 10)
    model = make(CrowdModel, {"positions": circle.tolist(), "goals": np.roll(circle, 4, axis=0).tolist()})
    states = run(model, 250, at=setup(World(size=(20.0, 20.0))))
    assert np.hypot(*(states[-1].position - np.roll(circle, 4, axis=0)).T).max() < 0.3
    assert np.hypot(*states[-1].velocity.T).max() < 0.1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"journeys": [{"start": "west", "goal": "east"}]}, "count and rate are zero"),
        ({"journeys": [{"start": "west", "goal": "est", "count": 1}]}, r"journeys\[0\]: there is no area 'est'"),
        ({"journeys": [{"start": "west", "goal": "east", "rate": [[5, 1], [2, 0]]}]}, "times .5.0, 2.0., expected"),
        ({"journeys": [{"start": "west", "goal": "east", "rate": -1}]}, "rate is -1"),
        ({"count": 3, "journeys": [{"start": "west", "goal": "east", "count": 1}]}, "count and journeys given"),
        ({"count": 3, "goals": [[1, 2]]}, "goals has 1 entries, expected one for each of 0 positions"),
        ({"areas": {"hole": {"x": [3, 1], "y": [0, 1]}}, "count": 1}, r"x is \[3.0, 1.0\], expected two numbers"),
    ],
)
def test_what_makes_no_sense_is_refused(options, message):
    with pytest.raises(ValidationError, match=message):
        make(CrowdModel, {"areas": AREAS, **options})


@pytest.mark.parametrize(
    ("journey", "areas", "message"),
    [
        (
            {"start": "west", "goal": "cell", "count": 1},
            {"cell": {"x": [9.8, 10.2], "y": [4.8, 5.2]}},
            "journeys[0]: there is no way from 'west' to 'cell' for people of radius 0.3 m",
        ),
        (
            {"start": "west", "goal": "out", "count": 1},
            {"out": {"x": [19, 22], "y": [4, 5]}},
            "areas.out is x [19.0, 22.0], y [4.0, 5.0], expected within the world of 20 x 10 m",
        ),
        (
            {"start": "west", "goal": "east", "count": 80},
            {},
            "journeys[0], in area 'west': no room for person",
        ),
    ],
)
def test_what_does_not_fit_into_the_world_is_refused(journey, areas, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        crowd(journey, areas=AREAS | areas).reset(setup())


def test_expected_numbers_are_the_integral_of_the_rate():
    journey = Journey(start="a", goal="b", rate=((1.0, 2.0), (4.0, 0.5)))
    assert [journey.expected(t) for t in (0.0, 1.0, 2.0, 4.0, 6.0)] == [0.0, 0.0, 2.0, 6.0, 7.0]
