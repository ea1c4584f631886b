"""Draws `policies.png`: fourteen people who change places across a square, with every shipped policy.

Run from the project's folder: `python docs/images/draw_policies.py`
"""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from PIL import Image

from components.crowd.config import Config
from components.crowd.crowd import CrowdModel
from components.crowd.policies import RECIPES
from crowdcosim.messages import Crowd
from crowdcosim.obstacles import Disc
from crowdcosim.setup import Setup
from crowdcosim.world import World
from orchestrator.pictures.map_picture import INK, STYLE, TIME_COLOURS, draw_discs, draw_ways, draw_world
from orchestrator.pictures.trajectories import Trajectories

PICTURE = Path(__file__).with_name("policies.png")
SECONDS = 14.0
WORLD = World(size=(12.0, 12.0), obstacles=(Disc(shape="disc", centre=(6.0, 8.3), radius=0.4),))
POLICIES = ("orca", "social_force", *(name for name in sorted(RECIPES) if name not in ("generic", "random")))
"""all that want to get somewhere"""


def places() -> tuple[np.ndarray, np.ndarray]:
    """(14, 2) starts on a circle, each a little off so that nobody meets anybody exactly, and goals across it [m]."""
    angle = np.linspace(0, 2 * np.pi, 14, endpoint=False) + np.random.default_rng(4).normal(0, 0.06, 14)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    return 6.0 + 5.0 * ring, 6.0 - 5.0 * ring


def walk(policy: str) -> Trajectories:
    """All of them with one policy."""
    start, goal = places()
    config = Config(
        policy=policy,  # type: ignore[arg-type]
        positions=tuple(map(tuple, start.tolist())),
        goals=tuple(map(tuple, goal.tolist())),
        preferred_speed=1.3,
    )
    model = CrowdModel(config)
    states: list[Crowd] = [model.reset(Setup(component="crowd", period=100_000_000, seed=1, world=WORLD))]
    states += [model.step(()) for _ in range(round(SECONDS / 0.1))]
    time = 0.1 * np.arange(len(states))
    return Trajectories(scenario="", description="", world=WORLD, time=time, crowd=tuple(states), robots=())


def draw(ax: Axes, policy: str, norm: Normalize) -> None:
    run = walk(policy)
    draw_world(ax, WORLD)
    draw_ways(ax, run, norm)
    last = run.crowd[-1]
    draw_discs(ax, last.position, last.radius, WORLD, facecolors=TIME_COLOURS(1.0))
    ax.set(xticks=[], yticks=[])
    ax.set_title(policy, fontsize=10, color=INK, family="monospace")


def main() -> None:
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(11, 9.2), layout="compressed")
        axes = figure.subplots(3, 4)
        norm = Normalize(0.0, SECONDS)
        for ax, policy in zip(axes.flat, POLICIES, strict=True):
            draw(ax, policy, norm)
        bar = figure.colorbar(
            ScalarMappable(norm, TIME_COLOURS),
            ax=axes,
            location="bottom",
            shrink=0.4,
            aspect=40,
            pad=0.02,
            label="time [s]",
        )
        bar.outline.set_visible(False)
        buffer = io.BytesIO()
        figure.savefig(buffer, dpi=110, bbox_inches="tight", pad_inches=0.05)
    # A hundred colours: a small file.
    Image.open(buffer).convert("RGB").quantize(100, dither=Image.Dither.NONE).save(PICTURE, optimize=True)


if __name__ == "__main__":
    main()
