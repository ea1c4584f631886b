"""Where people are expected: constant velocity, ORCA, and the log of an earlier run."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from mcap.reader import make_reader

from components.controllers.ego import Ego
from components.controllers.mpc import MPC
from components.controllers.prediction import Horizon, Prediction, Predictor
from components.controllers.surroundings import discs_of
from crowdcosim.cdr import decode
from crowdcosim.component import make
from crowdcosim.messages import Crowd, Header
from crowdcosim.setup import time_of
from orchestrator.episode import run_episode
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation

HORIZON = Horizon(20, 0.2, 1.0, 1.0, 0.177)
TIMES = 0.2 * np.arange(21)
EGO = Ego(25.0, 5.0, 0.0, 1.0, 0.0)
STAYS = np.zeros((21, 2))


def predict(scene, model, crowd, others=(), own=STAYS):
    predictor = Predictor(Prediction(model=model), scene.setup())
    return predictor.tracks(EGO, Header(), discs_of(crowd, others, "robot"), own, HORIZON)


def two(scene, y=0.2):
    """Two people who walk at each other, not quite head-on."""
    return scene.crowd((24.0, 6.0), (28.0, 6.0 + y), velocity=[(1.2, 0.0), (-1.2, 0.0)])


def test_at_constant_velocity_everybody_walks_on(scene):
    crowd = two(scene)
    tracks = predict(scene, "constant_velocity", crowd)
    expected = crowd.position - (25.0, 5.0) + TIMES[:, None, None] * crowd.velocity
    np.testing.assert_allclose(tracks.position, expected, atol=1e-12)


def test_who_cannot_be_met_is_left_out_and_people_are_seen_across_the_seam(scene):
    crowd = scene.crowd((25.0, 9.9), (5.0, 5.0), velocity=(0.0, 1.0))
    tracks = predict(scene, "constant_velocity", crowd)
    np.testing.assert_allclose(tracks.position[:, 0, 1], 4.9 + TIMES, atol=1e-12)
    far = scene.crowd((49.0, 5.0), velocity=(0.0, 0.0))
    assert predict(scene, "constant_velocity", far).position.shape == (21, 0, 2)


def test_with_orca_people_pass_each_other_where_constant_velocity_has_them_collide(scene):
    def least(tracks):
        return np.hypot(*(tracks.position[:, 0] - tracks.position[:, 1]).T).min()

    assert least(predict(scene, "constant_velocity", two(scene))) < 0.3
    # Reciprocal avoidance brings each just past the other; a step of 0.2 s lets them graze.
    assert least(predict(scene, "orca", two(scene))) > 0.58


def test_with_orca_alone_nobody_changes_and_robots_never_do(scene):
    robot = scene.robot("other", 27.0, 5.1)
    alone = scene.crowd((24.0, 9.0), velocity=(0.5, 0.0))
    for model in ("orca", "orca_reciprocal"):
        tracks = predict(scene, model, alone, (robot,), own=np.add(STAYS, (0.0, -3.0)))
        straight = predict(scene, "constant_velocity", alone, (robot,))
        np.testing.assert_allclose(tracks.position, straight.position, atol=1e-12)


def test_only_reciprocal_people_make_way_for_the_robot(scene):
    comes = scene.crowd((28.0, 5.05), velocity=(-1.2, 0.0))
    blind = predict(scene, "orca", comes)
    makes_way = predict(scene, "orca_reciprocal", comes)
    assert np.hypot(*blind.position[:, 0].T).min() < 0.15
    assert np.hypot(*makes_way.position[:, 0].T).min() > 0.4


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """6 s of a corridor, and the scenario."""
    path = tmp_path_factory.mktemp("record") / "crowd.mcap"
    settings = ["crowd.config.count=60", "crowd.config.reactive=false", "host=inline", "end.time_limit=6"]
    run(settings, path)
    return path, settings


def run(settings, path=None):
    simulation = Simulation(load("corridor", [*settings, "reference=false"]), logs=path.parent if path else path)
    try:
        return run_episode(simulation, log=path)
    finally:
        simulation.close()


def test_the_record_of_the_same_crowd_is_its_future(scene, log):
    path, _ = log
    states = states_of(path)
    predictor = Predictor(Prediction(model="record", log=str(path)), scene.setup())
    discs = discs_of(states[10], (), "robot")
    tracks = predictor.tracks(EGO, states[10].header, discs, STAYS, HORIZON)
    later = scene.corridor.displacement(np.array([25.0, 5.0]), states[10 + 2 * 5].position)
    # Of everybody in reach, some are where the log has them a second later, all of them if none is left out.
    for position in tracks.position[5]:
        assert np.hypot(*(later - position).T).min() < 1e-9


def states_of(path):
    with path.open("rb") as stream:
        return [decode(m.data, Crowd.TYPE) for _, c, m in make_reader(stream).iter_messages() if "crowd" in c.topic]


def test_a_controller_with_the_record_drives_through_the_same_run(log):
    path, settings = log
    oracle = [
        "robots.robot.controller.use=mpc",
        "robots.robot.controller.config.prediction.model=record",
        f"robots.robot.controller.config.prediction.log={path}",
    ]
    assert run([*settings, *oracle, "end.time_limit=3"]).ticks == 30


def test_a_record_of_other_people_is_refused(scene, log):
    path, _ = log
    state = states_of(path)[3]
    moved = dataclasses.replace(state, position=np.add(state.position, (0.0, 1e-3)))
    predictor = Predictor(Prediction(model="record", log=str(path)), scene.setup())
    for crowd, said in ((moved, "after 0.3 s people are not where"), (scene.crowd((1, 1)), "has 60 people, but")):
        with pytest.raises(ValueError, match=said):
            predictor.tracks(EGO, state.header, discs_of(crowd, (), "robot"), STAYS, HORIZON)
    late = Header(stamp=time_of(7_000_000_000))
    with pytest.raises(ValueError, match="ends after 6 s"):
        predictor.tracks(EGO, late, discs_of(state, (), "robot"), STAYS, HORIZON)


@pytest.mark.parametrize(
    ("text", "said"), [(None, "cannot be read: No such file"), ("no log", "is no MCAP log that can be read")]
)
def test_a_record_that_cannot_be_read_is_refused(scene, tmp_path, text, said):
    path = tmp_path / "x.mcap"
    if text:
        path.write_text(text)
    with pytest.raises(ValueError, match=said):
        Predictor(Prediction(model="record", log=str(path)), scene.setup())


@pytest.mark.parametrize("options", [{"model": "record"}, {"model": "orca", "log": "x.mcap"}])
def test_a_log_belongs_to_the_record_and_to_nothing_else(options):
    with pytest.raises(ValueError, match="expected a log with 'record' and with no other"):
        Prediction(**options)


def test_a_misspelt_option_of_the_prediction_is_refused():
    with pytest.raises(ValueError, match="modle"):
        make(MPC, {"prediction": {"modle": "orca"}})


def test_predictions_mirror(scene):
    crowd = scene.random_crowd(3, 60)
    mirrored = scene.crowd(*map(tuple, crowd.position * (1, -1) + (0, 10)), velocity=crowd.velocity * (1, -1))
    for model in ("constant_velocity", "orca", "orca_reciprocal"):
        one, other = predict(scene, model, crowd).position, predict(scene, model, mirrored).position
        assert math.isfinite(one.sum())
        # Neighbours equally far could come in another order; none are here. Programs magnify rounding.
        np.testing.assert_allclose(one * (1, -1), other, atol=1e-6)
