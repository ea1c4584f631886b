"""A run from above as a film: people coloured by their speed, with their last steps; robots with their paths."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from PIL import Image

from crowdcosim.messages import Crowd
from orchestrator.pictures.map_picture import INK, STYLE, TIME_COLOURS, draw_goal, draw_robot, images, map_axes
from orchestrator.pictures.trajectories import Trajectories
from orchestrator.pictures.video import write_mp4

Pixels = NDArray[np.uint8]

TRAIL = 2.0
"""how long a step is seen [s]"""
FASTEST = 1.8
"""end of the scale of speeds [m/s]"""
COLOURS = 128
"""of a GIF"""
FORMATS = (".gif", ".mp4")


def save_film(
    run: Trajectories, path: Path, *, fps: float = 10.0, dpi: int = 80, told: Callable[[int, int], None]
) -> int:
    """Film a run in real time into a file of one of the `FORMATS`; returns the number of frames.

    Args:
        run: what to film
        path: the file
        fps: frames per second, at most one for each instant of the run
        dpi: pixels per inch
        told: called before each frame with its number and how many there are

    Raises:
        InputError: if the file cannot be written here.
    """
    chosen = _instants(run, fps)
    frames = _frames(run, chosen, dpi, told)
    (_save_gif if path.suffix == ".gif" else write_mp4)(path, frames, fps)
    return len(chosen)


def _instants(run: Trajectories, fps: float) -> NDArray[np.intp]:
    """Indices of the instants nearest to those of the frames."""
    wanted = np.arange(run.time[0], run.time[-1] + 0.5 / fps, 1 / fps)
    after = np.clip(np.searchsorted(run.time, wanted), 1, max(len(run.time) - 1, 1))
    before = after - 1
    if len(run.time) == 1:
        return np.zeros(1, np.intp)
    return np.where(wanted - run.time[before] <= run.time[after] - wanted, before, after)


def _frames(
    run: Trajectories, chosen: NDArray[np.intp], dpi: int, told: Callable[[int, int], None]
) -> Iterator[Pixels]:
    """(H, W, 3) pixels of each frame; both sides are even, as video codecs ask."""
    with matplotlib.rc_context(STYLE):
        figure, ax = map_axes(run.world)
        figure.set_dpi(dpi)
        norm = Normalize(0.0, FASTEST)
        bar = figure.colorbar(
            ScalarMappable(norm, TIME_COLOURS),
            ax=ax,
            location="bottom",
            shrink=0.3,
            aspect=40,
            pad=0.02,
            label="speed [m/s]",
        )
        bar.outline.set_visible(False)
        clock = ax.set_title("0.0 s", loc="left", fontweight="bold", color=INK)
        for robot in run.robots:
            draw_goal(ax, robot.goal, run.world)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        # Laid out once: the world must not move from frame to frame.
        figure.set_layout_engine("none")
        for number, k in enumerate(chosen):
            told(number, len(chosen))
            drawn = _draw_people(ax, run, int(k), norm)
            for robot in run.robots:
                drawn += draw_robot(ax, robot, float(run.time[k]), run.world, label=len(run.robots) > 1)
            clock.set_text(f"{run.time[k]:.1f} s")
            canvas.draw()  # type: ignore[no-untyped-call]
            pixels = np.asarray(canvas.buffer_rgba())[..., :3]  # type: ignore[no-untyped-call]
            yield pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2].copy()
            for artist in drawn:
                artist.remove()


def _draw_people(ax: Axes, run: Trajectories, k: int, norm: Normalize) -> list[Any]:
    crowd, world = run.crowd[k], run.world
    centres, index = images(crowd.position, crowd.radius, world)
    colours = TIME_COLOURS(norm(np.hypot(crowd.velocity[:, 0], crowd.velocity[:, 1])))[index]
    diameters = 2 * crowd.radius[index]
    discs = EllipseCollection(
        diameters,
        diameters,
        np.zeros(len(index)),
        units="xy",
        offsets=centres,
        offset_transform=ax.transData,
        facecolors=colours,
        edgecolors="white",
        linewidths=0.5,
        zorder=4,
    )
    way = crowd.radius[index, None] * np.column_stack([np.cos(crowd.heading[index]), np.sin(crowd.heading[index])])
    noses = LineCollection(list(np.stack([centres, centres + way], axis=1)), colors="white", linewidths=1.0, zorder=4)
    trails = LineCollection(list(_trails(run, k)), colors=INK, linewidths=0.7, alpha=0.25, zorder=3)
    drawn: list[Any] = [discs, noses, trails]
    for artist in drawn:
        ax.add_collection(artist)
        artist.set_clip_path(Rectangle((0, 0), *world.size, transform=ax.transData))
    return drawn


def _trails(run: Trajectories, k: int) -> Iterator[NDArray[np.float64]]:
    """(2, 2) pieces of the ways of those who are there at instant k."""
    begin = int(np.searchsorted(run.time, run.time[k] - TRAIL))
    for old, new in zip(run.crowd[begin:k], run.crowd[begin + 1 : k + 1], strict=True):
        a, b = _same_people(old, new)
        straight = np.hypot(*(run.world.displacement(a, b) - (b - a)).T) < 1e-9
        yield from np.stack([a, b], axis=1)[straight]


def _same_people(old: Crowd, new: Crowd) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places (N, 2) of those who are in both."""
    _, i, j = np.intersect1d(old.id, new.id, assume_unique=True, return_indices=True)
    return old.position[i], new.position[j]


def _save_gif(path: Path, frames: Iterator[Pixels], fps: float) -> None:
    pictures: list[Image.Image] = []
    for pixels in frames:
        picture = Image.fromarray(pixels)
        # One palette for all frames, that of the first: a small file, and colours that stay.
        pictures.append(
            picture.quantize(palette=pictures[0], dither=Image.Dither.NONE)
            if pictures
            else picture.quantize(COLOURS, dither=Image.Dither.NONE)
        )
    # GIFs count in hundredths of a second.
    delay = max(round(100 / fps), 2) * 10
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=delay, loop=0, optimize=False)
