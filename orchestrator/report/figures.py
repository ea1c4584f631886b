"""The figures of an episode's report, as SVG that takes its colours from the page, light or dark."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from crowdcosim.messages import Contacts
from crowdcosim.robots import Target
from crowdcosim.world import World
from orchestrator.report.data import EpisodeData, RobotTrack, Snapshot

PAGE_COLOURS = {
    "ink": "#010101",
    "muted": "#010102",
    "line": "#010103",
    "floor": "#010104",
    "person": "#010105",
    "accent": "#010106",
    "contact": "#010107",
}
"""Stand-ins, replaced by the page's CSS variables of these names; no figure draws anything else in them."""
INK, MUTED, LINE, FLOOR, PERSON, ACCENT, CONTACT = PAGE_COLOURS.values()

SPEED_COLOURS = LinearSegmentedColormap.from_list("speed", ["#d9821a", "#9d8aa5", "#2f74d0"])
"""Slow to fast; of middling lightness, to be seen on white and on black, and without red and green."""
SPEED_LEVELS = 10

WIDTH = 10.0
"""Width of every figure [inch]"""

STYLE: Any = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.color": INK,
    "axes.edgecolor": LINE,
    "axes.facecolor": "none",
    "axes.labelcolor": MUTED,
    "axes.linewidth": 0.8,
    "xtick.color": LINE,
    "ytick.color": LINE,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "figure.facecolor": "none",
}


def map_figure(data: EpisodeData) -> str:
    """The world from above at every snapshot: walls, people, and each robot's path up to then, coloured by speed."""
    instants = data.snapshots or (
        Snapshot(time=data.duration, position=np.zeros((0, 2)), heading=np.zeros(0), radius=np.zeros(0)),
    )
    width, height = data.world.size
    columns = 1 if height < 0.45 * width else 2 if height < 1.3 * width else 4
    columns = min(columns, len(instants))
    rows = -(-len(instants) // columns)
    with matplotlib.rc_context(STYLE):
        panel = WIDTH / columns * height / width
        figure = Figure(figsize=(WIDTH, rows * (panel + 0.3) + 0.7), layout="compressed")
        axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        norm = _speed_norm(data)
        for ax, instant in zip(axes.flat, instants, strict=False):
            _draw_world(ax, data.world)
            _draw_people(ax, instant)
            for robot in data.robots:
                _draw_goal(ax, robot.goal, data.world)
                _draw_path(ax, robot, instant.time, data.world, norm)
                _draw_touches(ax, robot, instant.time)
                _draw_robot(ax, robot, instant.time, label=len(data.robots) > 1)
            ax.annotate(
                f"{instant.time:.1f} s", (0, height), (0, 5), textcoords="offset points", color=INK, fontweight="bold"
            )
        for ax in axes.flat[len(instants) :]:
            ax.set_axis_off()
        if data.robots:
            bar = figure.colorbar(
                ScalarMappable(norm, SPEED_COLOURS),
                ax=axes,
                location="bottom",
                shrink=0.3,
                aspect=40,
                pad=0.01,
                label="robot's speed [m/s]",
            )
            bar.outline.set_visible(False)
        return svg(figure, "map")


def time_figure(robot: RobotTrack, number: int) -> str:
    """One robot over time: speed, turn rate and distance to the nearest person, shaded while a person touches it."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
        axes = figure.subplots(3, 1, sharex=True)
        rows = (
            ("speed [m/s]", robot.speed),
            ("turn rate [rad/s]", robot.angular_velocity),
            ("nearest person [m]", robot.nearest),
        )
        spans = [(t.begin, t.end - t.begin) for t in robot.touches if t.kind == Contacts.PERSON]
        for ax, (label, values) in zip(axes, rows, strict=True):
            ax.broken_barh(spans, (0, 1), transform=ax.get_xaxis_transform(), color=CONTACT, alpha=0.3, linewidth=0)
            finite = np.where(np.isfinite(values), values, np.nan)
            ax.plot(robot.time, finite, color=ACCENT, linewidth=1.2)
            if robot.arrival is not None:
                ax.axvline(robot.arrival, color=MUTED, linewidth=0.8, linestyle=(0, (3, 3)))
            ax.set_ylabel(label)
            ax.grid(axis="y", color=LINE, linewidth=0.5)
            ax.set_axisbelow(True)
            ax.spines[["top", "right", "left"]].set_visible(False)
            ax.tick_params(axis="y", length=0)
            ax.margins(x=0, y=0.12)
        axes[2].set_ylim(bottom=0)
        if not np.isfinite(robot.nearest).any():
            axes[2].set_yticks([])
            axes[2].text(0.5, 0.5, "nobody", transform=axes[2].transAxes, color=MUTED, ha="center", va="center")
        axes[2].set_xlabel("time [s]")
        figure.align_ylabels(axes)
        return svg(figure, f"time{number}")


def _speed_norm(data: EpisodeData) -> BoundaryNorm:
    fastest = max((float(np.abs(r.speed).max(initial=0.0)) for r in data.robots), default=0.0)
    tenths = max(np.ceil(round(10 * fastest, 6)), 1.0)
    return BoundaryNorm(np.linspace(0.0, tenths / 10, SPEED_LEVELS + 1), SPEED_COLOURS.N)


def _draw_world(ax: Axes, world: World) -> None:
    x, y = world.size
    margin = 0.012 * max(x, y)
    ax.set(xlim=(-margin, x + margin), ylim=(-margin, y + margin), aspect="equal")
    ax.fill([0, x, x, 0], [0, 0, y, y], color=FLOOR, linewidth=0, zorder=0)
    for wall in world.walls:
        ends = np.array([wall.start, wall.end])
        colour, thickness = (INK, 1.8) if wall.stops_people else (MUTED, 1.0)
        ax.plot(ends[:, 0], ends[:, 1], color=colour, linewidth=thickness, solid_capstyle="round", zorder=2)
    ax.spines[:].set_visible(False)
    ax.tick_params(length=2)


def _draw_people(ax: Axes, instant: Snapshot) -> None:
    if not len(instant.position):
        return
    # One shape per centimetre of radius, placed many times: a small file.
    centimetres = instant.radius.round(2)
    for radius in np.unique(centimetres):
        discs = EllipseCollection(
            [2 * radius],
            [2 * radius],
            [0],
            units="xy",
            offsets=instant.position[centimetres == radius],
            offset_transform=ax.transData,
            facecolors=PERSON,
            linewidths=0,
            alpha=0.35,
            zorder=1,
        )
        ax.add_collection(discs)
    noses = instant.position + instant.radius[:, None] * np.column_stack(
        [np.cos(instant.heading), np.sin(instant.heading)]
    )
    gap = np.full(len(noses), np.nan)
    ax.plot(
        np.column_stack([instant.position[:, 0], noses[:, 0], gap]).ravel(),
        np.column_stack([instant.position[:, 1], noses[:, 1], gap]).ravel(),
        color=PERSON,
        linewidth=0.7,
        zorder=1,
    )


def _draw_goal(ax: Axes, goal: Target, world: World) -> None:
    dashes = (0, (4, 3))
    if any(goal.direction):
        across = (goal.x - goal.direction[1], goal.y + goal.direction[0])
        line = ax.axline((goal.x, goal.y), across, color=MUTED, linewidth=0.8, linestyle=dashes, zorder=1)
        line.set_clip_path(Rectangle((0, 0), *world.size, transform=ax.transData))
    else:
        disc = Circle((goal.x, goal.y), goal.tolerance, fill=False, edgecolor=MUTED, linewidth=0.8, linestyle=dashes)
        ax.add_patch(disc)


def _draw_path(ax: Axes, robot: RobotTrack, until: float, world: World, norm: BoundaryNorm) -> None:
    last = int(np.searchsorted(robot.time, until, side="right"))
    pieces, levels = [], []
    for piece, level in _pieces(robot.position[:last], np.abs(robot.speed[:last]), world, norm):
        pieces.append(piece)
        levels.append(level)
    if pieces:
        colours = SPEED_COLOURS(np.array(levels))
        ax.add_collection(LineCollection(pieces, colors=colours, linewidths=2.0, capstyle="round", zorder=3))


def _pieces(
    position: NDArray[np.float64], speed: NDArray[np.float64], world: World, norm: BoundaryNorm
) -> Iterator[tuple[NDArray[np.float64], int]]:
    """The path cut where the speed's level changes or the robot crosses the seam: few long lines, a small file."""
    if len(position) < 2:
        return
    levels = np.atleast_1d(norm(0.5 * (speed[1:] + speed[:-1])))
    step = np.diff(position, axis=0)
    jump = np.hypot(*(world.displacement(position[:-1], position[1:]) - step).T) > 1e-9
    begin = 0
    for k in range(1, len(levels) + 1):
        if k == len(levels) or levels[k] != levels[begin] or jump[k] or jump[begin]:
            if not jump[begin]:
                yield position[begin : k + 1], int(levels[begin])
            begin = k


def _draw_touches(ax: Axes, robot: RobotTrack, until: float) -> None:
    begun = [t for t in robot.touches if t.begin < until]
    for person, marker, colour, size in ((True, "o", CONTACT, 6.5), (False, "x", MUTED, 4.0)):
        places = np.array([t.position for t in begun if (t.kind == Contacts.PERSON) == person]).reshape(-1, 2)
        ax.plot(
            places[:, 0],
            places[:, 1],
            linestyle="none",
            marker=marker,
            markersize=size,
            markerfacecolor="none",
            markeredgecolor=colour,
            markeredgewidth=1.3,
            zorder=4,
        )


def _draw_robot(ax: Axes, robot: RobotTrack, time: float, *, label: bool) -> None:
    k = int(np.searchsorted(robot.time, time, side="right")) - 1
    if k < 0:
        return
    x, y = robot.position[k]
    # Larger than life where the world is large: a robot of 0.18 m in a hall of 50 m would not be seen.
    radius = max(robot.radius, 0.006 * float(np.ptp(ax.get_xlim())))
    ax.add_patch(Circle((x, y), radius, facecolor=ACCENT, edgecolor=FLOOR, linewidth=0.8, zorder=5))
    nose = (x + 2 * radius * np.cos(robot.heading[k]), y + 2 * radius * np.sin(robot.heading[k]))
    ax.plot([x, nose[0]], [y, nose[1]], color=ACCENT, linewidth=1.6, solid_capstyle="round", zorder=5)
    if label:
        ax.annotate(
            robot.name, (x, y), (0, 7), textcoords="offset points", ha="center", color=INK, parse_math=False, zorder=6
        )


def svg(figure: Figure, name: str) -> str:
    """The figure as an `<svg>` element; `name` keeps its ids apart from those of the page's other figures."""
    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name}):
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        figure.savefig(buffer, format="svg", bbox_inches="tight", pad_inches=0.05, metadata=nothing)
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{name}-", text)
    for variable, colour in PAGE_COLOURS.items():
        text = text.replace(colour, f"var(--{variable})")
    return re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', 'role="img"', text, count=1)
