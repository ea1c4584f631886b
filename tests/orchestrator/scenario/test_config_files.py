"""Files that options name are found from the file that names them, wherever crowdcosim is started."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.scenario.config_files import files_in
from orchestrator.scenario.scenario import load

OWN = """
from dataclasses import dataclass
from crowdcosim import Controller
from crowdcosim.messages import LaserScan, Twist

@dataclass(frozen=True, kw_only=True)
class Config:
    model: str = "built-in"
    more: tuple[str, ...] = ()

class Own(Controller):
    def __init__(self, config: Config) -> None: ...
    def step(self, scan: LaserScan) -> Twist: ...
"""


@pytest.fixture
def two_folders(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`lib/driven.yaml` extends `base.yaml`, `own.yaml` extends that one; we are somewhere else."""
    (folder / "lib").mkdir()
    (folder / "lib" / "own.py").write_text(OWN)
    (folder / "lib" / "driven.yaml").write_text(
        "extends: ../base.yaml\n"
        "robots: {robot: {controller: {use: './own.py:Own', inputs: {},\n"
        "  config: {model: ./net.bin, more: [../a, b]}}}}\n"
    )
    (folder / "own.yaml").write_text(
        "extends: lib/driven.yaml\nrobots: {robot: {controller: {config: {more: [./c.py:C]}}}}\n"
    )
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    return folder


def test_a_path_counts_from_the_file_that_says_it(two_folders: Path) -> None:
    config = load("../lib/driven.yaml").component("robot/controller").config
    assert config == {"model": f"{two_folders}/lib/net.bin", "more": [f"{two_folders}/a", "b"]}
    config = load("../own.yaml").component("robot/controller").config
    assert config == {"model": f"{two_folders}/lib/net.bin", "more": [f"{two_folders}/c.py:C"]}


def test_a_path_on_the_command_line_counts_from_here(two_folders: Path) -> None:
    scenario = load("../own.yaml", ["robots.robot.controller.config.model=./mine.bin"])
    assert scenario.component("robot/controller").config["model"] == f"{two_folders}/elsewhere/mine.bin"


def test_a_resolved_scenario_names_the_same_files_in_any_folder(
    two_folders: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = load("../own.yaml")
    monkeypatch.chdir(two_folders)
    assert load(scenario.resolved) == scenario


def test_options_of_a_command_line_in_any_language_are_resolved_too(two_folders: Path) -> None:
    (two_folders / "run.yaml").write_text(
        "extends: base.yaml\nrobots: {robot: {controller: {exec: [ls], inputs: {}, config: {net: ./net.bin}}}}\n"
    )
    assert load("../run.yaml").component("robot/controller").config == {"net": f"{two_folders}/net.bin"}


def test_files_are_those_that_there_are(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("")
    here = str(tmp_path)
    config = {"one": f"{here}/a.py", "two": [f"{here}/a.py:A"], "three": {"x": f"{here}/b"}, "four": 4, "five": here}
    assert list(files_in(config)) == [tmp_path / "a.py"] * 2
