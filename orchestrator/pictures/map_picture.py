"""A run from above in one picture: everybody's way, coloured by time; world, robots and goals."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle
from numpy.typing import NDArray

from crowdcosim.robots import Target
from crowdcosim.world import World
from orchestrator.pictures.trajectories import RobotPath, Trajectories

Floats = NDArray[np.float64]

INK, MUTED, FLOOR, SOLID = "#222222", "#808080", "#f6f5f2", "#c9c6c0"
ROBOT = "#d55e00"
"""vermilion: apart from every colour of `TIME_COLOURS` for all kinds of colour vision (Okabe and Ito 2008)"""
TIME_COLOURS: Colormap = LinearSegmentedColormap.from_list(
    "time", matplotlib.colormaps["viridis"](np.linspace(0.0, 0.82, 64))
)
"""early to late; without the light end, which is not seen on a light floor"""
LONGEST, LARGEST = 12.0, 64.0
"""a map's longer side is at most this long [inch], its area at most this large [inch2]"""
STYLE: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "crowdcosim",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.color": INK,
    "axes.labelcolor": MUTED,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "figure.facecolor": "white",
}
Point = tuple[float, float]
FORMATS = (".png", ".svg", ".pdf")


def save_picture(run: Trajectories, path: Path, *, dpi: int = 150) -> None:
    """Draw a run into a file of one of the `FORMATS`."""
    with matplotlib.rc_context(STYLE):
        figure, ax = map_axes(run.world)
        norm = Normalize(float(run.time[0]), max(float(run.time[-1]), float(run.time[0]) + 1e-9))
        draw_ways(ax, run, norm)
        last = run.crowd[-1]
        draw_discs(ax, last.position, last.radius, run.world, facecolors=TIME_COLOURS(1.0), alpha=0.9)
        for robot in run.robots:
            draw_goal(ax, robot.goal, run.world)
            draw_robot(ax, robot, float(run.time[-1]), run.world, label=len(run.robots) > 1)
        bar = figure.colorbar(
            ScalarMappable(norm, TIME_COLOURS),
            ax=ax,
            location="bottom",
            shrink=0.4,
            aspect=40,
            pad=0.02,
            label="time [s]",
        )
        bar.outline.set_visible(False)
        ax.set_title(run.description or run.scenario, loc="left", fontsize=9.0, color=INK, parse_math=False, wrap=True)
        nothing = {"Date": None} if path.suffix == ".svg" else {"CreationDate": None} if path.suffix == ".pdf" else {}
        figure.savefig(path, dpi=dpi, bbox_inches="tight", pad_inches=0.1, metadata=nothing)


def map_axes(world: World) -> tuple[Figure, Axes]:
    """A figure with the world in it."""
    width, height = world.size
    scale = min(LONGEST / max(width, height), (LARGEST / (width * height)) ** 0.5)
    figure = Figure(figsize=(max(width * scale, 3.0), max(height * scale, 1.0) + 1.0), layout="compressed")
    ax = figure.subplots()
    draw_world(ax, world)
    return figure, ax


def draw_world(ax: Axes, world: World) -> None:
    """Floor, walls, obstacles, and dashed edges where it wraps around."""
    x, y = world.size
    margin = 0.012 * max(x, y)
    ax.set(xlim=(-margin, x + margin), ylim=(-margin, y + margin), aspect="equal")
    ax.add_patch(Rectangle((0, 0), x, y, facecolor=FLOOR, linewidth=0, zorder=0))
    for outline in world.outlines:
        ax.add_patch(Polygon(outline.tolist(), facecolor=SOLID, edgecolor=INK, linewidth=1.0, zorder=2))
    edges: dict[int, list[tuple[Point, Point]]] = {
        0: [((0, 0), (0, y)), ((x, 0), (x, y))],
        1: [((0, 0), (x, 0)), ((0, y), (x, y))],
    }
    for axis, periodic in enumerate(world.periodic):
        for (ax0, ay0), (bx0, by0) in edges[axis] if periodic else ():
            ax.plot([ax0, bx0], [ay0, by0], color=MUTED, linewidth=0.8, linestyle=(0, (4, 4)), zorder=2)
    for wall in world.walls:
        ends = np.array([wall.start, wall.end])
        colour, thickness = (INK, 1.8) if wall.stops_people else (MUTED, 1.0)
        ax.plot(ends[:, 0], ends[:, 1], color=colour, linewidth=thickness, solid_capstyle="round", zorder=2)
    ax.spines[:].set_visible(False)
    ax.tick_params(length=2)


def draw_ways(ax: Axes, run: Trajectories, norm: Normalize) -> None:
    """Everybody's way, piece by piece in the colour of its time; ways of one world's crossing many are thinner."""
    count = max(len(crowd.id) for crowd in run.crowd)
    thickness = float(np.clip(1.8 - 0.25 * np.log2(max(count, 1) / 4), 0.5, 1.8))
    for _, time, place in run.ways():
        pieces, middle = [], []
        for begin, end in unbroken(
            time, place, run.world, float(np.median(np.diff(run.time))) if len(run.time) > 1 else 1.0
        ):
            pieces += [place[k : k + 2] for k in range(begin, end - 1)]
            middle += [0.5 * (time[k] + time[k + 1]) for k in range(begin, end - 1)]
        if pieces:
            colours = TIME_COLOURS(norm(np.array(middle)))
            ax.add_collection(
                LineCollection(pieces, colors=colours, linewidths=thickness, capstyle="round", alpha=0.85, zorder=3)
            )


def unbroken(time: Floats, place: Floats, world: World, step: float) -> Iterator[tuple[int, int]]:
    """Begin and end of the parts of a way (K, 2) that neither jump across the seam nor leave time out."""
    d = np.diff(place, axis=0)
    jump = np.hypot(*(world.displacement(place[:-1], place[1:]) - d).T) > 1e-9
    breaks = np.flatnonzero(jump | (np.diff(time) > 1.5 * step)) + 1
    for part in np.split(np.arange(len(time)), breaks):
        if len(part) > 1:
            yield int(part[0]), int(part[-1]) + 1


def images(position: Floats, radius: Floats, world: World) -> tuple[Floats, NDArray[np.intp]]:
    """Centres (M, 2) of discs and of their images that reach across a seam, and the index of each one's original."""
    shifts = [
        (i, j) for i in ((0, -1, 1) if world.periodic[0] else (0,)) for j in ((0, -1, 1) if world.periodic[1] else (0,))
    ]
    size = np.asarray(world.size)
    centres, index = [], []
    for shift in shifts:
        moved = position + size * shift
        seen = ((moved > -radius[:, None]) & (moved < size + radius[:, None])).all(axis=1) | (shift == (0, 0))
        centres.append(moved[seen])
        index.append(np.flatnonzero(seen))
    return np.concatenate(centres), np.concatenate(index)


def draw_discs(ax: Axes, position: Floats, radius: Floats, world: World, **style: Any) -> None:
    """Bodies of people, at both sides of a seam that they stand on."""
    centres, index = images(position, radius, world)
    diameters = 2 * radius[index]
    discs = EllipseCollection(
        diameters,
        diameters,
        np.zeros(len(index)),
        units="xy",
        offsets=centres,
        offset_transform=ax.transData,
        **({"edgecolors": "white", "linewidths": 0.5, "zorder": 4} | style),
    )
    ax.add_collection(discs)
    discs.set_clip_path(Rectangle((0, 0), *world.size, transform=ax.transData))


def draw_goal(ax: Axes, goal: Target, world: World) -> None:
    """A dashed line or circle."""
    dashes = (0, (4, 3))
    if any(goal.direction):
        across = (goal.x - goal.direction[1], goal.y + goal.direction[0])
        line = ax.axline((goal.x, goal.y), across, color=ROBOT, linewidth=1.0, linestyle=dashes, zorder=1)
        line.set_clip_path(Rectangle((0, 0), *world.size, transform=ax.transData))
    else:
        ax.add_patch(
            Circle(
                (goal.x, goal.y), goal.tolerance, fill=False, edgecolor=ROBOT, linewidth=1.0, linestyle=dashes, zorder=1
            )
        )


def draw_robot(ax: Axes, robot: RobotPath, until: float, world: World, *, label: bool) -> list[Any]:
    """Its path up to a time and itself at that time; returns what was drawn."""
    last = int(np.searchsorted(robot.time, until + 1e-9, side="right"))
    if not last:
        return []
    step = float(np.median(np.diff(robot.time))) if len(robot.time) > 1 else 1.0
    drawn: list[Any] = []
    for begin, end in unbroken(robot.time[:last], robot.position[:last], world, step):
        x, y = robot.position[begin:end].T
        # A white casing lifts it from the people's ways.
        drawn += ax.plot(x, y, color="white", linewidth=4.2, solid_capstyle="round", zorder=5)
        drawn += ax.plot(x, y, color=ROBOT, linewidth=2.2, solid_capstyle="round", zorder=6)
    x0, y0 = robot.position[last - 1]
    heading = robot.heading[last - 1]
    # Larger than life where the world is large: a robot of 0.18 m in a hall of 50 m would not be seen.
    radius = max(robot.radius, 0.006 * max(world.size))
    drawn.append(ax.add_patch(Circle((x0, y0), radius, facecolor=ROBOT, edgecolor="white", linewidth=0.8, zorder=7)))
    nose = (x0 + 1.8 * radius * np.cos(heading), y0 + 1.8 * radius * np.sin(heading))
    drawn += ax.plot([x0, nose[0]], [y0, nose[1]], color=ROBOT, linewidth=1.8, solid_capstyle="round", zorder=7)
    if label:
        drawn.append(
            ax.annotate(
                robot.name, (x0, y0), (0, 8), textcoords="offset points", ha="center", parse_math=False, zorder=8
            )
        )
    return drawn
