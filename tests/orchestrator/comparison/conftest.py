"""A sweep of the paper's three controllers, made up so that the answers are known."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from components.evaluator.metrics import METRICS

MadeUp = Callable[..., Path]

LEVELS = {
    "baseline": {"path_length_ratio": 1.0, "time_ratio": 0.95, "colliding": 0.80, "velocity_variation_ratio": 0.2},
    "dwa": {"path_length_ratio": 0.8, "time_ratio": 0.60, "colliding": 0.85, "velocity_variation_ratio": 0.9},
    "rvo": {"path_length_ratio": 0.9, "time_ratio": 0.70, "colliding": 0.90, "velocity_variation_ratio": 0.3},
}
"""mean of a metric over all scenarios"""
COLLISIONS = {"baseline": 40, "dwa": 60, "rvo": 20}
TIME = {"baseline": 50.0, "dwa": 100.0, "rvo": 80.0}
"""of each episode [s]"""


@pytest.fixture
def sweep(tmp_path: Path) -> MadeUp:
    """Writes the tables of a sweep of 2 behaviours x 2 densities x 2 flows; `lost` scenarios are not reached by DWA."""

    def write(lost: tuple[str, ...] = (), form: str = "csv") -> Path:
        rng = np.random.default_rng(1)
        rows: list[dict[str, Any]] = []
        hits: list[dict[str, Any]] = []
        paths: list[dict[str, Any]] = []
        timing: list[dict[str, Any]] = []
        for reactive, people, flow in product((True, False), (50, 350), ("1d+", "2dx")):
            name = f"{reactive}_{flow}_{people}"
            for controller, levels in LEVELS.items():
                key = {"scenario": name, "controller": controller, "seed": 1}
                away = 0.1 if people == 50 else -0.1  # from the mean over all
                values = {metric.name: 0.5 for metric in METRICS}
                values |= {metric: level + away for metric, level in levels.items()}
                values |= {"path_length_ratio": levels["path_length_ratio"], "time": TIME[controller]}
                values |= {"proximity": 0.7 - away, "colliding": 1.0 if people == 50 else 2 * levels["colliding"] - 1}
                arrived = not (controller == "dwa" and name in lost)
                blank = {} if arrived else {"path_length_ratio": None, "velocity_variation_ratio": None}
                rows.append(
                    {"suite": "made-up", **key, "robot": "robot", "policy": "orca", "time_horizon": 0.5}
                    | {"reactive": reactive, "flow": flow, "people": people, "world_x": 50.0, "world_y": 10.0}
                    | {"density": people / 500, "outcome": "goal", "arrived": arrived, "simulated_time": 50.0}
                    | values
                    | blank
                    | {"commit": "abc", "versions": "crowdcosim=0"}
                )
                for _ in range(COLLISIONS[controller] // 4 if people == 350 else 0):
                    hit = {"time": 1.0, "agent": 1, "body_part": int(rng.integers(1, 4)), "approach_speed": 1.0}
                    hits.append({**key, "robot": "robot", **hit, "energy": rng.exponential(3.0), "x": 10.0, "y": 5.0})
                paths += [{**key, "robot": "robot", "time": float(t), "x": 5.0 + t, "y": 5.0} for t in range(40)]
                step = {"steps": 500, "mean": 1e-4, "median": 1e-4, "p99": 2e-4, "max": 3e-4}
                where = {"episode_wall_time": 1.0, "worker_peak_memory": 2**28, "platform": "Linux"}
                timing += [{**key, "component": c, **step, **where} for c in ("crowd", "robot/controller")]
        for table, content in (("results", rows), ("collisions", hits), ("paths", paths), ("timing", timing)):
            frame = pl.DataFrame(content, infer_schema_length=None)
            file = tmp_path / f"{table}.{form}"
            frame.write_csv(file) if form == "csv" else frame.write_parquet(file)
        return tmp_path

    return write
