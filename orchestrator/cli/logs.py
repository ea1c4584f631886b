"""Commands that look into logs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.app import FAILED, app, reporting
from orchestrator.cli.options import (
    Json,
    LogFile,
    Scenario,
    Settings,
    log_file,
)

PANEL = "Logs and pictures"


@app.command(rich_help_panel=PANEL)
def inspect(log: LogFile, as_json: Json = False) -> None:
    """Summarise a log: topics, rates, duration, outcome, metrics, data hash.

    Example: `crowdcosim inspect runs/latest`
    """
    with reporting(as_json):
        from orchestrator.commands.inspect import print_summary

        print_summary(log_file(log), as_json)


@app.command(rich_help_panel=PANEL)
def evaluate(log: LogFile, as_json: Json = False) -> None:
    """Compute the metrics of a log again; they equal those that the run gave.

    Example: `crowdcosim evaluate runs/latest/episode.mcap --json`
    """
    with reporting(as_json):
        from orchestrator.commands.evaluate import print_evaluation

        print_evaluation(log_file(log), as_json)


@app.command(rich_help_panel=PANEL)
def rerun(
    log: LogFile,
    component: Annotated[str, typer.Argument(help="Its name in the scenario, such as `robot/controller`.")],
    use: Annotated[str | None, typer.Option(help="Another class in its place, such as `./mine.py:Mine`.")] = None,
    config: Annotated[str | None, typer.Option(metavar="JSON", help="Other options than it had.")] = None,
    as_json: Json = False,
) -> None:
    """Run one component again on the recorded outputs of the others, in this process: to debug it alone.

    Example: `crowdcosim rerun runs/latest robot/controller` or `python -m pdb -m crowdcosim rerun ...`
    """
    with reporting(as_json):
        from orchestrator.commands.rerun import print_rerun

        if not print_rerun(log_file(log), component, use, config, as_json):
            raise typer.Exit(FAILED)


@app.command(rich_help_panel=PANEL)
def replay(
    log: LogFile,
    realtime: Annotated[float, typer.Option(metavar="FACTOR", help="Pace: simulated seconds per second.")] = 1.0,
    listen: Annotated[
        str, typer.Option(metavar="ENDPOINT", help="Where subscribers attach; loopback only by default.")
    ] = "tcp/127.0.0.1:7447",
    wait: Annotated[float, typer.Option(help="Before the first message, for subscribers to attach [s].")] = 1.0,
) -> None:
    """Publish a log on Zenoh at its pace, under the keys of the run.

    Example: `crowdcosim replay runs/latest --realtime 2`
    """
    with reporting(as_json=False):
        from orchestrator.commands.replay import publish_log

        publish_log(log_file(log), realtime, listen, wait)


@app.command(rich_help_panel=PANEL)
def diff(a: LogFile, b: LogFile, as_json: Json = False) -> None:
    """Find the first tick and channel in which two logs differ.

    Example: `crowdcosim diff runs/before runs/after`
    """
    with reporting(as_json):
        from orchestrator.commands.diff import print_differences

        if not print_differences(log_file(a), log_file(b), as_json):
            raise typer.Exit(FAILED)


@app.command(rich_help_panel=PANEL)
def doctor(log: LogFile, as_json: Json = False) -> None:
    """Check that a log is well-formed: structure, index, checksums, types.

    Example: `crowdcosim doctor runs/latest`
    """
    with reporting(as_json):
        from orchestrator.commands.doctor import print_faults

        if not print_faults(log_file(log), as_json):
            raise typer.Exit(FAILED)


@app.command(rich_help_panel=PANEL)
def recover(
    log: LogFile,
    out: Annotated[Path | None, typer.Option(help="File to write; by default RUN.recovered.mcap.")] = None,
    as_json: Json = False,
) -> None:
    """Save every complete chunk of a log that was cut off, with an index.

    Example: `crowdcosim recover runs/latest`
    """
    with reporting(as_json):
        from orchestrator.commands.recover import print_recovery

        source = log_file(log)
        print_recovery(source, out or source.with_suffix(".recovered.mcap"), as_json)


@app.command(rich_help_panel=PANEL)
def export(
    log: LogFile,
    form: Annotated[str, typer.Argument(metavar="FORM", help="`rosbag2`, `csv`, `parquet` or `crowdbot`.")],
    out: Annotated[Path | None, typer.Option(help="Folder or file to write; by default beside the log.")] = None,
    as_json: Json = False,
) -> None:
    """Write a log in another form: a rosbag2 folder, tables, or the JSON of the paper's recorder.

    Example: `crowdcosim export runs/latest rosbag2`
    """
    with reporting(as_json):
        from orchestrator.commands.export import print_export

        print_export(log_file(log), form, out, as_json)


@app.command(rich_help_panel=PANEL)
def draw(
    log: LogFile,
    out: Annotated[
        Path | None,
        typer.Option(help="A .png, .svg or .pdf, or a film: .gif or .mp4. By default trajectories.png beside the log."),
    ] = None,
    begin: Annotated[float | None, typer.Option("--from", metavar="SECONDS", help="Leave out what was before.")] = None,
    end: Annotated[float | None, typer.Option("--to", metavar="SECONDS", help="Leave out what came after.")] = None,
    as_json: Json = False,
) -> None:
    """Draw a run from above: everybody's way coloured by time, or a film of it.

    Example: `crowdcosim draw runs/latest --out crowd.gif --to 20`
    """
    with reporting(as_json):
        from orchestrator.commands.draw import print_drawing

        print_drawing(log_file(log), out, begin, end, as_json)


@app.command(rich_help_panel=PANEL)
def render(
    log: LogFile,
    camera: Annotated[
        str, typer.Option(help="Of the scenario's `cameras`, or fixed, following, top_down, robot.")
    ] = "following",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change the camera, such as `distance=6`. Repeatable."),
    ] = None,
    at: Annotated[float | None, typer.Option(metavar="TIME", help="One picture (PNG) of this time [s].")] = None,
    start: Annotated[float, typer.Option(help="Where the film begins [s].")] = 0.0,
    end: Annotated[float | None, typer.Option(help="Where it ends [s]; by default with the episode.")] = None,
    rate: Annotated[float, typer.Option(help="Pictures per second of the film.")] = 25.0,
    speed: Annotated[float, typer.Option(help="Simulated seconds per second of the film.")] = 1.0,
    size: Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="[pixels]")] = "1280x720",
    out: Annotated[Path | None, typer.Option(help="File to write; by default beside the log.")] = None,
    as_json: Json = False,
) -> None:
    """Make a film (mp4) or a picture (PNG) of an episode from its log.

    Example: `crowdcosim render runs/latest --camera robot` or `crowdcosim render runs/latest --at 12.5`
    """
    with reporting(as_json):
        from orchestrator.commands.render import render_log

        path = log_file(log)
        span = (start, end, rate, speed)
        render_log(path, camera, settings or [], at=at, span=span, size=size, out=out, as_json=as_json)


@app.command(rich_help_panel=PANEL)
def tracks(
    scenario: Scenario,
    settings: Settings = None,
    replace: Annotated[
        int | None, typer.Option(metavar="ID", help="Print the lines of a robot that takes this person's place.")
    ] = None,
    as_json: Json = False,
) -> None:
    """List the people of recorded tracks: when and where each comes and goes.

    Example: `crowdcosim tracks examples/replay.yaml --replace 3`
    """
    with reporting(as_json):
        from orchestrator.commands.tracks import print_tracks

        print_tracks(scenario, settings or [], replace, as_json)
