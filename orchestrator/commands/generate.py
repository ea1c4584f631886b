"""`crowdcosim generate`: write a suite of frozen scenario files."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from orchestrator.errors import InputError
from orchestrator.suites.catalogue import generator
from orchestrator.suites.frozen import write


def print_generation(name: str, out: Path, as_json: bool) -> None:
    """Write the suite into the folder `out` and say how many files it has."""
    files = generator(name).files()
    try:
        written = write(files, out)
    except OSError as error:
        raise InputError(f"--out {out}: {error.strerror}") from None
    if as_json:
        print(json.dumps({"suite": name, "files": [str(path) for path in written]}))
        return
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"{len(written)} scenarios in {out}", markup=False)
    console.print(f"run them: crowdcosim bench {out} --controllers baseline,dwa,rvo", style="dim", markup=False)
