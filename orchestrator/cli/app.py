"""The command line's frame: the application, exit codes, and how errors are told."""

from __future__ import annotations

import contextlib
import json
import signal
import sys
from collections.abc import Iterator
from typing import Any

import typer

from orchestrator.errors import InputError, RunError

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


@contextlib.contextmanager
def reporting(as_json: bool) -> Iterator[None]:
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


@contextlib.contextmanager
def terminable() -> Iterator[None]:
    """A polite kill ends the run in order, as Ctrl-C does."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)
