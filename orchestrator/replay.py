"""Runs a component again on what a log recorded of the others."""

from __future__ import annotations

import json
from typing import Any

from crowdcosim.component import make
from crowdcosim.host import ComponentHost, Source
from crowdcosim.loading import load_class
from crowdcosim.message import Message
from crowdcosim.messages import Metrics
from orchestrator.component_specs import ComponentSpec
from orchestrator.errors import InputError
from orchestrator.log import Log
from orchestrator.scenario import Scenario, from_resolved
from orchestrator.simulation import setup_of


class Recorded:
    """The outputs of a log by the tick that they hold."""

    def __init__(self, log: Log, period: int) -> None:
        self._log = log
        self._period = period
        self._outputs: dict[tuple[str, str], dict[int, Any]] = {}

    def read(self, source: Source, tick: int) -> Message:
        """The message of a source that holds `tick`.

        Raises:
            InputError: if the log does not have it.
        """
        place = (source.component, source.port)
        if place not in self._outputs:
            self._outputs[place] = {t // self._period: m for t, m in self._log.outputs(*place)}
        try:
            message: Message = self._outputs[place][tick]
        except KeyError:
            raise InputError(
                f"{self._log.path} holds no message of {source.component}.{source.port} for tick {tick}"
            ) from None
        return message


def evaluate(log: Log) -> Metrics:
    """The metrics of a log, computed again by the evaluator of its scenario.

    Raises:
        InputError: if the log has no scenario, no evaluator, or is incomplete.
    """
    scenario = from_resolved(log.scenario())
    spec = _evaluator(log, scenario)
    ticks = log.metadata.get("outcome", {}).get("ticks")
    if ticks is None or not log.complete:
        raise InputError(f"{log.path} was cut off: metrics need a complete run")
    host = ComponentHost(
        make(load_class(spec.use or ""), spec.config),
        every=spec.every,
        wiring=log.wiring()[spec.name],
        setup=setup_of(scenario, spec.name, spec.robot, spec.every),
    )
    recorded = Recorded(log, scenario.period)
    host.reset(alone=False, reference=json.loads(log.attachments["reference.json"]))
    last = int(ticks)
    for tick in range(0, last, spec.every):
        host.step(tick, recorded.read)
    metrics = host.finish(last, recorded.read)["metrics"]
    assert isinstance(metrics, Metrics)
    return metrics


def _evaluator(log: Log, scenario: Scenario) -> ComponentSpec:
    for spec in scenario.components:
        if spec.name == "evaluator" and spec.use is not None:
            return spec
    raise InputError(f"{log.path}: its scenario has no evaluator in Python")
