"""Tests after RiMEA's guideline (version 3.0, 2016) and ISO 20414: walking, corners, walls, doors, evacuation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.crowd.crowd import CrowdModel
from components.crowd.walls import Walls, nearby, nearest_of_thing
from crowdcosim.component import make
from crowdcosim.obstacles import Box, Disc
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World
from tests.components.crowd.test_policies import AVOIDING

MAIN = ["orca", "social_force", "power_law"]


def room(width, depth, *walls, obstacles=()):
    """A world with walls all round and some more."""
    corners = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    edges = [Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return World(size=(width, depth), walls=(*edges, *(Wall(start=a, end=b) for a, b in walls)), obstacles=obstacles)


def with_door(width):
    """A room of 12 m x 10 m with a door in its right wall, and space behind."""
    return room(18.0, 10.0, ((12.0, 0.0), (12.0, 5 - width / 2)), ((12.0, 5 + width / 2), (12.0, 10.0)))


def walk(world, areas, journeys, steps, *, seed=1, **options):
    """All states until nobody is there, or for so many steps."""
    model = make(CrowdModel, {"areas": areas, "journeys": journeys, **options})
    states = [model.reset(Setup(component="crowd", period=100_000_000, seed=seed, world=world))]
    while len(states) <= steps and len(states[-1].id):
        states.append(model.step(()))
    return states


def clearance(position, world):
    """Least distance of somebody's centre to what stops people, 1 m at most."""
    grid, least = Walls.of(world).within(1.0), 1.0
    for x, y in position:
        q, end = nearby(grid, x, y)
        while q < end:
            q, px, py = nearest_of_thing(grid, q, end, x, y)
            least = min(least, np.hypot(px, py))
    return least


def closest(states):
    """Least distance between two people's centres [m]."""
    least = np.inf
    for state in states:
        d = np.hypot(*(state.position[:, None] - state.position[None]).transpose(2, 0, 1))
        np.fill_diagonal(d, np.inf)
        least = min(least, d.min(initial=np.inf))
    return least


@pytest.mark.parametrize("policy", AVOIDING)
def test_rimea_1_whoever_walks_40_m_along_a_corridor_needs_the_time_of_the_preferred_speed(policy):
    areas = {"start": {"x": [1, 1], "y": [1, 1]}, "end": {"x": [41, 42], "y": [0, 2]}}
    journeys = [{"start": "start", "goal": "end", "count": 1}]
    # Far from the end wall: to some policies a wall ahead is as bad as a person ahead, at any distance.
    states = walk(room(60.0, 2.0), areas, journeys, 450, policy=policy, preferred_speed=1.33)
    # 1.33 m/s with 5%: 26 s to 34 s, as the guideline has it.
    assert 26.0 <= (len(states) - 1) * 0.1 <= 34.0
    assert clearance(np.concatenate([s.position for s in states]), room(60.0, 2.0)) > 0.3


@pytest.mark.parametrize("policy", MAIN)
def test_rimea_6_twenty_people_go_round_a_corner_to_the_left_and_not_through_it(policy):
    # A corridor 2 m wide, 12 m to the right and then 12 m up.
    world = room(12.0, 12.0, obstacles=(Box(shape="box", centre=(5.0, 7.0), size=(10.0, 10.0)),))
    areas = {"start": {"x": [0, 6], "y": [0, 2]}, "end": {"x": [10, 12], "y": [11, 12]}}
    states = walk(world, areas, [{"start": "start", "goal": "end", "count": 20}], 400, policy=policy)
    assert len(states[-1].id) == 0
    assert not any(world.obstructed(s.position).any() for s in states)
    # People press each other against the wall a little, by less than half a radius.
    assert clearance(np.concatenate([s.position for s in states]), world) > 0.15


@pytest.mark.parametrize("policy", AVOIDING)
def test_whoever_goes_round_a_corner_alone_does_not_touch_it(policy):
    world = room(12.0, 24.0, obstacles=(Box(shape="box", centre=(5.0, 13.0), size=(10.0, 22.0)),))
    areas = {"start": {"x": [1, 2], "y": [0.5, 1.5]}, "end": {"x": [10, 12], "y": [9, 10]}}
    states = walk(world, areas, [{"start": "start", "goal": "end", "count": 1}], 400, policy=policy)
    assert len(states[-1].id) == 0
    # Contacts begin at 0.3 m; whoever cuts the corner touches by a hand's width at most.
    assert clearance(np.concatenate([s.position for s in states]), world) > 0.25


@settings(deadline=None, max_examples=12)
@given(seed=st.integers(0, 2**32 - 1), policy=st.sampled_from(MAIN), periodic=st.tuples(st.booleans(), st.booleans()))
def test_nobody_ever_crosses_a_wall_or_enters_an_obstacle(seed, policy, periodic):
    rng = np.random.default_rng(seed)
    obstacles = tuple(
        Box(shape="box", centre=tuple(rng.uniform(3, 11, 2)), size=tuple(rng.uniform(0.1, 2, 2)), yaw=rng.uniform(0, 3))
        for _ in range(4)
    ) + tuple(Disc(shape="disc", centre=tuple(rng.uniform(0, 14, 2)), radius=rng.uniform(0.1, 1)) for _ in range(3))
    wall = Wall(start=tuple(rng.uniform(3, 11, 2)), end=tuple(rng.uniform(3, 11, 2)))
    world = World(size=(14.0, 14.0), periodic=periodic, walls=(wall,), obstacles=obstacles)
    free = []
    for p in rng.uniform(0.4, 13.6, (20, 2)).tolist():
        apart = all(np.hypot(*world.displacement(np.array(p), np.array(q))) > 0.65 for q in free)
        if apart and clearance([p], world) > 0.32 and not world.obstructed(np.array([p]))[0]:
            free.append(p)
    model = make(CrowdModel, {"positions": free, "goals": rng.permutation(free).tolist(), "policy": policy})
    try:
        old = model.reset(Setup(component="crowd", period=100_000_000, seed=1, world=world))
    except ValueError as error:
        # Obstacles may lock somebody in.
        assert "there is no way" in str(error)
        return
    a, b = world.segments_for_people[0]
    along = b - a
    for _ in range(60):
        new = model.step(())
        assert not world.obstructed(new.position).any()
        # Between two steps nobody goes from one side of the wall to the other within its length.
        p, q = (
            world.displacement(a, old.position),
            world.displacement(a, old.position) + world.displacement(old.position, new.position),
        )
        sides = [along[0] * v[:, 1] - along[1] * v[:, 0] for v in (p, q)]
        share = np.clip(sides[0] / np.where(sides[0] == sides[1], 1.0, sides[0] - sides[1]), 0, 1)
        place = ((p + (q - p) * share[:, None]) @ along) / (along @ along)
        assert not ((sides[0] * sides[1] < 0) & (place > 0) & (place < 1)).any()
        old = new


def test_the_flow_through_a_door_is_within_published_bounds():
    areas = {"room": {"x": [3, 11], "y": [0, 10]}, "outside": {"x": [16, 18], "y": [0, 10]}}
    journeys = [{"start": "room", "goal": "outside", "count": 80}]
    for width in (1.2, 2.0):
        states = walk(with_door(width), areas, journeys, 900, policy="social_force")
        assert len(states[-1].id) == 0
        through = np.array([80 - len(s.id) + (s.position[:, 0] > 12).sum() for s in states])
        # Of the 80, those who go through in the middle of the time.
        begin, end = (through >= 12).argmax(), (through >= 68).argmax()
        flow = (through[end] - through[begin]) / ((end - begin) * 0.1) / width
        # Specific flows of 1.3 (the SFPE Handbook) to 2.0 /(m s) (Kretz et al. 2006; Seyfried et al. 2009), and a
        # tenth for one seed.
        assert 1.2 < flow < 2.2


@pytest.mark.parametrize("policy", MAIN)
def test_a_room_empties_through_its_door(policy):
    areas = {"room": {"x": [3, 11], "y": [0, 10]}, "outside": {"x": [16, 18], "y": [0, 10]}}
    world = with_door(1.5)
    states = walk(world, areas, [{"start": "room", "goal": "outside", "count": 40}], 900, policy=policy)
    assert len(states[-1].id) == 0
    assert np.concatenate([s.position for s in states])[:, 0].max() < 16.1


@pytest.mark.parametrize(("policy", "least"), [("orca", 0.40), ("power_law", 0.40), ("social_force", 0.20)])
def test_in_a_dense_flow_bodies_overlap_by_no_more_than_contacts_give_way(policy, least):
    # A contact between two who are driven against each other with all they can, 5 m/s2 each, gives way by
    # 2 x 5 / (2 k / m) = 0.08 m; in a jam several people's drives add up on one contact. Social forces of a crowd
    # add up to more than a contact's.
    model = make(CrowdModel, {"count": 350, "flow": "2dx", "policy": policy})
    world = World(size=(50.0, 10.0), periodic=(True, True))
    model.reset(Setup(component="crowd", period=100_000_000, seed=1, world=world))
    assert closest([model.step(()) for _ in range(150)]) > least
