"""Steps per second of the Gymnasium environment on one core: 50 people, a LiDAR of 180 beams, resets included.

`python benchmarks/gym.py [STEPS]`. Random actions. The rows leave out one thing after the other, so that one sees what
costs; the last is all in two processes. Processor time counts what this process did, whatever else the machine does.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import gymnasium
import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

import crowdcosim.gym  # registers the environment
from crowdcosim import Session

ID = "crowdcosim/Navigation-v0"
SETTINGS: dict[str, Any] = {"crowd.config.count": 50, "robots.robot.sensors.lidar.config.beams": 180}
ROWS: dict[str, dict[str, Any]] = {
    "environment": SETTINGS,
    "without the evaluator": SETTINGS | {"evaluator": None},
    "and without a LiDAR": SETTINGS | {"evaluator": None, "robots.robot.sensors.lidar": None},
}
WARM_UP = 200


def timed(step: Any, steps: int) -> tuple[float, float]:
    """Steps per second of wall-clock and of processor time."""
    for _ in range(WARM_UP):
        step()
    wall, processor = time.perf_counter(), time.process_time()
    for _ in range(steps):
        step()
    return steps / (time.perf_counter() - wall), steps / (time.process_time() - processor)


def environment(settings: dict[str, Any], steps: int) -> tuple[float, float]:
    env = gymnasium.make(ID, settings=_without(settings), disable_env_checker=True)
    env.action_space.seed(1)
    env.reset(seed=1)

    def step() -> None:
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()

    figures = timed(step, steps)
    env.close()
    return figures


def session(steps: int) -> tuple[float, float]:
    rng = np.random.default_rng(1)
    with Session("corridor", SETTINGS, commanded="robot", seed=1) as opened:

        def step() -> None:
            opened.step(rng.uniform((-0.2, -np.pi), (1.0, np.pi)))
            if opened.over:
                opened.reset(seed=int(rng.integers(2**31)))

        return timed(step, steps)


def vectorised(steps: int) -> tuple[float, float]:
    envs = gymnasium.make_vec(ID, num_envs=2, vectorization_mode="async", settings=SETTINGS)
    envs.action_space.seed(1)
    envs.reset(seed=1)
    wall, _ = timed(lambda: envs.step(envs.action_space.sample()), steps // 2)
    envs.close()
    return 2 * wall, float("nan")


def _without(settings: dict[str, Any]) -> list[str]:
    """`--set` texts; null takes a component away."""
    return [f"{key}={'null' if value is None else value}" for key, value in settings.items()]


def main() -> None:
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 3000
    assert crowdcosim.gym
    table = Table(box=box.SIMPLE_HEAD, title=f"corridor, 50 people, 180 beams, {steps} steps")
    for column in ("", "steps/s", "steps per processor second"):
        table.add_column(column, justify="right" if column else "left")
    figures = {"Session": session(steps)} | {name: environment(settings, steps) for name, settings in ROWS.items()}
    figures["AsyncVectorEnv of two"] = vectorised(steps)
    for name, (wall, processor) in figures.items():
        table.add_row(name, f"{wall:.0f}", "" if np.isnan(processor) else f"{processor:.0f}")
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
