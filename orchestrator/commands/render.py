"""`crowdcosim render`: an episode as a film or a picture."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from pathlib import Path

from PIL import Image
from pydantic import TypeAdapter
from rich.console import Console
from rich.progress import track

from orchestrator.errors import InputError
from orchestrator.log.reader import read_log
from orchestrator.pictures.cameras import Camera, named
from orchestrator.pictures.film import Film
from orchestrator.pictures.video import encoder, write_mp4
from orchestrator.scenario import extends
from orchestrator.scenario.problems import Place, Problem, ScenarioError
from orchestrator.scenario.validation import check
from orchestrator.scenario.yaml_tree import from_python

LARGEST = 8192


def render_log(
    path: Path,
    camera: str,
    settings: list[str],
    *,
    at: float | None,
    span: tuple[float, float | None, float, float],
    size: str,
    out: Path | None,
    as_json: bool,
) -> None:
    """Write a picture of the time `at`, or else a film; `span`: its start, end [s], pictures per second, and speed."""
    width, height = _size(size, even=at is None)
    if at is None:
        encoder()  # before the work, not after it
    film = Film(read_log(path))
    chosen = _with_settings(named(film.scenario.cameras, camera), settings)
    times = _times(film, span) if at is None else [_within(film, "--at", at)]
    out = out or path.with_name(f"{camera}.mp4" if at is None else f"{camera}_{at:g}s.png")
    pictures = film.pictures(chosen, times, width, height)
    if at is None:
        console = Console(stderr=True)
        shown = track(
            pictures, f"{out.name}", total=len(times), console=console, transient=True, disable=not console.is_terminal
        )
        write_mp4(out, shown, span[2])
    else:
        _write_png(out, next(pictures))
    if as_json:
        print(json.dumps({"file": str(out), "pictures": len(times), "size": [width, height], "camera": asdict(chosen)}))
    else:
        Console(highlight=False, soft_wrap=True).print(f"{out}  {width} x {height}, {len(times)} picture(s)")


def _size(text: str, *, even: bool) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if not match or not all(1 <= int(n) <= LARGEST for n in match.groups()):
        raise InputError(f"--size is '{text}', expected WIDTHxHEIGHT of 1 to {LARGEST} pixels, such as 1280x720")
    width, height = int(match[1]), int(match[2])
    if even and (width % 2 or height % 2):
        raise InputError(f"--size is '{text}', expected even numbers: a film's colours are for 2 x 2 pixels")
    return width, height


def _with_settings(camera: Camera, settings: list[str]) -> Camera:
    """The camera with some of its keys changed."""
    node = from_python(asdict(camera), Place("--set", folder=Path.cwd()))
    problems: list[Problem] = []
    adapter: TypeAdapter[Camera] = TypeAdapter(Camera)
    changed = check(adapter, extends.with_settings(node, settings), "", problems)
    if changed is None:
        raise ScenarioError(problems)
    return changed


def _times(film: Film, span: tuple[float, float | None, float, float]) -> list[float]:
    start, end, rate, speed = span
    for name, value in (("--rate", rate), ("--speed", speed)):
        if not value > 0:
            raise InputError(f"{name} is {value:g}, expected a positive number")
    start = _within(film, "--start", start)
    end = film.end if end is None else _within(film, "--end", end)
    if end < start:
        raise InputError(f"--end is {end:g}, expected at least --start, {start:g}")
    count = int((end - start) / speed * rate + 1e-9) + 1
    return [start + n * speed / rate for n in range(count)]


def _within(film: Film, name: str, time: float) -> float:
    if not 0 <= time <= film.end + 1e-9:
        raise InputError(f"{name} is {time:g}, expected from 0 to {film.end:g} s, where the episode ends")
    return time


def _write_png(path: Path, picture: object) -> None:
    try:
        Image.fromarray(picture).save(path, format="PNG")  # type: ignore[arg-type]
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from None
