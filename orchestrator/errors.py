"""What can go wrong with a run, said so that the user knows where and what to do."""

from __future__ import annotations


class InputError(Exception):
    """The user's input cannot be run; nothing was simulated. Exit code 2."""


class WiringError(InputError):
    """The components of a scenario do not fit together."""

    def __init__(self, problems: list[tuple[str, str]]) -> None:
        self.problems = problems
        """(component, what is wrong) of each problem"""
        super().__init__("\n".join(f"component '{component}': {text}" for component, text in problems))


class RunError(Exception):
    """A run failed. Exit code 1."""

    def __init__(self, component: str | None, tick: int | None, text: str) -> None:
        self.component = component
        """the component to blame, None if none is"""
        self.tick = tick
        """the tick in which it failed, None before the first"""
        where = f"component '{component}'" if component else "the run"
        when = f" at tick {tick}" if tick is not None else ""
        super().__init__(f"{where}{when}: {text}")
