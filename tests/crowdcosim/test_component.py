"""Ports come from the signature of `step`; what breaks the contract is refused with cause and cure."""

from dataclasses import dataclass
from typing import NamedTuple

import pytest
from pydantic import ValidationError

from crowdcosim import Component, Controller, Evaluator, Mover, Sensor
from crowdcosim.component import ComponentError, by_port, config_type, make, ports_of
from crowdcosim.messages import Crowd, Goal, LaserScan, Metrics, Odometry, RobotState, Twist


@dataclass(frozen=True, kw_only=True)
class Config:
    speed: float = 1.0

    def __post_init__(self) -> None:
        if self.speed < 0:
            raise ValueError(f"speed is {self.speed}, expected zero or more")


class Both(NamedTuple):
    near: LaserScan
    far: LaserScan


class Drive(Controller):
    def __init__(self, config: Config) -> None:
        self.config = config

    def step(self, odometry: Odometry, goal: Goal | None, others: tuple[RobotState, ...]) -> Twist:
        return Twist()


class Look(Sensor):
    def step(self, crowd: Crowd) -> Both:
        return Both(LaserScan(), LaserScan())


class Judge(Evaluator):
    def step(self, crowd: Crowd) -> None:
        pass


def test_inputs_are_required_optional_or_many() -> None:
    ports = ports_of(Drive)
    assert [(p.name, p.type, p.optional, p.many) for p in ports.inputs] == [
        ("odometry", Odometry, False, False),
        ("goal", Goal, True, False),
        ("others", RobotState, False, True),
    ]


def test_an_output_is_named_after_its_message_or_its_field() -> None:
    assert [(p.name, p.type) for p in ports_of(Drive).outputs] == [("twist", Twist)]
    assert [(p.name, p.type) for p in ports_of(Look).outputs] == [("near", LaserScan), ("far", LaserScan)]


def test_an_evaluator_gives_metrics_at_the_end_only() -> None:
    assert [(p.name, p.type) for p in ports_of(Judge).outputs] == [("metrics", Metrics)]


def test_what_step_returns_is_sorted_by_port() -> None:
    both = Both(LaserScan(angle_min=1), LaserScan(angle_min=2))
    assert by_port(ports_of(Look), both) == {"near": both.near, "far": both.far}


@pytest.mark.parametrize("result", [None, Twist(), (LaserScan(), LaserScan(), LaserScan()), (LaserScan(), Twist())])
def test_a_result_that_breaks_the_signature_is_refused(result) -> None:
    with pytest.raises(ComponentError, match="signature promises"):
        by_port(ports_of(Look), result)


def test_signatures_without_message_types_are_refused() -> None:
    class NoStep(Sensor):
        pass

    class Number(Sensor):
        def step(self, crowd: float) -> Twist: ...

    class Text(Sensor):
        def step(self) -> str: ...

    class Talkative(Evaluator):
        def step(self, crowd: Crowd) -> Twist: ...

    for cls, words in (
        (NoStep, "has no step"),
        (Number, "input 'crowd'"),
        (Text, "returns"),
        (Talkative, "nothing flows back"),
    ):
        with pytest.raises(ComponentError, match=words):
            ports_of(cls)


def test_the_config_is_checked_when_a_component_is_made() -> None:
    assert make(Drive, {"speed": 2}).config == Config(speed=2.0)
    for options, words in (({"sped": 2}, "sped"), ({"speed": "quick"}, "speed"), ({"speed": -1}, "zero or more")):
        with pytest.raises(ValidationError, match=words):
            make(Drive, options)


def test_a_component_without_init_has_no_options() -> None:
    assert isinstance(make(Look, {}), Look)
    with pytest.raises(ValidationError):
        make(Look, {"speed": 1})


def test_an_init_without_a_config_dataclass_is_refused() -> None:
    class Loose(Controller):
        def __init__(self, config: dict) -> None: ...

    with pytest.raises(ComponentError, match="frozen, keyword-only dataclass"):
        config_type(Loose)


def test_kinds_tell_when_outputs_hold() -> None:
    assert [c.kind for c in (Component, Sensor, Controller, Mover, Evaluator)] == [
        "reactor",
        "reactor",
        "reactor",
        "mover",
        "observer",
    ]
