"""The conformance test of a component: the same for Python and for any other language, over real Zenoh."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from orchestrator.errors import InputError, RunError
from orchestrator.processes import Processes, tail
from orchestrator.remote import Finished
from orchestrator.simulation import PRELOAD
from orchestrator.trial import LEAVE, NAME, PERIOD, TICKS, Output, Subject, Trial

FUTURE = 7
"""Tick that an input claims to be of when tick 0 is asked for."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """One thing that a component must do, and whether it does."""

    name: str
    passed: bool
    detail: str


def conformance(subject: Subject) -> Iterator[Verdict]:
    """Try everything that the protocol asks of a component; one verdict for each."""
    processes = Processes()
    if subject.use:
        processes.preload(PRELOAD)
    try:
        with tempfile.TemporaryDirectory(prefix="crowdcosim-check-") as folder:
            yield from _Examination(subject, Path(folder), processes).verdicts()
    finally:
        processes.close()


class _Examination:
    """All that is tried, in the fewest processes: a component may take long to start."""

    def __init__(self, subject: Subject, folder: Path, processes: Processes) -> None:
        self._subject = subject
        self._folder = folder
        self._processes = processes
        self._first: list[Output] = []

    def verdicts(self) -> Iterator[Verdict]:
        """In order; what depends on something that failed is left out."""
        with self._trial("introduction") as trial:
            yield (hello := _verdict("hello: protocol, ports and type hashes", self._hello, trial))
            if not hello.passed:
                return
            inputs = trial.ports.inputs
            yield _verdict("an unknown key in the config is refused", self._refuses_config, trial)
        with self._trial("episodes") as trial:
            yield (ready := _verdict("takes its config and connects", self._connects, trial))
            if not ready.passed:
                return
            yield (finite := _verdict("finite outputs on every port, with the right tick", self._episodes, trial))
            if not finite.passed:
                return
            yield (same := _verdict("a reset and the same seed give the same bytes", self._begins_anew, trial))
            yield _verdict("leaves with exit code 0 when told to stop", self._stops, trial)
        with self._trial("repetition") as trial:
            if same.passed:
                yield _verdict("a new process and the same seed give the same bytes", self._repeats, trial)
            yield _verdict("leaves when the orchestrator has gone in the middle of a step", self._leaves, trial)
        if inputs:
            with self._trial("wrong tick") as trial:
                yield _verdict("an input of the wrong tick is refused", self._refuses_wrong_tick, trial)

    @contextmanager
    def _trial(self, name: str) -> Iterator[Trial]:
        folder = self._folder / name
        folder.mkdir()
        trial = Trial(self._subject, folder, self._processes)
        try:
            yield trial
        finally:
            trial.remote.close()
            trial.wait_for_end()

    def _hello(self, trial: Trial) -> str:
        ports = trial.ports
        if not ports.outputs:
            raise RunError(NAME, None, "has no output port")
        inputs = ", ".join(f"{p.name}: {p.type.__name__}" for p in ports.inputs) or "nothing"
        outputs = ", ".join(f"{p.name}: {p.type.__name__}" for p in ports.outputs)
        return f"{ports.kind}; takes {inputs}; gives {outputs}"

    def _refuses_config(self, trial: Trial) -> str:
        try:
            trial.configure({**self._subject.config, "no_such_option": 1})
        except RunError as error:
            return str(error).partition(": ")[2]
        raise RunError(NAME, None, "took the option 'no_such_option' without a word")

    def _connects(self, trial: Trial) -> str:
        config = json.dumps(self._subject.config)
        try:
            trial.connect()
        except RunError as error:
            raise RunError(NAME, None, f"{str(error).partition(': ')[2]}; its config is {config} (--config)") from None
        return config

    def _episodes(self, trial: Trial) -> str:
        self._first = trial.episode()
        return f"{len(self._first)} messages in {TICKS} ticks"

    def _begins_anew(self, trial: Trial) -> str:
        _compare(self._first, trial.episode(), "differs from the episode before")
        return "two episodes in one process are equal"

    def _stops(self, trial: Trial) -> str:
        trial.remote.say_stop()
        if not (end := trial.wait_for_end()).clean:
            raise RunError(NAME, None, f"{end.text}{tail(trial.remote.log_of(NAME))}")
        return ""

    def _repeats(self, trial: Trial) -> str:
        _compare(self._first, trial.episode(), "differs from that of another process")
        return "two processes are equal"

    def _leaves(self, trial: Trial) -> str:
        trial.begin_step()
        trial.remote.vanish()
        trial.wait_for_end()
        if NAME in self._processes.running:
            raise RunError(NAME, None, f"still runs {LEAVE:g} s later")
        return ""

    def _refuses_wrong_tick(self, trial: Trial) -> str:
        trial.begin_step()
        trial.send_inputs(FUTURE)
        event = trial.remote.receive()
        if isinstance(event, Finished) and not event.done.ok:
            return event.done.error
        raise RunError(NAME, 0, f"stepped on inputs of tick {FUTURE} when it was asked for tick 0")


def _verdict(name: str, examine: Callable[[Trial], str], trial: Trial) -> Verdict:
    try:
        return Verdict(name=name, passed=True, detail=examine(trial))
    except (InputError, RunError) as error:
        return Verdict(name=name, passed=False, detail=str(error))


def _compare(first: list[Output], second: list[Output], difference: str) -> None:
    for a, b in zip(first, second, strict=True):
        if a != b:
            raise RunError(NAME, a.time // PERIOD, f"output '{a.port}' {difference}")
