"""Runs one Python component and holds it to the contract; the same in a process of its own and inline."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from crowdcosim.component import Component, ComponentError, Evaluator, Ports, by_port, ports_of
from crowdcosim.message import Message, MessageError, check_finite
from crowdcosim.setup import Setup

FOREVER = 0
"""The `every` of a source that speaks once, at the start."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """Where one input gets its messages from."""

    component: str
    port: str
    every: int
    """the source steps at the ticks that this divides; 0: only at the start"""
    mover: bool
    """the source's message of tick k is made in tick k - every, not in tick k"""

    def label(self, tick: int, *, last: bool = False) -> int:
        """The tick whose message a reader holds at `tick`; `last`: after the last step, nothing observes any more."""
        if self.every == FOREVER:
            return 0
        made = tick - 1 if last and not self.mover else tick
        return made // self.every * self.every


Wiring = Mapping[str, tuple[Source, ...]]
"""Input port -> its sources; none for an optional port that is not connected."""

Read = Callable[[Source, int], Message]
"""Waits for the message of a source with that label."""


class ComponentHost:
    """One component with its ports, its rate and its wiring."""

    def __init__(self, component: Component, *, every: int, wiring: Wiring, setup: Setup) -> None:
        self.component = component
        self.ports: Ports = ports_of(type(component))
        self.every = every
        self.wiring = wiring
        self.setup = setup
        """what the component is told at the next reset, but for what each episode adds"""
        self._single = {port.name: not port.many for port in self.ports.inputs}

    def reset(self, *, alone: bool, reference: Mapping[str, Mapping[str, float]] | None) -> dict[str, Message]:
        """Begin an episode; a mover's state at t = 0."""
        setup = replace(self.setup, alone=alone, reference=reference)
        result = self.component.reset(setup)
        return self._checked(result) if self.ports.kind == "mover" else {}

    def due(self, tick: int) -> bool:
        return tick % self.every == 0

    def step(self, tick: int, read: Read) -> dict[str, Message]:
        """One step from the committed state `tick`."""
        result = self.component.step(**self._inputs(tick, read))
        return {} if self.ports.kind == "observer" else self._checked(result)

    def finish(self, tick: int, read: Read) -> dict[str, Message]:
        """An observer's last look, at the final state `tick`, and its verdict."""
        if self.due(tick):
            self.component.step(**self._inputs(tick, read, last=True))
        assert isinstance(self.component, Evaluator)
        return self._checked(self.component.finish())

    def output_label(self, tick: int) -> int:
        """The tick that outputs made in `tick` hold."""
        return tick + self.every if self.ports.kind == "mover" else tick

    def _inputs(self, tick: int, read: Read, *, last: bool = False) -> dict[str, Any]:
        inputs: dict[str, Any] = {}
        for port, sources in self.wiring.items():
            messages = tuple([read(source, source.label(tick, last=last)) for source in sources])
            inputs[port] = messages if not self._single[port] else messages[0] if messages else None
        return inputs

    def _checked(self, result: Any) -> dict[str, Message]:
        outputs = by_port(self.ports, result)
        for message in outputs.values():
            check_finite(message)
        return outputs


def blame(error: BaseException) -> str:
    """One line that says what went wrong and where in the component's own code."""
    if isinstance(error, MessageError | ComponentError):
        return str(error)
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith(sys.prefix)]
    if frames:
        text += f" ({frames[-1].filename}:{frames[-1].lineno} in {frames[-1].name})"
    return text
