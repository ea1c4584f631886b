"""Commands for components of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.app import FAILED, app, reporting
from orchestrator.cli.options import (
    Json,
)

PANEL = "Components"

fmu = typer.Typer(help="Wheel motors as FMUs: build ours, look into yours.", no_args_is_help=True)
app.add_typer(fmu, name="fmu", rich_help_panel=PANEL)
new = typer.Typer(help="Files to start from: a controller of your own.", no_args_is_help=True)
app.add_typer(new, name="new", rich_help_panel=PANEL)


@app.command(context_settings={"ignore_unknown_options": True, "allow_interspersed_args": False}, rich_help_panel=PANEL)
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
    with reporting(as_json):
        from orchestrator.commands.check import print_check

        if not print_check(component, config, deadline, as_json):
            raise typer.Exit(FAILED)


@new.command("controller")
def new_controller(
    name: Annotated[str, typer.Argument(help="Its name, such as `polite_driver`.")],
    out: Annotated[Path, typer.Option(help="Folder for the three files.")] = Path("."),
    as_json: Json = False,
) -> None:
    """Write a controller that works, a scenario that uses it, and a test that passes: a place to start from.

    Example: `crowdcosim new controller polite_driver`
    """
    with reporting(as_json):
        from orchestrator.commands.new import print_new_controller

        print_new_controller(name, out, as_json)


@fmu.command("build")
def fmu_build(
    out: Annotated[Path, typer.Option(help="Folder for the two files.")] = Path("."), as_json: Json = False
) -> None:
    """Build the wheel drive as a co-simulation FMU of FMI 2.0 and of 3.0, with this machine's C compiler.

    Example: `crowdcosim fmu build --out fmus`
    """
    with reporting(as_json):
        from orchestrator.commands.fmu import print_build

        print_build(out, as_json)


@fmu.command("inspect")
def fmu_inspect(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An FMU of any version.")], as_json: Json = False
) -> None:
    """Describe an FMU: version, platforms, variables, and whether it can be used here.

    Example: `crowdcosim fmu inspect fmus/WheelDrive_fmi3.fmu`
    """
    with reporting(as_json):
        from orchestrator.commands.fmu import print_inspection

        print_inspection(file, as_json)
