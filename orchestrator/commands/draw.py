"""`crowdcosim draw`: a run from above, as a picture or a film."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from orchestrator.errors import InputError
from orchestrator.log.reader import read_log
from orchestrator.pictures import map_film, map_picture
from orchestrator.pictures.trajectories import Trajectories, read_trajectories


def print_drawing(log: Path, out: Path | None, begin: float | None, end: float | None, as_json: bool) -> None:
    """Draw a log into `out`, by default beside it, and say where that is."""
    out = out or log.parent / "trajectories.png"
    if out.suffix not in (*map_picture.FORMATS, *map_film.FORMATS):
        known = ", ".join((*map_picture.FORMATS, *map_film.FORMATS))
        raise InputError(f"--out {out}: found '{out.suffix}', expected a name that ends in one of {known}")
    run = read_trajectories(read_log(log)).within(begin, end)
    frames = None
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        if out.suffix in map_film.FORMATS:
            frames = _film(run, out, quiet=as_json)
        else:
            map_picture.save_picture(run, out)
    except OSError as error:
        raise InputError(f"--out {out}: {error.strerror or error}") from None
    if as_json:
        print(json.dumps({"file": str(out), "from": run.time[0], "to": run.time[-1], "frames": frames}))
    else:
        Console(highlight=False, soft_wrap=True).print(str(out), markup=False)


def _film(run: Trajectories, out: Path, *, quiet: bool) -> int:
    with Progress(transient=True, disable=quiet) as progress:
        task = progress.add_task("frames", total=None)
        return map_film.save_film(
            run, out, told=lambda number, count: progress.update(task, completed=number, total=count)
        )
