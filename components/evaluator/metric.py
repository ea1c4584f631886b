"""What a metric is: a pure function from sums over a run to a number, with symbol, unit and sense as printed."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from components.evaluator.run import Invalid, Run
from components.evaluator.scene import Step

Direction = Literal["higher", "lower", "none"]
"""Which is better: a higher value, a lower one, or neither."""

Requirement = Callable[[Run], Invalid | None]
"""What a run must have for a metric to mean anything: None if it has it, else the reason why not."""


class Sums(Protocol):
    """What one topic keeps of one robot's run; its size must not grow with the length of the run."""

    def add(self, step: Step) -> None:
        """Take one step of the robot into account; called for every step until it has arrived."""


@dataclass(frozen=True, kw_only=True)
class Metric:
    """One metric, made by the decorator `metric` from a function over a `Run` and the `Sums` it needs."""

    function: Callable[..., float | Invalid]
    """its parameters' types say which sums it needs, as the types in `step` say a component's ports"""
    symbol: str
    """as printed in tables and charts"""
    unit: str
    """SI unit, 1 for a ratio"""
    direction: Direction
    needs: tuple[Requirement, ...]
    """checked in order before the function is asked"""
    inputs: tuple[type, ...]
    """types of the function's parameters: `Run` or a kind of `Sums` each"""

    @property
    def name(self) -> str:
        """The function's name."""
        return self.function.__name__

    @property
    def description(self) -> str:
        """The docstring's first line."""
        return inspect.getdoc(self.function).partition("\n")[0]  # type: ignore[union-attr]  # `metric` has seen it

    def __call__(self, run: Run, sums: Mapping[type, Sums]) -> float | Invalid:
        """The metric's value in a run, or why there is none. `sums` has one entry per type in `inputs` but `Run`."""
        for need in self.needs:
            if (lacking := need(run)) is not None:
                return lacking
        return self.function(*(run if kind is Run else sums[kind] for kind in self.inputs))


def metric(
    *, symbol: str, unit: str, direction: Direction, needs: tuple[Requirement, ...] = ()
) -> Callable[[Callable[..., float | Invalid]], Metric]:
    """Decorate a function `(run: Run, sums: SomeSums, ...) -> float | Invalid` to make it a `Metric`.

    Raises:
        TypeError: if a parameter's type is neither `Run` nor a class with `add(step)`, or there is no docstring.
    """

    def decorate(function: Callable[..., float | Invalid]) -> Metric:
        hints: dict[str, Any] = typing.get_type_hints(function)
        hints.pop("return", None)
        for name, kind in hints.items():
            if kind is not Run and not hasattr(kind, "add"):
                raise TypeError(
                    f"metric '{function.__name__}': parameter '{name}' is {kind!r}, "
                    "expected Run or a class with `add(self, step: Step) -> None`"
                )
        if not inspect.getdoc(function):
            raise TypeError(f"metric '{function.__name__}' has no docstring, expected its equation and source")
        return Metric(
            function=function, symbol=symbol, unit=unit, direction=direction, needs=needs, inputs=tuple(hints.values())
        )

    return decorate
