"""The command line: launch an experiment, check a component, look into a log."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from orchestrator.errors import InputError, RunError
from orchestrator.processes import Processes

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

app = typer.Typer(
    name="crowdcosim",
    help="How does your robot behave in a human crowd? Run scenarios, swap components, look into logs.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

fmu = typer.Typer(help="Wheel motors as FMUs: build ours, look into yours.", no_args_is_help=True)
app.add_typer(fmu, name="fmu")
new = typer.Typer(help="Files to start from: a controller of your own.", no_args_is_help=True)
app.add_typer(new, name="new")

Json = Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")]
Scenario = Annotated[str, typer.Argument(help="Name of a shipped scenario, or path of a YAML file.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value, such as `crowd.config.count=200`. Repeatable."),
]
Controllers = Annotated[
    list[str] | None,
    typer.Option(
        "--controller",
        "-c",
        metavar="[ROBOT=]CONTROLLER",
        help="Drive with another one: a shipped one's name, `./mine.py:Mine`, or with options, `./tuned.yaml`. "
        "With several robots `left=dwa`, repeatable.",
    ),
]
LogFile = Annotated[Path, typer.Argument(metavar="RUN.mcap", help="The log of a run, or its folder.")]


@contextlib.contextmanager
def _reporting(as_json: bool) -> Iterator[None]:
    """Turn what went wrong into one message and an exit code."""
    try:
        yield
    except InputError as error:
        _fail(error, BAD_INPUT, as_json)
    except RunError as error:
        _fail(error, FAILED, as_json)
    except KeyboardInterrupt:
        _fail(RunError(None, None, "interrupted"), INTERRUPTED, as_json)


def _fail(error: Exception, code: int, as_json: bool) -> None:
    if as_json:
        detail: dict[str, Any] = {"message": str(error)}
        if isinstance(error, RunError):
            detail |= {"component": error.component, "tick": error.tick}
        print(json.dumps({"error": detail, "exit_code": code}))
    else:
        from rich.console import Console

        Console(stderr=True, soft_wrap=True, highlight=False).print("[bold red]error:[/] ", end="")
        print(error, file=sys.stderr)
    raise typer.Exit(code)


@app.command()
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
    with _reporting(as_json), _terminable():
        processes = Processes() if host != "inline" else None
        try:
            from orchestrator.simulation import PRELOAD

            if processes:
                processes.preload(PRELOAD)
            from orchestrator.commands.run import run_scenario

            run_scenario(
                scenario,
                controllers=controllers or [],
                settings=_with_shortcuts(settings, seed, host),
                out=out or _new_folder(scenario),
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


@app.command()
def validate(
    scenario: Scenario, controllers: Controllers = None, settings: Settings = None, as_json: Json = False
) -> None:
    """Check a scenario without running it: keys, types, components, wiring.

    Example: `crowdcosim validate ./my_scenario.yaml`
    """
    with _reporting(as_json):
        from orchestrator.commands.validate import print_validation

        print_validation(scenario, controllers or [], settings or [], as_json)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors.

    Example: `crowdcosim schema > crowdcosim.schema.json`
    """
    from orchestrator.schema import schema as scenario_schema

    print(json.dumps(scenario_schema(), indent=2))


@app.command("list")
def list_(as_json: Json = False) -> None:
    """List the shipped scenarios, robots and components.

    Example: `crowdcosim list`
    """
    with _reporting(as_json):
        from orchestrator.commands.list import print_list

        print_list(as_json)


@app.command()
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
    with _reporting(as_json), _terminable():
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


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a sweep, or of one run.")],
    as_json: Json = False,
) -> None:
    """Write a page about a sweep, with tables, figures, tests and the paper's claims; or about one run.

    Example: `crowdcosim report runs/paper`
    """
    with _reporting(as_json):
        from orchestrator.commands.report import print_report

        print_report(folder, as_json)


@app.command()
def generate(
    suite: Annotated[str, typer.Argument(help="Such as `paper`, `robots`, `sensors`, `hard`; see docs/benchmark.md.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the files; by default one of the suite's name.")] = None,
    as_json: Json = False,
) -> None:
    """Write a suite of frozen scenario files, initial positions included: the same bytes every time.

    Example: `crowdcosim generate paper --out my_paper`
    """
    with _reporting(as_json):
        from orchestrator.commands.generate import print_generation

        print_generation(suite, out or Path(suite), as_json)


@app.command()
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
    with _reporting(as_json):
        from orchestrator.commands.draw import print_drawing

        print_drawing(_log_file(log), out, begin, end, as_json)


@app.command()
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
    with _reporting(as_json):
        from orchestrator.commands.tracks import print_tracks

        print_tracks(scenario, settings or [], replace, as_json)


@app.command(context_settings={"ignore_unknown_options": True, "allow_interspersed_args": False})
def check(
    component: Annotated[
        list[str], typer.Argument(help="`package.module:Class`, `./file.py:Class`, or `-- COMMAND ARGUMENTS...`")
    ],
    config: Annotated[str, typer.Option(metavar="JSON", help="The component's config.")] = "{}",
    deadline: Annotated[float, typer.Option(help="Longest silence [s].")] = 30.0,
    as_json: Json = False,
) -> None:
    """Prove a component against the protocol: ports, determinism, finite outputs, reset, wrong tick, clean exit.

    Example: `crowdcosim check components.controllers.dwa:DWA` or `crowdcosim check -- ./my_controller --fast`
    """
    with _reporting(as_json):
        from orchestrator.commands.check import print_check

        if not print_check(component, config, deadline, as_json):
            raise typer.Exit(FAILED)


@app.command()
def inspect(log: LogFile, as_json: Json = False) -> None:
    """Summarise a log: topics, rates, duration, outcome, metrics, data hash.

    Example: `crowdcosim inspect runs/latest`
    """
    with _reporting(as_json):
        from orchestrator.commands.inspect import print_summary

        print_summary(_log_file(log), as_json)


@app.command()
def evaluate(log: LogFile, as_json: Json = False) -> None:
    """Compute the metrics of a log again; they equal those that the run gave.

    Example: `crowdcosim evaluate runs/latest/episode.mcap --json`
    """
    with _reporting(as_json):
        from orchestrator.commands.evaluate import print_evaluation

        print_evaluation(_log_file(log), as_json)


@app.command()
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
    with _reporting(as_json), _terminable():
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


@app.command()
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
    with _reporting(as_json):
        from orchestrator.commands.rerun import print_rerun

        if not print_rerun(_log_file(log), component, use, config, as_json):
            raise typer.Exit(FAILED)


@app.command()
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
    with _reporting(as_json=False):
        from orchestrator.commands.replay import publish_log

        publish_log(_log_file(log), realtime, listen, wait)


@app.command()
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
    with _reporting(as_json):
        from orchestrator.commands.render import render_log

        path = _log_file(log)
        span = (start, end, rate, speed)
        render_log(path, camera, settings or [], at=at, span=span, size=size, out=out, as_json=as_json)


@app.command()
def diff(a: LogFile, b: LogFile, as_json: Json = False) -> None:
    """Find the first tick and channel in which two logs differ.

    Example: `crowdcosim diff runs/before runs/after`
    """
    with _reporting(as_json):
        from orchestrator.commands.diff import print_differences

        if not print_differences(_log_file(a), _log_file(b), as_json):
            raise typer.Exit(FAILED)


@app.command()
def doctor(log: LogFile, as_json: Json = False) -> None:
    """Check that a log is well-formed: structure, index, checksums, types.

    Example: `crowdcosim doctor runs/latest`
    """
    with _reporting(as_json):
        from orchestrator.commands.doctor import print_faults

        if not print_faults(_log_file(log), as_json):
            raise typer.Exit(FAILED)


@app.command()
def recover(
    log: LogFile,
    out: Annotated[Path | None, typer.Option(help="File to write; by default RUN.recovered.mcap.")] = None,
    as_json: Json = False,
) -> None:
    """Save every complete chunk of a log that was cut off, with an index.

    Example: `crowdcosim recover runs/latest`
    """
    with _reporting(as_json):
        from orchestrator.commands.recover import print_recovery

        source = _log_file(log)
        print_recovery(source, out or source.with_suffix(".recovered.mcap"), as_json)


@app.command()
def export(
    log: LogFile,
    form: Annotated[str, typer.Argument(metavar="FORM", help="`rosbag2`, `csv`, `parquet` or `crowdbot`.")],
    out: Annotated[Path | None, typer.Option(help="Folder or file to write; by default beside the log.")] = None,
    as_json: Json = False,
) -> None:
    """Write a log in another form: a rosbag2 folder, tables, or the JSON of the paper's recorder.

    Example: `crowdcosim export runs/latest rosbag2`
    """
    with _reporting(as_json):
        from orchestrator.commands.export import print_export

        print_export(_log_file(log), form, out, as_json)


@new.command("controller")
def new_controller(
    name: Annotated[str, typer.Argument(help="Its name, such as `polite_driver`.")],
    out: Annotated[Path, typer.Option(help="Folder for the three files.")] = Path("."),
    as_json: Json = False,
) -> None:
    """Write a controller that works, a scenario that uses it, and a test that passes: a place to start from.

    Example: `crowdcosim new controller polite_driver`
    """
    with _reporting(as_json):
        from orchestrator.commands.new import print_new_controller

        print_new_controller(name, out, as_json)


@fmu.command("build")
def fmu_build(
    out: Annotated[Path, typer.Option(help="Folder for the two files.")] = Path("."), as_json: Json = False
) -> None:
    """Build the wheel drive as a co-simulation FMU of FMI 2.0 and of 3.0, with this machine's C compiler.

    Example: `crowdcosim fmu build --out fmus`
    """
    with _reporting(as_json):
        from orchestrator.commands.fmu import print_build

        print_build(out, as_json)


@fmu.command("inspect")
def fmu_inspect(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An FMU of any version.")], as_json: Json = False
) -> None:
    """Describe an FMU: version, platforms, variables, and whether it can be used here.

    Example: `crowdcosim fmu inspect fmus/WheelDrive_fmi3.fmu`
    """
    with _reporting(as_json):
        from orchestrator.commands.fmu import print_inspection

        print_inspection(file, as_json)


def _with_shortcuts(settings: list[str] | None, seed: int | None, host: str | None) -> list[str]:
    shortcuts = {"seed": seed, "host": host}
    return [*(settings or []), *(f"{key}={value}" for key, value in shortcuts.items() if value is not None)]


def _new_folder(scenario: str) -> Path:
    """A folder of its own in `runs/`, named by time and scenario."""
    name = f"{datetime.now():%Y-%m-%dT%H-%M-%S}_{Path(scenario).stem}"
    for suffix in ("", *(f"_{n}" for n in range(2, 1000))):
        folder = Path("runs") / f"{name}{suffix}"
        if not folder.exists():
            return folder
    raise InputError(f"runs/ holds too many folders named {name}")


def _log_file(path: Path) -> Path:
    return path / "episode.mcap" if path.is_dir() else path


@contextlib.contextmanager
def _terminable() -> Iterator[None]:
    """A polite kill ends the run in order, as Ctrl-C does."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


def main() -> None:
    """Entry of the console script."""
    try:
        app()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the reader of a pipe has left
        raise SystemExit(1) from None
