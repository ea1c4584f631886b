"""Draw `fundamental_diagram.png`, speed and flow over density: `python docs/images/draw_fundamental_diagram.py`.

People walk one way through a corridor 25 m long and 4 m wide with walls, whose ends are joined. Means of the speed
along it from 30 s to 60 s, over everybody. Published curves: Weidmann 1993, "Transporttechnik der Fussgaenger", in
the Kladek form; Seyfried, Steffen, Klingsch and Boltes 2005, "The fundamental diagram of pedestrian movement
revisited", for a single file, here in lanes 0.7 m apart.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from components.crowd.crowd import CrowdModel
from crowdcosim.component import make
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World

LENGTH, WIDTH = 25.0, 4.0
WORLD = World(
    size=(LENGTH, WIDTH),
    periodic=(True, False),
    walls=(Wall(start=(0.0, 0.0), end=(LENGTH, 0.0)), Wall(start=(0.0, WIDTH), end=(LENGTH, WIDTH))),
)
DENSITIES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6)
"""[1/m2]; bodies of radius 0.3 m touch each other everywhere at 3.2"""
RADIUS = 0.3
LANE = 0.7
"""[m]"""
MARKERS = {"orca": "o", "social_force": "s", "power_law": "^"}


def weidmann(density: NDArray[np.float64]) -> NDArray[np.float64]:
    """Speed at a density [m/s]."""
    return 1.34 * (1.0 - np.exp(-1.913 * (1.0 / density - 1.0 / 5.4)))


def seyfried(density: NDArray[np.float64]) -> NDArray[np.float64]:
    """Speed at a density [m/s]: a person needs 0.36 m + 1.06 s v of a lane; nobody is faster than 1.24 m/s."""
    return np.clip((1.0 / (density * LANE) - 0.36) / 1.06, 0.0, 1.24)


def places(count: int) -> NDArray[np.float64]:
    """(count, 2) staggered rows, as far apart as can be, and shaken as much as there is room [m]."""
    best = (0.0, 1, count)
    for rows in range(1, 8):
        columns = -(-count // rows)
        apart = LENGTH / columns
        if rows > 1:
            step = (WIDTH - 2 * RADIUS) / (rows - 1)
            apart = min(apart, np.hypot(apart / 2, step), 2 * step if rows > 2 else np.inf)
        best = max(best, (apart, rows, columns))
    apart, rows, columns = best
    row, column = np.divmod(np.arange(rows * columns), columns)
    x = (column + 0.5 * (row % 2)) * LENGTH / columns
    y = RADIUS + row * (WIDTH - 2 * RADIUS) / max(rows - 1, 1)
    rng = np.random.default_rng(1)
    some = np.sort(rng.permutation(rows * columns)[:count])
    shake = rng.uniform(-1, 1, (count, 2)) * max(apart - 2 * RADIUS, 0.0) / np.sqrt(8)
    position = np.column_stack([x, y])[some] + shake
    return np.column_stack([position[:, 0] % LENGTH, np.clip(position[:, 1], RADIUS, WIDTH - RADIUS)])


def mean_speed(policy: str, density: float) -> float:
    """Of everybody along the corridor [m/s]."""
    positions = places(round(density * LENGTH * WIDTH)).tolist()
    model = make(CrowdModel, {"policy": policy, "flow": "1d+", "positions": positions})
    model.reset(Setup(component="crowd", period=100_000_000, seed=1, world=WORLD))
    return float(np.mean([s.velocity[:, 0].mean() for s in [model.step(()) for _ in range(600)][300:]]))


def main() -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.2))
    smooth = np.linspace(0.05, 3.2, 200)
    for name, curve, style in (("Weidmann 1993", weidmann, "-"), ("Seyfried et al. 2005", seyfried, "--")):
        left.plot(smooth, curve(smooth), style, color="0.35", label=name)
        right.plot(smooth, smooth * curve(smooth), style, color="0.35")
    density = np.array(DENSITIES)
    for policy, marker in MARKERS.items():
        speed = np.array([mean_speed(policy, d) for d in DENSITIES])
        print(policy, *(f"{d:g}:{v:.2f}" for d, v in zip(density, speed, strict=True)))
        left.plot(density, speed, marker, markersize=5, label=policy)
        right.plot(density, density * speed, marker, markersize=5)
    left.set(xlabel="density [1/m²]", ylabel="speed [m/s]", xlim=(0, 3.2), ylim=(0, 1.5))
    right.set(xlabel="density [1/m²]", ylabel="specific flow [1/(m s)]", xlim=(0, 3.2), ylim=(0, 3.4))
    left.legend(frameon=False)
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("fundamental_diagram.png"), dpi=90)


if __name__ == "__main__":
    main()
