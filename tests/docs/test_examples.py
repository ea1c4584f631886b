"""Every example in the documentation runs as it stands."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent
NAMES = ("camera", "scenarios", "controllers", "crowd", "robots", "logs", "metrics", "sensors", "benchmark")
PAGES = [ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in NAMES)]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str]]:
    return BLOCK.findall(page.read_text())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_example_of_the_page_runs(page: Path, tmp_path: Path) -> None:
    ran = 0
    for language, text in blocks(page):
        if language in ("yaml", "python", "csv") and (name := re.match(r"# (\S+\.(?:yaml|py|csv))\n", text)):
            (tmp_path / name[1]).write_text(text)
        elif language == "console":
            for command in re.findall(r"^\$ crowdcosim (.*)$", text, re.MULTILINE):
                process = subprocess.run(
                    [sys.executable, "-m", "crowdcosim", *shlex.split(command)],
                    cwd=tmp_path,
                    capture_output=True,
                    text=True,
                    timeout=120,
                    check=False,
                )
                assert process.returncode == 0, f"$ crowdcosim {command}\n{process.stdout}{process.stderr}"
                ran += 1
    assert ran


def test_every_example_of_the_python_page_runs(tmp_path: Path) -> None:
    examples = [text for language, text in blocks(ROOT / "docs" / "python.md") if language == "python"]
    for text in examples:
        if name := re.match(r"# (\S+\.py)\n", text):
            (tmp_path / name[1]).write_text(text)
        process = subprocess.run(
            [sys.executable, "-W", "error", "-c", text],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert process.returncode == 0, f"{text}\n{process.stdout}{process.stderr}"
    assert examples


@pytest.mark.parametrize("page", [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")], ids=lambda page: page.name)
def test_links_within_the_project_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
        if not target.startswith(("http:", "https:")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_a_controller_takes_less_than_thirty_lines() -> None:
    (controller,) = [text for language, text in blocks(ROOT / "README.md") if language == "python"]
    assert len(controller.splitlines()) < 30
