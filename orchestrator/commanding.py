"""Velocity commands from outside: which robots take them, and what may be given."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal

from components.controllers.commanded import Commanded
from crowdcosim.messages import Twist, Vector3
from orchestrator.errors import InputError
from orchestrator.scenario.problems import near_miss
from orchestrator.scenario.scenario import Scenario

Command = Twist | Sequence[float]
"""A velocity in the robot's frame: a `Twist`, or forward speed, (speed to the left [m/s],) and turn rate [rad/s]."""


def twists(robots: Sequence[str], command: Command | Mapping[str, Command] | None) -> dict[str, Twist]:
    """The command of each of the commanded `robots`.

    Raises:
        InputError: if it is not one for each of them, of finite numbers.
    """
    named = command if isinstance(command, Mapping) else {}
    if command is not None and not isinstance(command, Mapping):
        if len(robots) != 1:
            expected = f"one for each of {', '.join(robots)}" if robots else "none: no robot is commanded"
            raise InputError(f"found one command, expected {expected}")
        named = {robots[0]: command}
    for robot in named:
        if robot not in robots:
            raise InputError(
                f"'{robot}' is no robot that is commanded{near_miss(robot, robots)}; "
                f"commanded: {', '.join(robots) or 'none'}"
            )
    if missing := [robot for robot in robots if robot not in named]:
        raise InputError(f"there is no command for {', '.join(missing)}; expected one for each commanded robot")
    return {robot: _twist(robot, named[robot]) for robot in robots}


def robots_to_command(scenario: Scenario, wanted: list[str]) -> tuple[str, ...]:
    """The robots that are commanded: those that are wanted, and those that have no controller."""
    robots = [robot.name for robot in scenario.robots]
    for name in wanted:
        if name not in robots:
            raise InputError(f"there is no robot '{name}'{near_miss(name, robots)}; robots: {', '.join(robots)}")
    driven = {spec.name for spec in scenario.components}
    return tuple(r for r in robots if r in wanted or f"{r}/controller" not in driven)


def take_over(robot: str, latency: float | Literal["measured"]) -> tuple[str, ...]:
    """Settings that put us in the place of the robot's controller."""
    key = f"robots.{robot}.controller"
    use = f"{Commanded.__module__}:{Commanded.__qualname__}"
    return (f"{key}=null", f"{key}={{use: '{use}', host: inline, latency: {latency}}}")


def _twist(robot: str, command: Command) -> Twist:
    if isinstance(command, Twist):
        numbers = [*_components(command.linear), *_components(command.angular)]
        twist = command
    else:
        try:
            numbers = [float(number) for number in command]
            speed, left, turn_rate = numbers if len(numbers) == 3 else (numbers[0], 0.0, *numbers[1:])
        except (TypeError, ValueError, IndexError):
            raise InputError(
                f"the command for {robot} is {command!r}, "
                "expected a Twist, or forward speed [m/s], (speed to the left [m/s],) turn rate [rad/s]"
            ) from None
        twist = Twist(linear=Vector3(x=speed, y=left), angular=Vector3(z=turn_rate))
    if not all(map(math.isfinite, numbers)):
        raise InputError(f"the command for {robot} is {command!r}, expected finite numbers")
    return twist


def _components(vector: Vector3) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z
