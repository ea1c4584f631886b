"""Ticks per second with separate processes and inline, beside a bare Zenoh program with the same hops, in one run.

`python benchmarks/lockstep.py [SCENARIO] [TICKS]`. The bare program moves the same number of bytes along the same
edges under the same tick, and does nothing with them: what Zenoh alone costs on this machine at this moment.
"""

from __future__ import annotations

import multiprocessing
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from crowdcosim.bus import Bus
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation
from orchestrator.wiring import Graph

WARM_UP = 100


def medians(step: Callable[[int], None], ticks: int) -> tuple[float, float]:
    """Median and 99th percentile of a step [s]."""
    times = []
    for tick in range(ticks + WARM_UP):
        begin = time.perf_counter()
        step(tick)
        times.append(time.perf_counter() - begin)
    times = sorted(times[WARM_UP:])
    return statistics.median(times), times[int(0.99 * len(times))]


def lockstep(scenario: str, host: str, ticks: int) -> tuple[tuple[float, float], Graph, dict[tuple[str, str], int]]:
    """Tick time, the graph, and the size of every output [bytes]."""
    sizes: dict[tuple[str, str], int] = {}
    settings = [f"host={host}", "end.goal=none"]
    if host == "inline":
        settings += [f"{'.'.join(spec.path)}.host=inline" for spec in load(scenario).components]
    with tempfile.TemporaryDirectory() as logs:
        simulation = Simulation(load(scenario, settings), logs=Path(logs))
        simulation.lockstep.commit = lambda made: sizes.update({(c.component, c.port): len(c.payload) for c in made})
        simulation.lockstep.reset(alone=False, reference=None)
        figures = medians(simulation.lockstep.step, ticks)
        graph = simulation.graph
        simulation.close()
    return figures, graph, sizes


def bare_peer(endpoint: str, name: str, inputs: list[str], outputs: list[tuple[str, int]]) -> None:
    """Waits for the tick and its inputs, and sends as many bytes as the component would."""
    bus = Bus.connect(endpoint)
    ticks = bus.mailbox("bare/tick")
    boxes = [bus.mailbox(f"bare/{key}") for key in inputs]
    publishers = [(bus.publisher(f"bare/{key}"), bytes(size)) for key, size in outputs]
    ready = bus.publisher(f"bare/{name}/ready")
    time.sleep(1.0)
    ready.send(b"")
    while ticks.receive_unnamed()[0]:
        for mailbox in boxes:
            mailbox.receive_unnamed()
        for publisher, payload in publishers:
            publisher.send(payload, bytes(32))
    bus.close()


def bare(graph: Graph, sizes: dict[tuple[str, str], int], names: list[str], ticks: int) -> tuple[float, float]:
    """The same hops: same-tick edges are waited for in the tick, states of the tick before are there already."""
    bus = Bus.listen()
    mailbox = bus.mailbox("bare/**")
    tick = bus.publisher("bare/tick")
    peers, expected = [], 0
    for name in names:
        sources = [s for port in graph.sources[name].values() for s in port if s.component in names]
        inputs = [f"{s.component}/{s.port}" for s in sources if not s.mover]
        outputs = [(f"{name}/{o.name}", sizes.get((name, o.name), 64)) for o in graph.members[name].ports.outputs]
        expected += len(outputs)
        peers.append(
            multiprocessing.get_context("spawn").Process(target=bare_peer, args=(bus.endpoint, name, inputs, outputs))
        )
        peers[-1].start()
    for _ in names:
        mailbox.receive()

    def step(_: int) -> None:
        tick.send(b"tick")
        for _ in range(expected):
            mailbox.receive()

    figures = medians(step, ticks)
    tick.send(b"")
    for peer in peers:
        peer.join()
    bus.close()
    return figures


def main() -> None:
    scenario = sys.argv[1] if len(sys.argv) > 1 else "corridor"
    ticks = int(sys.argv[2]) if len(sys.argv) > 2 else 2000
    separate, graph, sizes = lockstep(scenario, "process", ticks)
    inline, _, _ = lockstep(scenario, "inline", ticks)
    names = [spec.name for spec in load(scenario).components if spec.host == "process"]
    transport = bare(graph, sizes, names, ticks)
    table = Table(box=box.SIMPLE_HEAD, title=f"{scenario}, {ticks} ticks, {len(names)} processes")
    for column in ("", "median [us]", "p99 [us]", "ticks/s"):
        table.add_column(column, justify="right" if column else "left")
    rows = {"separate processes": separate, "inline": inline, "bare Zenoh, same hops": transport}
    for name, (median, p99) in rows.items():
        table.add_row(name, f"{median * 1e6:.0f}", f"{p99 * 1e6:.0f}", f"{1 / median:.0f}")
    console = Console(highlight=False)
    console.print(table)
    console.print(f"separate processes / (inline + bare Zenoh) = {separate[0] / (inline[0] + transport[0]):.2f}")


if __name__ == "__main__":
    main()
