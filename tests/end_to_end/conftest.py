"""The command line as a user has it: real processes, real Zenoh, and a look at what is left behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
MARK = "CROWDCOSIM_TEST_MARK"


@dataclass(frozen=True)
class Outcome:
    """What a command left."""

    code: int
    stdout: str
    stderr: str

    @property
    def json(self) -> dict[str, Any]:
        return json.loads(self.stdout)


class Terminal:
    """Runs `crowdcosim` in a folder of its own; its processes can be told from all others."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._mark = uuid.uuid4().hex
        self.environment = os.environ | {MARK: self._mark, "COLUMNS": "120"}

    def start(
        self, *arguments: str, module: str = "crowdcosim", within: Sequence[str] = (), **environment: str
    ) -> subprocess.Popen[str]:
        """`within` is a command that runs it in another place, such as `ip netns exec NAME`."""
        return subprocess.Popen(
            [*within, sys.executable, "-m", module, *arguments],
            cwd=self.folder,
            env=self.environment | environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # A background job of a script ignores Ctrl-C; what it starts here must not inherit that.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )

    def __call__(self, *arguments: str, timeout: float = 120.0) -> Outcome:
        with self.start(*arguments) as process:
            try:
                stdout, stderr = process.communicate(timeout=timeout)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
        return Outcome(process.returncode, stdout, stderr)

    def left(self, grace: float = 5.0) -> list[str]:
        """Command lines of our processes that still run `grace` seconds later."""
        until = time.monotonic() + grace
        while (found := self.running()) and time.monotonic() < until:
            time.sleep(0.05)
        return found

    def running(self) -> list[str]:
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    if f"{MARK}={self._mark}".encode() in (entry / "environ").read_bytes():
                        command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
                        found.append(f"{entry.name} {command}")
                except OSError:
                    continue
        return [line for line in found if line.partition(" ")[2]]  # a zombie has no command line


@pytest.fixture
def crowdcosim(tmp_path: Path) -> Iterator[Terminal]:
    if not Path("/proc/self/environ").exists():
        pytest.skip("finding processes that are left behind needs /proc")
    terminal = Terminal(tmp_path)
    yield terminal
    assert terminal.left() == []


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[[str], str]:
    """Writes a scenario that extends a small, quick corridor; gives its path."""

    def write(text: str = "", name: str = "small") -> str:
        path = tmp_path / f"{name}.yaml"
        path.write_text(f"extends: {HERE / 'small.yaml'}\nname: {name}\n{text}")
        return str(path)

    return write
