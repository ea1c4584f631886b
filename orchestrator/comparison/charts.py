"""The figures of a comparison; each is drawn once for the page, which colours it, and once for print."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import matplotlib
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from components.evaluator.metrics import METRICS
from crowdcosim.messages import Contacts
from orchestrator.comparison.data import Comparison
from orchestrator.comparison.statistics import summary
from orchestrator.report.figures import STYLE, WIDTH, svg

SERIES = ("#e08a1e", "#3d7fd6", "#1f9e77", "#c2569b", "#8a6fd1", "#b0413e", "#5aa9a6", "#8c7a55")
"""Colours of controllers, in their order, on white and on black; told apart by the colour-blind too."""

RADAR = (
    "time_ratio",
    "path_length_ratio",
    "velocity_variation_ratio",
    "neighbour_reaction",
    "neighbour_velocity",
    "proximity",
    "colliding",
)
"""The seven metrics in the order of the paper's table."""
RIM = 1.2
"""Values beyond this are drawn on the rim of the radar chart."""

PARTS = {
    Contacts.FEET: ("feet", 1.0),
    Contacts.LOWER_LEGS: ("lower legs", 0.72),
    Contacts.UPPER_LEGS: ("upper legs", 0.47),
    Contacts.UPPER_BODY: ("upper body", 0.25),
}
"""Body part -> its name, and how strong its colour is."""

HEAT = LinearSegmentedColormap.from_list("heat", ["#a3254f", "#e2a07b", "#f1ecdf", "#7fb3c8", "#1d5c8c"])
"""Bad to good; its ends can be told apart without red and green."""

FLOOR = "#8c97a5"
"""Of the world, at little strength: it is to be seen on white and on black."""

PRINT: Any = {
    "text.color": "#1c2127",
    "axes.edgecolor": "#c9cfd6",
    "axes.labelcolor": "#4d5661",
    "xtick.color": "#c9cfd6",
    "ytick.color": "#c9cfd6",
    "xtick.labelcolor": "#4d5661",
    "ytick.labelcolor": "#4d5661",
    "figure.facecolor": "white",
    "pdf.fonttype": 42,
}

Draw = Callable[[Comparison], Figure]


@dataclass(frozen=True, kw_only=True)
class Chart:
    """One figure, and what is said under it."""

    name: str
    """also its files'"""
    draw: Draw
    caption: str


def on_page(chart: Chart, comparison: Comparison) -> str:
    """The figure as an `<svg>` element that takes its colours from the page."""
    with matplotlib.rc_context(STYLE):
        return svg(chart.draw(comparison), chart.name)


def in_print(chart: Chart, comparison: Comparison, folder: Path) -> None:
    """The figure as PNG and PDF in `folder`; the same every time."""
    with matplotlib.rc_context({**STYLE, **PRINT}):
        figure = chart.draw(comparison)
        figure.savefig(folder / f"{chart.name}.png", dpi=160, bbox_inches="tight", metadata={"Software": None})
        nothing = {"CreationDate": None, "Creator": None, "Producer": None}
        figure.savefig(folder / f"{chart.name}.pdf", bbox_inches="tight", metadata=nothing)


def charts(comparison: Comparison) -> list[Chart]:
    """The figures that these episodes have something for."""
    found = [RADAR_CHART]
    if not comparison.tables["collisions"].is_empty():
        found.append(ENERGY_CHART)
    if comparison.crossed:
        found += [_heat("colliding"), _heat("time_ratio")]
    found.append(INTERVAL_CHART)
    if chosen_paths(comparison):
        found.append(PATH_CHART)
    return found


def colours(comparison: Comparison) -> dict[str, str]:
    """Controller -> its colour."""
    return {name: SERIES[i % len(SERIES)] for i, name in enumerate(comparison.controllers)}


# --- radar -----------------------------------------------------------------------------------------------------------


def _radar(comparison: Comparison) -> Figure:
    parts = {"a)  all densities": comparison}
    if comparison.crossed:
        parts["b)  low density"] = comparison.low
    figure = Figure(figsize=(WIDTH, 5.0 if len(parts) > 1 else 6.0), layout="constrained")
    axes = figure.subplots(1, len(parts), subplot_kw={"projection": "polar"}, squeeze=False)[0]
    for ax, (title, part) in zip(axes, parts.items(), strict=True):
        _draw_radar(ax, part)
        ax.set_title(title, loc="left", fontsize=10, fontweight="bold", pad=18)
    _legend(figure, comparison)
    return figure


def _draw_radar(ax: Any, comparison: Comparison) -> None:
    muted, line = matplotlib.rcParams["axes.labelcolor"], matplotlib.rcParams["axes.edgecolor"]
    symbols = {metric.name: metric.symbol for metric in METRICS}
    angles = np.linspace(0, 2 * np.pi, len(RADAR), endpoint=False)
    around = np.append(angles, angles[0])
    for name, colour in colours(comparison).items():
        means = [summary(comparison.values(name, metric)) for metric in RADAR]
        radii = np.array([min(m.mean, RIM) if m else 0.0 for m in means])
        ax.plot(around, np.append(radii, radii[0]), color=colour, linewidth=2.0, label=name, zorder=3)
        ax.fill(around, np.append(radii, radii[0]), color=colour, alpha=0.06, linewidth=0)
        ax.plot(angles, radii, linestyle="none", marker="o", markersize=4, color=colour, zorder=4)
    ax.set_theta_offset(np.pi / 2)
    ax.set_theta_direction(-1)
    ax.set_ylim(0, RIM)
    ax.set_xticks(angles, [symbols[metric] for metric in RADAR], fontsize=10)
    ax.tick_params(axis="x", pad=8)
    ax.set_yticks([0.25, 0.5, 0.75, 1.0], ["", "0.5", "", "1"], fontsize=8, color=muted)
    ax.set_rlabel_position(180 / len(RADAR))
    ax.grid(color=line, linewidth=0.7)
    ax.spines["polar"].set_visible(False)
    ax.plot(np.linspace(0, 2 * np.pi, 200), np.ones(200), color=muted, linewidth=0.9, linestyle=(0, (4, 3)), zorder=2)


RADAR_CHART = Chart(
    name="radar",
    draw=_radar,
    caption="The paper's seven metrics, means over the scenarios; outward is better, but for Prox., which says "
    "how near people come. The dashed circle is 1: as good as the robot alone, or no effect on people, or"
    " no collision. Values beyond 1.2 are drawn at the rim.",
)

# --- energy ----------------------------------------------------------------------------------------------------------


def _energy(comparison: Comparison) -> Figure:
    names = comparison.controllers
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    axes = figure.subplots(1, len(names), sharex=True, sharey=True, squeeze=False)[0]
    greatest = max((float(e.max()) for n in names if len(e := comparison.energies(n))), default=1.0)
    edges = np.linspace(0, np.ceil(greatest), 31)
    for ax, (name, colour) in zip(axes, colours(comparison).items(), strict=True):
        collisions = comparison.collisions(name)
        below = np.zeros(len(edges) - 1)
        for part, (label, strength) in PARTS.items():
            energies = collisions.filter(pl.col("body_part") == part)["energy"].to_numpy()
            if not len(energies):
                continue
            count, _ = np.histogram(energies, edges)
            ax.bar(
                edges[:-1], count, np.diff(edges), bottom=below, align="edge", color=colour, alpha=strength, label=label
            )
            below += count
        ax.set_title(f"{name}: {len(collisions)} collisions", fontsize=10, fontweight="bold", loc="left")
        ax.set_xlabel("energy of a collision [J]")
        _plain(ax)
        if len(collisions):
            ax.legend(frameon=False, fontsize=8, title="part touched", title_fontsize=8)
    axes[0].set_ylabel("collisions")
    axes[0].set_ylim(bottom=0)
    return figure


ENERGY_CHART = Chart(
    name="energy",
    draw=_energy,
    caption="How hard the collisions with people are: energy that a collision may absorb, by the part of the body that "
    "the robot touches.",
)

# --- heat maps -------------------------------------------------------------------------------------------------------


def _heat(metric: str) -> Chart:
    symbol = next(m.symbol for m in METRICS if m.name == metric)
    return Chart(
        name=f"heat_{metric}",
        draw=lambda comparison: _heat_map(comparison, metric, symbol),
        caption=f"{symbol} by density (people in the corridor, upward), flow (1D+ with the robot, 1D- against it, 1Dx "
        "both; 2D and 2Dx across its way) and behaviour of the crowd. A ring marks episodes in which the "
        "robot did not arrive.",
    )


def _heat_map(comparison: Comparison, metric: str, symbol: str) -> Figure:
    results = comparison.results
    behaviours = [b for b in dict.fromkeys(results["behaviour"].to_list()) if b]
    flows, people = sorted(results["flow"].unique().to_list()), sorted(results["people"].unique().to_list())
    names = comparison.controllers
    figure = Figure(figsize=(WIDTH, 1.5 * len(names) + 0.9), layout="constrained")
    axes = figure.subplots(len(names), len(behaviours), squeeze=False, sharex=True, sharey=True)
    norm = Normalize(0.0, 1.0)
    for row, name in zip(axes, names, strict=True):
        for ax, behaviour in zip(row, behaviours, strict=True):
            rows = comparison.of(name).filter(pl.col("behaviour") == behaviour)
            _draw_cells(ax, rows, metric, flows, people, norm)
        row[0].set_ylabel(name, fontsize=10, fontweight="bold", color=matplotlib.rcParams["text.color"])
    for ax, behaviour in zip(axes[0], behaviours, strict=True):
        ax.set_title(behaviour.replace(", ", "\n"), fontsize=9, loc="left")
    figure.set_layout_engine("constrained", wspace=0.04, hspace=0.04)
    bar = figure.colorbar(ScalarMappable(norm, HEAT), ax=axes, shrink=0.6, aspect=30, pad=0.01, label=symbol)
    bar.outline.set_visible(False)
    return figure


def _draw_cells(
    ax: Axes, rows: pl.DataFrame, metric: str, flows: Sequence[str], people: Sequence[int], norm: Normalize
) -> None:
    cells = np.full((len(people), len(flows)), np.nan)
    missed = []
    means = rows.group_by("people", "flow").agg(pl.col(metric).mean(), pl.col("arrived").cast(pl.Float64).mean())
    for count, flow, value, arrived in means.iter_rows():
        i, j = people.index(count), flows.index(flow)
        cells[i, j] = np.nan if value is None else value
        if arrived < 1:
            missed.append((j, i))
    ax.pcolormesh(cells, cmap=HEAT, norm=norm, edgecolors=matplotlib.rcParams["axes.facecolor"], linewidth=0)
    for i, j in zip(*np.nonzero(np.isfinite(cells)), strict=True):
        dark = abs(norm(cells[i, j]) - 0.5) > 0.32
        text = f"{cells[i, j]:.2f}".removeprefix("0")
        ax.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=7, color="#ffffff" if dark else "#1c2127")
    if missed:
        x, y = np.array(missed).T + 0.5
        ax.plot(x, y, linestyle="none", marker="o", markersize=19, markerfacecolor="none", markeredgecolor="#1c2127")
    ax.set_xticks(np.arange(len(flows)) + 0.5, [flow.upper().replace("X", "x") for flow in flows], fontsize=7)
    ax.set_yticks(np.arange(len(people)) + 0.5, [str(count) for count in people], fontsize=7)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)


# --- intervals -------------------------------------------------------------------------------------------------------

INTERVALS = (
    *RADAR,
    "collision_rate",
    "collision_energy_rate",
    "near_collision_share",
    "danger",
    "time_to_collision_min",
)


def _intervals(comparison: Comparison) -> Figure:
    known = {metric.name: metric for metric in comparison.metrics}
    shown = [known[name] for name in INTERVALS if name in known]
    columns = 4
    rows = -(-len(shown) // columns)
    names = comparison.controllers
    figure = Figure(figsize=(WIDTH, rows * (0.26 * len(names) + 0.75)), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharey=True)
    for ax, metric in zip(axes.flat, shown, strict=False):
        for place, (name, colour) in enumerate(colours(comparison).items()):
            if found := summary(comparison.values(name, metric.name)):
                ax.plot([found.low, found.high], [place, place], color=colour, linewidth=3.0, solid_capstyle="round")
                ax.plot([found.mean], [place], marker="o", markersize=7, color=colour)
        arrow = {"higher": " →", "lower": " ←"}.get(metric.direction, "")
        unit = "" if metric.unit == "1" else f" [{metric.unit}]"
        ax.set_title(f"{metric.symbol}{unit}{arrow}", fontsize=9.5, loc="left", fontweight="bold")
        ax.set_yticks(range(len(names)), names)
        ax.set_ylim(len(names) - 0.4, -0.6)
        ax.margins(x=0.12)
        ax.locator_params(axis="x", nbins=4)
        _plain(ax, axis="x")
    for ax in axes.flat[len(shown) :]:
        ax.set_axis_off()
    figure.set_layout_engine("constrained", wspace=0.06, hspace=0.06)
    return figure


INTERVAL_CHART = Chart(
    name="intervals",
    draw=_intervals,
    caption="Means over the scenarios with their 95% confidence intervals (bootstrap). The arrow says which way "
    "is better.",
)

# --- paths -----------------------------------------------------------------------------------------------------------


def chosen_paths(comparison: Comparison) -> list[str]:
    """The scenarios whose paths are shown: per flow the densest with most collisions; else the first six."""
    if comparison.tables["paths"].is_empty():
        return []
    if not comparison.crossed:
        return list(dict.fromkeys(comparison.results["scenario"].to_list()))[:6]
    chosen = []
    for flow in sorted(comparison.results["flow"].unique().to_list()):
        rows = comparison.results.filter(pl.col("flow") == flow)
        rows = rows.filter(pl.col("people") == rows["people"].max())
        worst = rows.group_by("scenario").agg(pl.col("collision_rate").sum()).sort("collision_rate", "scenario")
        chosen.append(str(worst["scenario"][-1]))
    return chosen


def _paths(comparison: Comparison) -> Figure:
    scenarios = chosen_paths(comparison)
    sizes = [_world(comparison, scenario) for scenario in scenarios]
    panels = [0.93 * WIDTH * min(width / length, 0.6) for length, width in sizes]
    figure = Figure(figsize=(WIDTH, sum(panel + 0.3 for panel in panels) + 0.5), layout="constrained")
    axes = figure.subplots(len(scenarios), 1, squeeze=False, height_ratios=panels)[:, 0]
    for ax, scenario, (length, width) in zip(axes, scenarios, sizes, strict=True):
        ax.add_patch(Rectangle((0, 0), length, width, facecolor=FLOOR, alpha=0.12, linewidth=0, zorder=0))
        _draw_paths(ax, comparison, scenario)
        ax.set(xlim=(0, length), ylim=(0, width), aspect="equal")
        ax.set_title(scenario, fontsize=9, loc="left")
    axes[-1].set_xlabel("x [m]")
    _legend(figure, comparison)
    return figure


def _draw_paths(ax: Axes, comparison: Comparison, scenario: str) -> None:
    for name, colour in colours(comparison).items():
        rows = comparison.tables["paths"].filter((pl.col("scenario") == scenario) & (pl.col("controller") == name))
        for _, points in rows.group_by("seed", "robot", maintain_order=True):
            ax.plot(points["x"].to_numpy(), points["y"].to_numpy(), color=colour, linewidth=1.5, alpha=0.9)
        if not comparison.tables["collisions"].is_empty():
            hits = comparison.collisions(name).filter(pl.col("scenario") == scenario)
            ax.plot(
                hits["x"].to_numpy(),
                hits["y"].to_numpy(),
                linestyle="none",
                marker="o",
                markersize=4,
                color=colour,
                alpha=0.45,
                markeredgewidth=0,
            )
    ax.set_ylabel("y [m]")
    ax.spines[:].set_visible(False)
    ax.tick_params(length=0)


def _world(comparison: Comparison, scenario: str) -> tuple[float, float]:
    """Extent of a scenario's world [m]."""
    row = comparison.results.filter(pl.col("scenario") == scenario)
    return float(row["world_x"][0]), float(row["world_y"][0])


PATH_CHART = Chart(
    name="paths",
    draw=_paths,
    caption="Paths of the robots in chosen episodes, from left to right; dots are collisions with people. Chosen:"
    " of each flow, the densest scenario with the most collisions.",
)


def _legend(figure: Figure, comparison: Comparison) -> None:
    handles = [
        matplotlib.lines.Line2D([], [], color=colour, linewidth=2.5, label=name)
        for name, colour in colours(comparison).items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=10)


def _plain(ax: Axes, axis: Literal["x", "y"] = "y") -> None:
    ax.grid(axis=axis, color=matplotlib.rcParams["axes.edgecolor"], linewidth=0.5)
    ax.set_axisbelow(True)
    ax.spines[["top", "right", "left"]].set_visible(False)
    ax.tick_params(axis="both", length=0)
