"""`crowdcosim tracks`: who walks in the recorded tracks of a scenario, and where a robot takes the place of one."""

from __future__ import annotations

import json
import math

from rich import box
from rich.console import Console
from rich.table import Table

from components.crowd.replay import Replay, Visit
from components.crowd.tracks import TrackError
from crowdcosim.component import make
from crowdcosim.loading import load_class
from orchestrator.errors import InputError
from orchestrator.scenario.problems import near_miss
from orchestrator.scenario.scenario import load


def print_tracks(scenario: str, settings: list[str], replace: int | None, as_json: bool) -> None:
    """Print when and where the people come and go, or the scenario's lines for a robot in the place of one."""
    visits = _visits(scenario, settings)
    if replace is not None:
        visit = _visit(visits, replace)
        if as_json:
            print(json.dumps(_robot(visit)))
        else:
            print(_lines(visit), end="")
        return
    if as_json:
        print(json.dumps([visit._asdict() | {"speed": _speed(visit)} for visit in visits]))
        return
    table = Table(box=box.SIMPLE_HEAD)
    for head in ("id", "from [s]", "to [s]", "start [m]", "goal [m]", "way [m]", "speed [m/s]"):
        table.add_column(head, justify="right")
    for visit in visits:
        table.add_row(
            str(visit.id),
            f"{visit.begin:.1f}",
            f"{visit.end:.1f}",
            _point(visit.start),
            _point(visit.goal),
            f"{visit.length:.1f}",
            f"{_speed(visit):.2f}",
        )
    console = Console(highlight=False, soft_wrap=True)
    console.print(table)
    console.print(
        f"a robot in the place of one: crowdcosim tracks {scenario} --replace {visits[0].id}", style="dim", markup=False
    )


def _visits(scenario: str, settings: list[str]) -> list[Visit]:
    loaded = load(scenario, settings)
    for spec in loaded.components:
        if spec.use is not None and issubclass(cls := load_class(spec.use), Replay):
            component = make(cls, spec.config)
            assert isinstance(component, Replay), "made of a class that is"
            try:
                return component.visits()
            except TrackError as error:
                raise InputError(str(error)) from None
    raise InputError(f"scenario '{loaded.name}' has no recorded tracks: expected `crowd: {{use: replay, ...}}`")


def _visit(visits: list[Visit], number: int) -> Visit:
    for visit in visits:
        if visit.id == number:
            return visit
    hint = near_miss(number, (str(visit.id) for visit in visits))
    raise InputError(f"--replace {number}: there is nobody of that id{hint}; `crowdcosim tracks` lists all")


def _robot(visit: Visit) -> dict[str, dict[str, float]]:
    """Start and goal of a robot in the place of somebody."""
    (x, y), (gx, gy) = visit.start, visit.goal
    heading = math.atan2(gy - y, gx - x)
    places = {"start": {"x": x, "y": y, "heading": heading}, "goal": {"x": gx, "y": gy}}
    return {key: {name: round(value, 6) for name, value in place.items()} for key, place in places.items()}


def _lines(visit: Visit) -> str:
    """The same as a part of a scenario."""
    parts = {
        key: ", ".join(f"{name}: {round(value, 3)}" for name, value in part.items())
        for key, part in _robot(visit).items()
    }
    return (
        f"crowd: {{config: {{replace: {visit.id}}}}}   # who comes after {visit.begin:.1f} s and goes after "
        f"{visit.end:.1f} s\nrobots:\n  robot:\n    start: {{{parts['start']}}}\n    goal: {{{parts['goal']}}}\n"
    )


def _speed(visit: Visit) -> float:
    """Mean speed [m/s]."""
    return visit.length / (visit.end - visit.begin) if visit.end > visit.begin else 0.0


def _point(place: tuple[float, float]) -> str:
    return f"{place[0]:.2f}, {place[1]:.2f}"
