"""Compare controllers in the paper's corridor: `python benchmarks/controllers.py --help`.

Per crowd and controller, over all seeds: runs that arrive, mean time (a run that does not arrive counts with the time
it had; without people it takes 40.1 s), mean share of time in which a person touches the robot, mean share of time in
which somebody is nearer than 0.2 m, touches per second, and median and 99th percentile of the computing time per
decision. That is CPU time, because other programs on the machine should not count.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crowdcosim.loading import load_class
from orchestrator.episode import Result, run_episode
from orchestrator.scenario.registry import SHIPPED
from orchestrator.scenario.scenario import Scenario, load
from orchestrator.simulation import Simulation

HEAD = ("flow", "people", "reactive", "controller", "arrived", "time", "touching", "< 0.2 m", "f_c", "median", "p99")
UNITS = ("", "", "", "", "", "s", "% of time", "% of time", "1/s", "ms", "ms")
CONTROLLERS = sorted(set(SHIPPED["controller"]) - {"onnx", "python_robotics"})
"""all that need no file"""
DANGER = 0.2
"""gap below which somebody is near [m]"""


class Episode(NamedTuple):
    """What one run gave."""

    result: Result
    gaps: list[float]
    """from the robot's side to the nearest person's at every step, negative in contact [m]"""
    decisions: list[float]
    """CPU time of each decision [s]"""


def main() -> None:
    """Print one row per crowd and controller."""
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
            episodes = [run(settings, seed) for seed in options.seeds]
            print(line((flow, str(people), reactive, controller, *summary(episodes))), flush=True)


def arguments() -> argparse.Namespace:
    """What to measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--controllers", nargs="+", default=CONTROLLERS)
    parser.add_argument("--flows", nargs="+", default=["1d-"])
    parser.add_argument("--people", nargs="+", type=int, default=[50, 200, 350])
    parser.add_argument("--reactive", nargs="+", default=["false", "true"], choices=["false", "true"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--set", nargs="+", default=[], metavar="KEY=VALUE", help="further settings of the scenario")
    return parser.parse_args()


def run(settings: Sequence[str], seed: int) -> Episode:
    """One run without log, everything in this process."""
    fixed = ["host=inline", "reference=false", "robots.robot.sensors.lidar=null", f"seed={seed}"]
    scenario = load("corridor", [*fixed, *settings])
    with observed(scenario) as (gaps, decisions):
        simulation = Simulation(scenario, logs=Path())
        try:
            return Episode(run_episode(simulation, log=None), gaps, decisions)
        finally:
            simulation.close()


@contextmanager
def observed(scenario: Scenario) -> Iterator[tuple[list[float], list[float]]]:
    """Lists that fill with the gaps to people [m] and the CPU times of decisions [s] while the scenario runs."""
    gaps: list[float] = []
    decisions: list[float] = []

    def watch(step: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(step)
        def wrapper(evaluator: Any, **inputs: Any) -> Any:
            crowd, robot = inputs["crowd"], inputs["robots"][0]
            d = scenario.world.displacement(robot.position, crowd.position)
            gaps.append(float(np.min(np.hypot(d[:, 0], d[:, 1]) - crowd.radius, initial=np.inf)) - robot.radius)
            return step(evaluator, **inputs)

        return wrapper

    def clock(step: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(step)
        def wrapper(*args: Any, **inputs: Any) -> Any:
            began = time.thread_time()
            try:
                return step(*args, **inputs)
            finally:
                decisions.append(time.thread_time() - began)

        return wrapper

    with ExitStack() as stack:
        for name, around in (("evaluator", watch), ("robot/controller", clock)):
            cls: Any = load_class(scenario.component(name).use or "")
            step = cls.step
            stack.callback(setattr, cls, "step", step)
            cls.step = around(step)
        yield gaps, decisions


def summary(episodes: Sequence[Episode]) -> tuple[str, ...]:
    """What became of the runs of one row."""
    values = [{m.name: m.value for m in episode.result.metrics if m.value is not None} for episode in episodes]
    decisions = np.concatenate([episode.decisions for episode in episodes])
    near = [np.mean(np.array(episode.gaps) < DANGER) for episode in episodes]
    return (
        f"{sum(episode.result.outcome == 'goal' for episode in episodes)}/{len(episodes)}",
        f"{np.mean([episode.result.simulated_time for episode in episodes]):.1f}",
        f"{100.0 * np.mean([1.0 - v['colliding'] for v in values]):.1f}",
        f"{100.0 * np.mean(near):.1f}",
        f"{np.mean([v['collision_rate'] for v in values]):.3f}",
        *(f"{1e3 * value:.2f}" for value in np.percentile(decisions, [50, 99])),
    )


def line(cells: Sequence[str]) -> str:
    """One row of the table."""
    return "".join(f"{cell:>13}" for cell in cells)


if __name__ == "__main__":
    main()
