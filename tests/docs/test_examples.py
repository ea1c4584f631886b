"""Every example in the documentation runs as it stands."""

from __future__ import annotations

import re
import shlex
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from crowdcosim.bus import Bus
from crowdcosim.credentials import Admission, Credentials

ROOT = Path(__file__).parent.parent.parent
NAMES = ("camera", "scenarios", "controllers", "crowd", "robots", "logs", "metrics", "sensors", "benchmark", "remote")
PAGES = [ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in NAMES)]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str]]:
    return BLOCK.findall(page.read_text())


@pytest.mark.slow
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


def test_the_certificates_of_the_remote_page_let_a_component_in(tmp_path: Path) -> None:
    if shutil.which("openssl") is None:
        pytest.skip("the page makes certificates with the program `openssl`")
    (commands,) = (text for _, text in blocks(ROOT / "docs" / "remote.md") if "openssl" in text)
    subprocess.run(["sh", "-e", "-c", commands], cwd=tmp_path, capture_output=True, timeout=60, check=True)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tls/127.0.0.1:{probe.getsockname()[1]}"
    authority, server, robot = (tmp_path / f"{name}.pem" for name in ("ca", "server", "robot"))
    admission = Admission(listen=endpoint, certificate=server, key=tmp_path / "server.key", authority=authority)
    credentials = Credentials(authority=authority, certificate=robot, key=tmp_path / "robot.key")
    bus = Bus.listen(admission=admission)
    Bus.connect(endpoint, credentials=credentials).close()
    bus.close()


@pytest.mark.slow
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
