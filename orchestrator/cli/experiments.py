"""Commands that launch experiments."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, Literal

import typer

from orchestrator.cli.app import FAILED, app, reporting, terminable
from orchestrator.cli.options import (
    Controllers,
    Json,
    Scenario,
    Settings,
    new_folder,
    with_shortcuts,
)
from orchestrator.errors import InputError
from orchestrator.processes import Processes

PANEL = "Experiments"


@app.command(rich_help_panel=PANEL)
def run(
    scenario: Scenario = "corridor",
    controllers: Controllers = None,
    settings: Settings = None,
    seed: Annotated[int | None, typer.Option(help="Replace the scenario's seed.")] = None,
    host: Annotated[str | None, typer.Option(help="Where all Python components live: `process` or `inline`.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for log and report; by default a new one in `runs/`.")
    ] = None,
    realtime: Annotated[
        float | None,
        typer.Option(metavar="FACTOR", help="Pace: simulated seconds per second. Default: as fast as it can."),
    ] = None,
    listen: Annotated[
        str | None,
        typer.Option(metavar="ENDPOINT", help="Where `external` components attach: the scenario's `attach.listen`."),
    ] = None,
    record: Annotated[bool, typer.Option(help="Write a log and a report.")] = True,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")] = False,
) -> None:
    """Run one episode: a table of metrics, an MCAP log and a report.

    Example: `crowdcosim run corridor --controller ./mine.py:Mine --set crowd.config.count=200 --seed 7`
    """
    began = time.monotonic()
    with reporting(as_json), terminable():
        processes = Processes() if host != "inline" else None
        try:
            from orchestrator.simulation import PRELOAD

            if processes:
                processes.preload(PRELOAD)
            from orchestrator.commands.run import run_scenario

            run_scenario(
                scenario,
                controllers=controllers or [],
                settings=with_shortcuts(settings, seed, host),
                out=out or new_folder(scenario),
                real_time=realtime,
                listen=listen,
                record=record,
                as_json=as_json,
                quiet=quiet,
                processes=processes,
                began=began,
            )
        finally:
            if processes:
                processes.close()


@app.command(rich_help_panel=PANEL)
def validate(
    scenario: Scenario, controllers: Controllers = None, settings: Settings = None, as_json: Json = False
) -> None:
    """Check a scenario without running it: keys, types, components, wiring.

    Example: `crowdcosim validate ./my_scenario.yaml`
    """
    with reporting(as_json):
        from orchestrator.commands.validate import print_validation

        print_validation(scenario, controllers or [], settings or [], as_json)


@app.command(rich_help_panel=PANEL)
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors.

    Example: `crowdcosim schema > crowdcosim.schema.json`
    """
    from orchestrator.scenario.schema import schema as scenario_schema

    print(json.dumps(scenario_schema(), indent=2))


@app.command("list", rich_help_panel=PANEL)
def list_(as_json: Json = False) -> None:
    """List the shipped scenarios, robots and components.

    Example: `crowdcosim list`
    """
    with reporting(as_json):
        from orchestrator.commands.list import print_list

        print_list(as_json)


@app.command(rich_help_panel=PANEL)
def bench(
    suite: Annotated[str, typer.Argument(help="A shipped suite (`smoke`, `paper`), or a folder of scenario files.")],
    controllers: Annotated[
        str,
        typer.Option(
            "--controllers",
            "-c",
            metavar="A,B,...",
            help="Shipped ones by name, your own as `./mine.py:Mine`, or with options in a file, `./tuned.yaml`.",
        ),
    ] = "baseline,dwa,rvo",
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the tables; by default `runs/SUITE`. What is done there is not done again."),
    ] = None,
    workers: Annotated[int | None, typer.Option("--workers", "-j", help="Processes; by default one per core.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Run on a Dask cluster instead, such as tcp://host:8786.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Run every scenario with so many seeds, from its own on.")] = 1,
    settings: Settings = None,
    form: Annotated[Literal["csv", "parquet"], typer.Option("--format", help="Of the tables.")] = "csv",
    timeout: Annotated[float, typer.Option(help="Longest time for an episode, wall clock [s].")] = 600.0,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")] = False,
) -> None:
    """Run every controller in every scenario of a suite, on all cores; a sweep that was stopped goes on where it was.

    Example: `crowdcosim bench paper --controllers baseline,dwa,rvo,./mine.py:Mine`
    """
    with reporting(as_json), terminable():
        from orchestrator.benchmark.sweep import Where
        from orchestrator.commands.bench import run_bench

        chosen = {"cluster": cluster, "timeout": timeout} | ({} if workers is None else {"workers": workers})
        try:
            where = Where(**chosen)  # type: ignore[arg-type]
        except ValueError as error:
            raise InputError(f"--{error}") from None
        if not run_bench(
            suite,
            controllers=controllers,
            settings=settings or [],
            seeds=seeds,
            out=out or Path("runs") / Path(suite).name,
            form=form,
            where=where,
            as_json=as_json,
            quiet=quiet,
        ):
            raise typer.Exit(FAILED)


@app.command(rich_help_panel=PANEL)
def generate(
    suite: Annotated[str, typer.Argument(help="Such as `paper`, `robots`, `sensors`, `hard`; see docs/benchmark.md.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the files; by default one of the suite's name.")] = None,
    as_json: Json = False,
) -> None:
    """Write a suite of frozen scenario files, initial positions included: the same bytes every time.

    Example: `crowdcosim generate paper --out my_paper`
    """
    with reporting(as_json):
        from orchestrator.commands.generate import print_generation

        print_generation(suite, out or Path(suite), as_json)


@app.command(rich_help_panel=PANEL)
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a sweep, or of one run.")],
    as_json: Json = False,
) -> None:
    """Write a page about a sweep, with tables, figures, tests and the paper's claims; or about one run.

    Example: `crowdcosim report runs/paper`
    """
    with reporting(as_json):
        from orchestrator.commands.report import print_report

        print_report(folder, as_json)


@app.command(rich_help_panel=PANEL)
def ros2(
    scenario: Scenario = "corridor",
    settings: Settings = None,
    endpoint: Annotated[
        str, typer.Option(help="Router of rmw_zenoh; crowdcosim becomes it if nobody listens there.")
    ] = "tcp/127.0.0.1:7447",
    domain: Annotated[int, typer.Option(help="ROS_DOMAIN_ID.")] = 0,
    robot: Annotated[
        list[str] | None, typer.Option(help="Robot that ROS 2 drives; by default all. Repeatable.")
    ] = None,
    realtime: Annotated[
        float | None,
        typer.Option(metavar="FACTOR", help="Go on at this pace instead of waiting for a command in every step."),
    ] = None,
    first: Annotated[float, typer.Option(help="Longest wait for the first command [s].")] = 120.0,
    wait: Annotated[float, typer.Option(help="Longest wait for each further command [s].")] = 10.0,
    out: Annotated[Path | None, typer.Option(help="Folder for the log; by default none is written.")] = None,
    as_json: Json = False,
) -> None:
    """Let ROS 2 nodes drive: topics over rmw_zenoh, commands from /cmd_vel. Needs no ROS here.

    Example: `crowdcosim ros2 corridor --realtime 1`
    """
    with reporting(as_json), terminable():
        from orchestrator.commands.ros2 import serve_ros2

        serve_ros2(
            scenario,
            settings=settings or [],
            endpoint=endpoint,
            domain=domain,
            robots=robot,
            real_time=realtime,
            first=first,
            wait=wait,
            out=out,
            as_json=as_json,
        )
