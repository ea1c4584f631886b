"""Publishes what a log recorded on Zenoh, under the keys that the run had."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import groupby

from crowdcosim.bus import Bus, BusError, Label
from orchestrator.errors import InputError
from orchestrator.log.reader import Log
from orchestrator.log.recorder import Record

EPISODE = 1


def publish(
    log: Log, run: str, *, pace: float, endpoint: str, wait: float, at: Callable[[int], None] = lambda _: None
) -> int:
    """Publish every output of the log's components, and return how many messages that were.

    Args:
        log: what to publish
        run: first part of the keys, `run/component/port`
        pace: simulated seconds per second
        endpoint: where subscribers attach
        wait: before the first message [s]
        at: is told the simulated time [ns] as it goes

    Raises:
        InputError: if the endpoint is taken, or the log has no scenario.
    """
    period = round(log.scenario()["dt"] * 1e9)
    try:
        bus = Bus.listen(endpoint)
    except BusError as error:
        raise InputError(str(error)) from None
    try:
        publishers = {
            topic: bus.publisher(f"{run}/{component}/{port}")
            for topic, (component, port) in log.places.items()
            if component
        }
        time.sleep(wait)
        sent, begin = 0, time.monotonic()
        for time_ns, records in groupby(sorted(log.records, key=_time), key=_time):
            time.sleep(max(0.0, begin + time_ns * 1e-9 / pace - time.monotonic()))
            label = Label(EPISODE, time_ns // period, time_ns).encode()
            for record in records:
                if record.topic in publishers:
                    publishers[record.topic].send(record.payload, label)
                    sent += 1
            at(time_ns)
        return sent
    finally:
        bus.close()


def _time(record: Record) -> int:
    return record.time
