"""Arguments and options that several commands take."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.errors import InputError

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


def with_shortcuts(settings: list[str] | None, seed: int | None, host: str | None) -> list[str]:
    shortcuts = {"seed": seed, "host": host}
    return [*(settings or []), *(f"{key}={value}" for key, value in shortcuts.items() if value is not None)]


def new_folder(scenario: str) -> Path:
    """A folder of its own in `runs/`, named by time and scenario."""
    name = f"{datetime.now():%Y-%m-%dT%H-%M-%S}_{Path(scenario).stem}"
    for suffix in ("", *(f"_{n}" for n in range(2, 1000))):
        folder = Path("runs") / f"{name}{suffix}"
        if not folder.exists():
            return folder
    raise InputError(f"runs/ holds too many folders named {name}")


def log_file(path: Path) -> Path:
    return path / "episode.mcap" if path.is_dir() else path
