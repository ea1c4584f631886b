"""The report of one episode: a single HTML file that needs no network."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from components.evaluator.metrics import METRICS
from crowdcosim.messages import Contacts
from orchestrator.episode import Metric
from orchestrator.log.reader import read_log
from orchestrator.report.data import EpisodeData, RobotTrack, Snapshot, Touch, read_episode

__all__ = ["EpisodeData", "RobotTrack", "Snapshot", "Touch", "render_report", "write_report"]

HARDEST = 10
"""Contacts that are listed."""

BODY_PARTS = {
    Contacts.NO_PART: "",
    Contacts.FEET: "feet",
    Contacts.LOWER_LEGS: "lower legs",
    Contacts.UPPER_LEGS: "upper legs",
    Contacts.UPPER_BODY: "upper body",
}


@dataclass(frozen=True, kw_only=True)
class MetricLine:
    """One line of the table of metrics."""

    symbol: str
    description: str
    unit: str
    better: str
    values: tuple[Metric | None, ...]
    """one per robot"""


def write_report(log: Path, target: Path) -> None:
    """Write the report of an episode's log, also of one that was cut off.

    Raises:
        InputError: if `log` is not the log of a run.
    """
    target.write_text(render_report(read_episode(read_log(log))), encoding="utf-8")


def render_report(data: EpisodeData) -> str:
    """The page; equal data give equal text."""
    # Matplotlib takes half a second to load, which a run shall not wait for before it starts.
    from orchestrator.report.figures import map_figure, time_figure

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html.jinja").render(
        data=data,
        metric_robots=_metric_robots(data.metrics),
        lines=metric_lines(data.metrics),
        map=Markup(map_figure(data)),  # our own SVG
        times=[Markup(time_figure(robot, number)) for number, robot in enumerate(data.robots, 1)],
        touches=hardest_touches(data),
        touch_count=sum(t.kind == Contacts.PERSON for robot in data.robots for t in robot.touches),
        body_parts=BODY_PARTS,
    )


def metric_lines(metrics: tuple[Metric, ...]) -> list[MetricLine]:
    """One line per metric, with a value per robot; a metric of the user's own goes by its name."""
    known = {metric.name: metric for metric in METRICS}
    cells = {(m.name, m.robot): m for m in metrics}
    lines = []
    for name in dict.fromkeys(m.name for m in metrics):
        info = known.get(name)
        values = tuple(cells.get((name, robot)) for robot in _metric_robots(metrics))
        unit = next(m.unit for m in values if m)
        lines.append(
            MetricLine(
                symbol=info.symbol if info else name,
                description=info.description if info else "",
                unit="" if unit == "1" else unit,
                better=info.direction if info and info.direction != "none" else "",
                values=values,
            )
        )
    return lines


def hardest_touches(data: EpisodeData) -> list[tuple[str, Touch]]:
    """(robot, contact) of the contacts with people that took the most energy, hardest first."""
    people = [(robot.name, t) for robot in data.robots for t in robot.touches if t.kind == Contacts.PERSON]
    return sorted(people, key=lambda item: (-item[1].energy, item[1].begin))[:HARDEST]


def _metric_robots(metrics: tuple[Metric, ...]) -> list[str]:
    return list(dict.fromkeys(m.robot for m in metrics))
