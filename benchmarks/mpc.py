"""Measure the MPC against other controllers in the paper's corridor: `python benchmarks/mpc.py --help`.

Per controller and crowd, over all seeds: runs that arrive, mean time over the time without people, mean share of time
in collision, collisions per second, and median and 99th percentile of the computing time per decision among people.
That is CPU time, because other programs on the machine should not count.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from crowdcosim.loading import load_class
from orchestrator.episode import Result, run_episode
from orchestrator.scenario import load
from orchestrator.simulation import Simulation

HEAD = ("controller", "flow", "people", "reactive", "arrived", "time", "collision", "f_c", "median", "p99")
UNITS = ("", "", "", "", "", "x free", "% of time", "1/s", "ms", "ms")


def main() -> None:
    """Print one row per controller and crowd."""
    options = arguments()
    print(line(HEAD))
    print(line(UNITS))
    for flow, people, reactive in itertools.product(options.flows, options.people, options.reactive):
        for controller in options.controllers:
            settings = [
                f"crowd.config.flow={flow}",
                f"crowd.config.count={people}",
                f"crowd.config.reactive={reactive}",
                f"robots.robot.controller.use={controller}",
                *options.set,
            ]
            decisions: list[float] = []
            results = list(episodes(settings, options.seeds, decisions))
            cells = (controller, flow, str(people), reactive, *summary(results), *percentiles(decisions))
            print(line(cells), flush=True)


def arguments() -> argparse.Namespace:
    """What to measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--controllers", nargs="+", default=["baseline", "mpc"])
    parser.add_argument("--flows", nargs="+", default=["1d-"])
    parser.add_argument("--people", nargs="+", type=int, default=[50, 200, 350])
    parser.add_argument("--reactive", nargs="+", default=["false", "true"], choices=["false", "true"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--set", nargs="+", default=[], metavar="KEY=VALUE", help="further settings of the scenario")
    return parser.parse_args()


def episodes(settings: Sequence[str], seeds: Sequence[int], decisions: list[float]) -> Iterator[Result]:
    """Runs without log, everything in this process; the CPU time of each decision [s] is added to `decisions`."""
    for seed in seeds:
        scenario = load("corridor", [*settings, "host=inline", "robots.robot.sensors.lidar=null", f"seed={seed}"])
        controller: Any = load_class(scenario.component("robot/controller").use or "")
        step, times = controller.step, list[float]()
        controller.step = timed(step, times)
        simulation = Simulation(scenario, logs=Path())
        try:
            result = run_episode(simulation, log=None)
            # The run without people comes first.
            decisions += times[-result.ticks :]
            yield result
        finally:
            simulation.close()
            controller.step = step


def timed(step: Callable[..., Any], times: list[float]) -> Callable[..., Any]:
    """`step`, which adds its CPU time [s] to `times`."""

    @wraps(step)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        began = time.thread_time()
        try:
            return step(*args, **kwargs)
        finally:
            times.append(time.thread_time() - began)

    return wrapper


def summary(results: Sequence[Result]) -> tuple[str, ...]:
    """What became of the runs of one row; one that does not arrive counts with the time it had."""
    values = [{m.name: m.value for m in result.metrics if m.value is not None} for result in results]
    return (
        f"{sum(result.outcome == 'goal' for result in results)}/{len(results)}",
        f"{np.mean([1.0 / v['time_ratio'] for v in values]):.3f}",
        f"{100.0 * np.mean([1.0 - v['colliding'] for v in values]):.1f}",
        f"{np.mean([v['collision_rate'] for v in values]):.3f}",
    )


def percentiles(decisions: Sequence[float]) -> tuple[str, ...]:
    """Median and 99th percentile [ms]."""
    return tuple(f"{1e3 * value:.2f}" for value in np.percentile(decisions, [50, 99]))


def line(cells: Sequence[str]) -> str:
    """One row of the table."""
    return "".join(f"{cell:>12}" for cell in cells)


if __name__ == "__main__":
    main()
