"""What is wrong with a scenario: each problem with file, line and key; all problems of a validation in one error."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from orchestrator.errors import InputError


@dataclass(frozen=True, slots=True)
class Place:
    """Where the user wrote something."""

    name: str
    """the file as the user knows it, `--set key=value`, or "scenario" for a mapping made in Python"""
    line: int = 0
    """from 1; 0 where there are no lines"""
    folder: Path = Path()
    """where relative paths written here begin"""

    def __str__(self) -> str:
        return f"{self.name}:{self.line}" if self.line else self.name


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong."""

    place: Place
    key: str
    """dotted path of the key, empty for the whole file"""
    text: str
    """what was found, what was expected, what to do"""

    def __str__(self) -> str:
        return ": ".join(part for part in (str(self.place), self.key, self.text) if part)


class ScenarioError(InputError):
    """A scenario cannot be loaded; says every problem on a line of its own."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(dict.fromkeys(problems), key=lambda p: (p.place.name, p.place.line)))
        super().__init__("\n".join(str(problem) for problem in self.problems))


def near_miss(word: object, known: Iterable[str]) -> str:
    """The known word nearest to `word`, as a question to append; empty if none is near."""
    by_lower_case = {name.lower(): name for name in known}
    near = get_close_matches(str(word).lower(), by_lower_case, 1)
    return f" (did you mean '{by_lower_case[near[0]]}'?)" if near else ""


def shown(value: Any) -> str:
    """A value of a scenario as an error message shows it, short."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    text = repr(value)
    if len(text) <= 60:
        return text
    return f"a list of {len(value)}" if isinstance(value, list) else f"{text[:57]}..."


def key_path(parts: Iterable[str | int]) -> str:
    """`("walls", 0, "start")` as `walls[0].start`."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).removeprefix(".")
