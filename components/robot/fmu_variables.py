"""The variables of the built-in wheel drive FMU, taken from the native model: one table for its C code and its XML."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from dataclasses import dataclass, fields
from typing import Any, Literal

from components.robot.motor import TURTLEBOT2, Motor, Vehicle

Causality = Literal["independent", "input", "parameter", "output"]

_SIDES = ("left", "right")
_INPUTS = (
    ("command", "rad/s", "wanted speed of the {} wheel"),
    ("load", "N.m", "torque that resists the {} wheel: forward if positive, backward if negative; it never drives it"),
)
_OUTPUTS = (
    ("speed", "rad/s", "speed of the {} wheel"),
    ("angle", "rad", "angle that the {} wheel has turned"),
    ("torque", "N.m", "torque of the {} motor, at the wheel"),
    ("current", "A", "current through the {} motor"),
)

UNITS: dict[str, dict[str, int]] = {
    "s": {"s": 1},
    "m": {"m": 1},
    "kg": {"kg": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "A": {"A": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "N.m/A": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "V.s/rad": {"kg": 1, "m": 2, "s": -2, "A": -1, "rad": -1},
    "V/rad": {"kg": 1, "m": 2, "s": -3, "A": -1, "rad": -1},
}
"""unit -> exponents of the SI base units"""


@dataclass(frozen=True, kw_only=True)
class Variable:
    """One variable of the FMU."""

    name: str
    reference: int
    causality: Causality
    description: str
    unit: str = ""
    """a key of `UNITS`, empty for a number without unit"""
    start: float | None = None
    integer: bool = False

    @property
    def symbol(self) -> str:
        """Its name in C."""
        return "NOW" if self.causality == "independent" else self.name.upper()


def variables() -> tuple[Variable, ...]:
    """All variables by value reference: time, inputs, parameters, outputs, and the encoders' ticks."""
    rows: list[dict[str, Any]] = [_row("time", "independent", "s", "simulated time")]
    rows += [
        _row(f"{side}_{name}", "input", unit, text.format(side)) | {"start": 0.0}
        for name, unit, text in _INPUTS
        for side in _SIDES
    ]
    for part in (Motor(), TURTLEBOT2):
        documented = _documented(type(part))
        rows += [
            _row(field.name, "parameter", *documented[field.name]) | {"start": float(getattr(part, field.name))}
            for field in fields(part)
        ]
    rows += [
        _row(f"{side}_{name}", "output", unit, text.format(side)) for name, unit, text in _OUTPUTS for side in _SIDES
    ]
    rows += [_row("battery_voltage", "output", "V", "voltage that the battery gives under load")]
    rows += [
        _row(f"{side}_ticks", "output", "", f"ticks that the {side} encoder has counted") | {"integer": True}
        for side in _SIDES
    ]
    return tuple(Variable(reference=reference, **row) for reference, row in enumerate(rows))


def _row(name: str, causality: Causality, unit: str, description: str) -> dict[str, Any]:
    return {"name": name, "causality": causality, "unit": unit, "description": description}


def _documented(cls: type[Motor] | type[Vehicle]) -> dict[str, tuple[str, str]]:
    """Field -> (unit, description) from the docstrings below the fields, which end with the unit in brackets."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(cls))).body
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for field, text in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
            matched = re.fullmatch(r"(.*?)\s*\[(.+)\]", str(text.value.value))
            assert matched is not None and isinstance(field.target, ast.Name)
            unit = matched[2].replace(" ", ".")
            found[field.target.id] = ("" if unit == "1" else unit, matched[1] or field.target.id.replace("_", " "))
    return found
