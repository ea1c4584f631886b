"""The processes of a run, seen from the orchestrator: started through the launcher, watched, and gone at the end."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple


def search_path() -> str:
    """Where components' commands are looked for: first beside the running Python, as in its active environment."""
    return os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])


class Exit(NamedTuple):
    """A process that has ended, or never began."""

    component: str
    text: str
    """exit code, signal or the reason why it did not start"""
    clean: bool


class Processes:
    """The launcher and what it started. `close` ends all of them."""

    def __init__(self) -> None:
        self._launcher = subprocess.Popen(
            [sys.executable, "-m", "orchestrator.launcher"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},  # of Python components only
            bufsize=0,
            process_group=0,  # Ctrl-C reaches the orchestrator alone, which then ends the run in order
        )
        assert self._launcher.stdout is not None
        os.set_blocking(self._launcher.stdout.fileno(), False)
        self._buffer = b""
        self.running: set[str] = set()

    @property
    def events(self) -> int:
        """File descriptor that becomes readable when a process has ended."""
        assert self._launcher.stdout is not None
        return self._launcher.stdout.fileno()

    def preload(self, modules: list[str]) -> None:
        """Import modules before the first fork, so that no component has to."""
        self._order({"do": "preload", "modules": modules})

    def fork(self, component: str, use: str, *, endpoint: str, run: str, log: Path, **identity: str) -> None:
        """Host a Python component in a process of its own; `identity` is the `user` and `password` it attaches with."""
        self.running.add(component)
        self._order(
            {
                "do": "fork",
                "component": component,
                "use": use,
                "endpoint": endpoint,
                "run": run,
                "identity": identity,
                "log": str(log),
            }
        )

    def execute(
        self, component: str, command: tuple[str, ...], *, folder: Path, environment: dict[str, str], log: Path
    ) -> None:
        """Start a command line that hosts a component."""
        self.running.add(component)
        self._order(
            {
                "do": "exec",
                "component": component,
                "command": list(command),
                "folder": str(folder),
                "environment": environment | {"PATH": search_path(), "PYTHONPATH": os.environ.get("PYTHONPATH", "")},
                "log": str(log),
            }
        )

    def poll(self) -> list[Exit]:
        """The processes that have ended since the last call."""
        try:
            data = os.read(self.events, 65536)
        except BlockingIOError:
            return []
        if not data:
            lost, self.running = sorted(self.running), set()
            return [Exit(component, "the launcher of all processes has died", False) for component in lost]
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        return [self._exit(json.loads(line)) for line in lines]

    def kill(self) -> None:
        """Kill every process that still runs."""
        self._order({"do": "kill"})

    def close(self) -> None:
        """Kill what still runs and wait for the launcher to have left."""
        assert self._launcher.stdin is not None and self._launcher.stdout is not None
        if self._launcher.returncode is not None:
            return
        self.poll()
        self._launcher.stdin.close()
        if not self.running:
            self._launcher.kill()  # it may be busy importing, and has nobody to look after
        try:
            self._launcher.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._launcher.kill()
            self._launcher.wait()
        self._launcher.stdout.close()

    def _exit(self, event: dict[str, Any]) -> Exit:
        self.running.discard(event["component"])
        if "failed" in event:
            return Exit(event["component"], event["failed"], False)
        code = event["exit"]
        if code >= 0:
            return Exit(event["component"], f"its process exited with code {code}", code == 0)
        return Exit(event["component"], f"its process was killed by {signal.Signals(-code).name}", False)

    def _order(self, order: dict[str, Any]) -> None:
        assert self._launcher.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # the events' end of file tells the same
            self._launcher.stdin.write(json.dumps(order).encode() + b"\n")


def tail(log: Path, lines: int = 5) -> str:
    """The last lines that a process wrote, for an error message."""
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return ""
    last = [line for line in text.splitlines() if line.strip()][-lines:]
    return "".join(f"\n    | {line}" for line in last)
