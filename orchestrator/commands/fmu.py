"""`crowdcosim fmu`: build the wheel drive's FMU, and see what is in any."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from components.robot.fmu_build import Version, built_in, file_name
from components.robot.fmu_file import Description, FmuError, check_usable, describe, problems_of
from orchestrator.errors import InputError

_VERSIONS: tuple[Version, ...] = ("2", "3")


def print_build(folder: Path, as_json: bool) -> None:
    """Build the wheel drive as FMI 2.0 and 3.0, and put both into `folder`."""
    built: dict[str, str] = {}
    for version in _VERSIONS:
        try:
            source = built_in(version)
            folder.mkdir(parents=True, exist_ok=True)
            built[f"{version}.0"] = str(Path(shutil.copy(source, folder / file_name(version))))
        except FmuError as error:
            raise InputError(str(error)) from None
        except OSError as error:
            raise InputError(f"--out {folder}: {error.strerror}") from None
    if as_json:
        print(json.dumps({"files": built}))
        return
    console = Console(highlight=False, soft_wrap=True)
    for name, file in built.items():
        console.print(f"FMI {name}  {file}", markup=False)
    console.print(f"what is in it: crowdcosim fmu inspect {built['3.0']}", style="dim", markup=False)


def print_inspection(file: Path, as_json: bool) -> None:
    """Print version, kinds, platforms, problems and variables of an FMU."""
    try:
        about = describe(file)
    except FmuError as error:
        raise InputError(str(error)) from None
    problems = problems_of(file)
    try:
        check_usable(about)
        obstacle = None
    except FmuError as error:
        obstacle = str(error)
    if as_json:
        print(json.dumps(_as_dict(about) | {"problems": problems, "usable": obstacle is None, "obstacle": obstacle}))
        return
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"[bold]{about.model}[/]  FMI {about.fmi_version}, {' and '.join(about.kinds) or 'of no kind'}")
    for text in (about.description, f"made by {about.tool}" if about.tool else ""):
        if text:
            console.print(text, markup=False)
    sources = ", and C sources" if about.has_sources else ""
    console.print(f"platforms  {', '.join(about.platforms) or 'none'}{sources}", markup=False)
    for problem in problems:
        console.print(f"[yellow]breaks the standard[/]  {problem}")
    if obstacle:
        console.print(f"[red]cannot be used here[/]  {obstacle}")
    console.print(_variables_table(about))


def _as_dict(about: Description) -> dict[str, Any]:
    return asdict(about) | {"file": str(about.file)}


def _variables_table(about: Description) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("variable", "causality", "type", "unit"):
        table.add_column(name, no_wrap=True)
    table.add_column("start", justify="right", no_wrap=True)
    table.add_column("description")
    for v in about.variables:
        table.add_row(v.name, v.causality, v.type if v.scalar else f"{v.type}[]", v.unit, v.start, v.description)
    return table
