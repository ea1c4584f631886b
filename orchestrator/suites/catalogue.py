"""The suites by name: who writes each, and where the files of one are found."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from orchestrator.errors import InputError
from orchestrator.scenario.problems import near_miss
from orchestrator.scenario.shipped import names_in, scenarios_folder, suite_names
from orchestrator.suites.comparisons import crowds, robots, sensors
from orchestrator.suites.frozen import Frozen
from orchestrator.suites.hard import hard
from orchestrator.suites.paper import paper, paper_extra
from orchestrator.suites.smoke import smoke


class Generator(NamedTuple):
    """What writes a suite."""

    files: Callable[[], Iterable[Frozen]]
    description: str


GENERATORS = {
    "paper": Generator(paper, "the hundred scenarios of the paper: behaviours x densities x flows"),
    "paper-extra": Generator(paper_extra, "outside the hundred: social forces that do not react, and the robot alone"),
    "smoke": Generator(smoke, "ten of the hundred, in a minute"),
    "robots": Generator(robots, "every shipped robot in every flow"),
    "sensors": Generator(sensors, "five ways of sensing people in every flow"),
    "hard": Generator(hard, "bottleneck, crossing, T-junction, sudden stop, cut-in, queue, a group"),
    "crowds": Generator(crowds, "every crowd model in every flow"),
}


class Suite(NamedTuple):
    """A folder of scenario files."""

    name: str
    files: tuple[Path, ...]
    """in alphabetical order"""


def find_suite(reference: str) -> Suite:
    """The suite of a shipped name, or of the folder (or one file) that `reference` is the path of.

    Raises:
        InputError: if there is no such suite, or no scenario in it.
    """
    path = scenarios_folder() / reference if reference in suite_names() else Path(reference)
    if path.is_file():
        return Suite(path.stem, (path,))
    if not path.is_dir():
        known = ", ".join(suite_names())
        made = ", ".join(name for name in GENERATORS if name not in suite_names())
        raise InputError(
            f"there is no suite '{reference}'{near_miss(reference, (*suite_names(), *GENERATORS))}; shipped: {known}; "
            f"`crowdcosim generate` writes further ones ({made}); or give the path of a folder of scenario files"
        )
    files = tuple(path / f"{name}.yaml" for name in names_in(path))
    if not files:
        raise InputError(f"{path} holds no scenario: expected at least one .yaml file")
    return Suite(path.resolve().name, files)


def generator(name: str) -> Generator:
    """What writes the suite of that name.

    Raises:
        InputError: if there is none.
    """
    if name not in GENERATORS:
        known = "".join(f"\n  {n}: {g.description}" for n, g in GENERATORS.items())
        raise InputError(f"there is no generator '{name}'{near_miss(name, GENERATORS)}; there are:{known}")
    return GENERATORS[name]
