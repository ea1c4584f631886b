"""The evaluator as a component: ports, several robots, replay, memory; and the registry of metrics."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from components.evaluator.metric import metric
from components.evaluator.metrics import GROUPS, METRICS, PAPER, chosen
from components.evaluator.paper import Config, PaperEvaluator
from components.evaluator.run import Run
from crowdcosim.cdr import decode, encode
from crowdcosim.component import ports_of
from crowdcosim.message import check_finite
from crowdcosim.world import World


def random_frames(scene: Any, steps: int, names: tuple[str, ...] = ("robot",), people: int = 30) -> list[Any]:
    rng = np.random.default_rng(7)
    frames = []
    for k in range(steps + 1):
        crowd = scene.crowd(
            rng.uniform((0, 0), (50, 10), (people, 2)), rng.normal(size=(people, 2)), rng.uniform(-4, 4, people)
        )
        robots = tuple(
            scene.robot((0.1 * k, 2.0 * i + 1), rng.normal(size=2), *rng.normal(size=2), name=name)
            for i, name in enumerate(names)
        )
        touched = [{"duration": 0.1 * int(rng.integers(0, 3)), "energy": rng.random()}] * int(rng.integers(0, 3))
        frames.append((crowd, robots, tuple(scene.contacts(*touched, robot=name) for name in names)))
    return frames


def test_it_reads_the_crowd_and_all_robots_and_says_metrics() -> None:
    ports = ports_of(PaperEvaluator)
    assert ports.kind == "observer"
    assert [(i.name, i.many, i.optional) for i in ports.inputs] == [
        ("crowd", False, False),
        ("robots", True, False),
        ("contacts", True, False),
    ]
    assert [o.name for o in ports.outputs] == ["metrics"]


def test_there_is_one_row_per_robot_and_metric_in_order(scene: Any) -> None:
    m = scene.metrics(random_frames(scene, 3, ("b", "a")), names=("b", "a"))
    names = tuple(metric.name for metric in METRICS)
    assert m.robot == ("b",) * len(names) + ("a",) * len(names)
    assert m.name == names * 2
    assert m.unit == tuple(metric.unit for metric in METRICS) * 2
    check_finite(m)
    for value, valid, reason in zip(m.value, m.valid, m.reason, strict=True):
        assert valid == (reason == "")
        assert valid or value == 0.0


def test_metrics_of_the_recorded_messages_are_those_of_the_run(scene: Any) -> None:
    frames = random_frames(scene, 200)
    recorded = [tuple(again(part) for part in frame) for frame in frames]
    options = {"world": World(size=(50.0, 10.0), periodic=(True, True)), "goal": 15.0}
    assert scene.metrics(recorded, **options) == scene.metrics(frames, **options)


def again(part: Any) -> Any:
    """What comes out of a log."""
    return tuple(again(p) for p in part) if isinstance(part, tuple) else decode(encode(part), part.TYPE)


def test_a_second_episode_starts_from_nothing(scene: Any) -> None:
    frames, setup = random_frames(scene, 50), scene.setup()
    evaluator = PaperEvaluator(config=Config())
    verdicts = []
    for _ in range(2):
        evaluator.reset(setup)
        for frame in frames:
            evaluator.step(*frame)
        verdicts.append(evaluator.finish())
    assert verdicts[0] == verdicts[1]


def test_each_robot_is_judged_as_if_it_were_the_only_one(scene: Any) -> None:
    names = ("first", "second", "third")
    frames = random_frames(scene, 100, names)
    for i, name in enumerate(names):
        own = [(crowd, robots[i : i + 1], contacts[i : i + 1]) for crowd, robots, contacts in frames]
        assert scene.judge(frames, robot=name, names=names) == scene.judge(own, robot=name, names=(name,))


def test_one_robot_goes_on_after_the_other_has_arrived(scene: Any) -> None:
    crowd, names = scene.crowd([(0.0, 5.5)], [(1.0, 0.0)]), ("fast", "slow")
    frames = [
        (
            crowd,
            (scene.robot((0.2 * k, 5.0), name="fast"), scene.robot((0.1 * k, 5.0), name="slow")),
            (scene.contacts(robot="fast"), scene.contacts(*[{}] * (k == 30), robot="slow")),
        )
        for k in range(41)
    ]
    fast, slow = (scene.judge(frames, robot=name, names=names, goal=3.95) for name in names)
    assert (fast["time"], slow["time"]) == (2.0, 4.0)
    assert (fast["colliding"], slow["colliding"]) == (1.0, pytest.approx(0.975))


def test_the_order_in_which_messages_come_does_not_matter(scene: Any) -> None:
    names = ("first", "second", "third")
    frames = random_frames(scene, 20, names)
    shuffled = [(crowd, robots[::-1], (*contacts[1:], contacts[0])) for crowd, robots, contacts in frames]
    assert scene.metrics(shuffled, names=names) == scene.metrics(frames, names=names)


def test_a_robot_without_a_state_is_named(scene: Any) -> None:
    evaluator = PaperEvaluator(config=Config())
    evaluator.reset(scene.setup(names=("robot", "lost")))
    with pytest.raises(ValueError, match="no state of robot 'lost' among those of robot"):
        evaluator.step(scene.crowd(), (scene.robot((0, 0)),), ())


def test_two_robots_of_one_name_are_refused(scene: Any) -> None:
    with pytest.raises(ValueError, match="called a, a, expected a different name"):
        PaperEvaluator(config=Config()).reset(scene.setup(names=("a", "a")))


def test_memory_does_not_grow_with_the_length_of_the_run(scene: Any) -> None:
    frames = random_frames(scene, 20, people=5)
    evaluator = PaperEvaluator(config=Config())
    evaluator.reset(scene.setup())
    tracemalloc.start()
    used = []
    for steps in (100, 3000):
        for k in range(steps):
            evaluator.step(*frames[k % 20])
        used.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert used[1] - used[0] < 3000 * 8  # bytes: a history of one number per step would be this long at the least


def test_metrics_have_distinct_names_and_say_what_they_are() -> None:
    assert len({m.name for m in METRICS}) == len({m.symbol for m in METRICS}) == len(METRICS)
    assert all(m.direction in ("higher", "lower", "none") and 0 < len(m.description) < 80 for m in METRICS)
    assert [m.symbol for m in PAPER] == [
        "T/Tcr",
        "L/Lcr",
        "J/Jcr",
        "NBR vel.",
        "NBR reac.",
        "Prox.",
        "Colliding",
    ]


def test_a_metric_says_which_sums_it_needs_by_the_types_of_its_parameters() -> None:
    @metric(symbol="K", unit="1", direction="none")
    def steps(run: Run) -> float:
        """Steps taken."""
        return run.steps

    run = Run(steps=3, time=0.3, arrived=True, goal_distance=0.0, alone=False, people=0, reference=None)
    assert (steps.name, steps.description, steps(run, {})) == ("steps", "Steps taken.", 3)


def test_a_metric_of_something_else_is_refused() -> None:
    with pytest.raises(TypeError, match="metric 'bad': parameter 'x' is <class 'int'>, expected Run or a class"):

        @metric(symbol="K", unit="1", direction="none")
        def bad(x: int) -> float:
            """Bad."""
            return x


def test_a_metric_without_a_docstring_is_refused() -> None:
    with pytest.raises(TypeError, match="metric 'silent' has no docstring"):

        @metric(symbol="K", unit="1", direction="none")
        def silent(run: Run) -> float:
            return run.time


def test_a_user_adds_a_metric_with_one_file(scene: Any, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        '''
from components.evaluator.metric import metric
from components.evaluator.scene import Step


class Sums:
    def __init__(self) -> None:
        self.farthest = 0.0

    def add(self, step: Step) -> None:
        self.farthest = max(self.farthest, abs(step.after.robot.position[1] - 5.0))


@metric(symbol="aside", unit="m", direction="lower")
def aside(sums: Sums) -> float:
    """Farthest from the corridor's middle."""
    return sums.farthest
'''
    )
    frames = [(scene.crowd(), (scene.robot((0.1 * k, 5.0 + 0.2 * (k == 3))),), ()) for k in range(6)]
    assert scene.judge(frames, metrics=[f"{tmp_path}/mine.py:aside"]) == {"aside": pytest.approx(0.2)}


def test_metrics_are_chosen_by_group_and_name_without_twins() -> None:
    assert [m.name for m in chosen(["proximity", "danger", "proximity"])] == ["proximity", "danger"]
    assert chosen(["paper", "proximity"]) == GROUPS["paper"]
    assert set(chosen(Config().metrics)) == set(METRICS) - set(GROUPS["authors"])


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("proximty",), r"metrics has 'proximty': did you mean 'proximity'\?"),
        ((), "metrics is empty"),
        (("./nowhere.py:mine",), "metrics has './nowhere.py:mine': there is no file"),
        (("components.evaluator.metrics:GROUPS",), "it is no metric"),
    ],
)
def test_metrics_that_are_not_there_are_refused(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Config(metrics=names)


def test_a_ratio_may_be_asked_for_alone(scene: Any) -> None:
    frames = scene.drive(50, crowd=lambda t: scene.crowd())
    alone = scene.judge(frames, metrics=["time_ratio"], alone=True, goal=4.95)
    slow = scene.drive(100, speed=0.5, crowd=lambda t: scene.crowd([(t, 9.0)]))
    found = scene.judge(slow, metrics=["time_ratio"], goal=4.95, reference={"robot": alone})
    assert found == {"time_ratio": pytest.approx(0.5, rel=0.02)}  # arrivals are known to one step of 50
