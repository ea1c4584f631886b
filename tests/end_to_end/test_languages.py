"""Components in other languages, built here, proved against the protocol and run in full episodes beside their twins.

Slow: the first build takes minutes. What was built is kept in the user's cache.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import socket
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from crowdcosim.cdr import type_hash

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[2] / "examples"
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "crowdcosim"


def needed(tool: str) -> str:
    """The path of a tool without which a language cannot be tried; CI has them all."""
    found = shutil.which(tool)
    if found is None:
        if os.environ.get("CI"):
            pytest.fail(f"{tool} is missing")
        pytest.skip(f"{tool} is not installed")
    return found


@pytest.fixture(scope="session")
def rust() -> Path:
    """The folder with the programs of `examples/rust`."""
    target = CACHE / "rust"
    command = [needed("cargo"), "build", "--release", "--manifest-path", str(EXAMPLES / "rust" / "Cargo.toml")]
    built = subprocess.run(
        command, env=os.environ | {"CARGO_TARGET_DIR": str(target)}, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr
    return target / "release"


def outputs(crowdcosim, path: str, out: str, *settings: str) -> str:
    """The hash over all that a run gave."""
    outcome = crowdcosim("run", path, "--out", out, "--json", "--quiet", *settings, timeout=300)
    assert outcome.code == 0, outcome.stdout + outcome.stderr
    return outcome.json["data_hash"]


def test_the_rust_controller_and_crowd_keep_the_protocol(crowdcosim, rust: Path) -> None:
    for command in (("--config", '{"speed": 0.8}', "--", str(rust / "straight")), ("--", str(rust / "walkers"))):
        outcome = crowdcosim("check", *command)
        assert outcome.code == 0, outcome.stdout + outcome.stderr


def test_components_in_rust_give_the_bytes_of_their_python_twins(
    crowdcosim, scenario: Callable[[str], str], rust: Path
) -> None:
    path = scenario("reference: true\nend: {time_limit: 60}")
    python = [
        f"crowd.use={EXAMPLES / 'walkers.py'}:Walkers",
        "crowd.config={count: 45, speed: 1.1}",
        f"robots.robot.controller.exec=[python3, {EXAMPLES / 'plain_controller.py'}]",
    ]
    hashes = {
        outputs(crowdcosim, path, name, *(a for s in settings for a in ("--set", s)))
        for name, settings in {
            "python": python,
            "controller": [*python[:2], f"robots.robot.controller.exec=[{rust / 'straight'}]"],
            "crowd": [f"crowd.exec=[{rust / 'walkers'}]", *python[1:]],
        }.items()
    }
    assert len(hashes) == 1


def test_a_rust_controller_gets_in_where_users_are_asked_for(
    crowdcosim, scenario: Callable[[str], str], rust: Path
) -> None:
    (crowdcosim.folder / "users.txt").write_text("ann:apple\n")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    path = scenario(f"attach: {{listen: 'tcp/127.0.0.1:{port}', users: ./users.txt}}\nend: {{time_limit: 1}}")
    assert outputs(crowdcosim, path, "out", "--set", f"robots.robot.controller.exec=[{rust / 'straight'}]")


def test_a_wrong_option_is_refused_in_words(crowdcosim, scenario: Callable[[str], str], rust: Path) -> None:
    path = scenario(f"robots: {{robot: {{controller: {{exec: [{rust / 'straight'}], config: {{sped: 1}}}}}}}}")
    outcome = crowdcosim("run", path, "--out", "out", "--json")
    assert outcome.code != 0
    assert "there is no option 'sped', expected speed" in outcome.json["error"]["message"]


def test_the_examples_name_the_types_that_this_version_has() -> None:
    pattern = re.compile(r'"(\w+/msg/\w+)",\s*"(RIHS01_\w+)"')
    found = {
        match.groups()
        for file in EXAMPLES.rglob("*")
        if file.suffix in (".rs", ".py", ".java", ".c", ".cpp", ".hpp", ".h")
        for match in pattern.finditer(file.read_text())
    }
    assert len(found) >= 5
    assert {(name, type_hash(name)) for name, _ in found} == found


def test_every_example_is_a_page_or_two() -> None:
    sources = [*EXAMPLES.glob("*.py"), *(EXAMPLES / "rust" / "src" / "bin").glob("*.rs")]
    assert json.dumps({s.name: n for s in sources if (n := len(s.read_text().splitlines())) >= 150}) == "{}"
