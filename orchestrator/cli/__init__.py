"""The command line: launch an experiment, check a component, look into a log."""

from __future__ import annotations

import os
import sys

from orchestrator.cli import experiments, logs, parts
from orchestrator.cli.app import BAD_INPUT, DONE, FAILED, INTERRUPTED, app

__all__ = ["BAD_INPUT", "DONE", "FAILED", "INTERRUPTED", "app", "experiments", "logs", "main", "parts"]


def main() -> None:
    """Entry of the console script."""
    try:
        app()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the reader of a pipe has left
        raise SystemExit(1) from None
