"""The process that starts all others: it imports once and forks, reports exits, and leaves no orphan.

Run as `python -m orchestrator.launcher`; one JSON object per line on stdin (orders) and stdout (events). When stdin
closes, for whatever reason, every process it started is killed with its whole group.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import json
import os
import signal
import subprocess
import sys
import traceback
from selectors import EVENT_READ, DefaultSelector
from typing import Any

_PR_SET_PDEATHSIG = 1


class Launcher:
    """Forks Python components and starts command lines; one process group each."""

    def __init__(self, orders: int, events: int) -> None:
        self._orders = orders
        self._events = events
        self._running: dict[int, str] = {}
        self._buffer = b""
        self._death, write = os.pipe()
        os.set_blocking(write, False)
        os.set_blocking(self._death, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(write, warn_on_full_buffer=False)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the orchestrator's business
        signal.signal(signal.SIGTERM, signal.SIG_IGN)

    def serve(self) -> None:
        """Obey orders until stdin closes, then kill whatever still runs."""
        selector = DefaultSelector()
        selector.register(self._orders, EVENT_READ)
        selector.register(self._death, EVENT_READ)
        try:
            while True:
                for key, _ in selector.select():
                    if key.fd == self._death:
                        os.read(self._death, 4096)
                        self._reap()
                    elif not self._read_orders():
                        return
        finally:
            self._kill_all()

    def _read_orders(self) -> bool:
        data = os.read(self._orders, 65536)
        if not data:
            return False
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        for line in lines:
            self._obey(json.loads(line))
        return True

    def _obey(self, order: dict[str, Any]) -> None:
        match order["do"]:
            case "preload":
                for module in order["modules"]:
                    with contextlib.suppress(Exception):  # the component that needs it reports the failure
                        importlib.import_module(module)
                _initialise_numba()
            case "fork":
                self._fork(order)
            case "exec":
                self._exec(order)
            case "kill":
                self._kill_all()

    def _fork(self, order: dict[str, Any]) -> None:
        pid = os.fork()
        if pid == 0:
            _become_component(order, (self._orders, self._events, self._death))
        self._running[pid] = order["component"]

    def _exec(self, order: dict[str, Any]) -> None:
        with open(order["log"], "ab") as log:
            try:
                process = subprocess.Popen(
                    order["command"],
                    cwd=order["folder"],
                    env=os.environ | order["environment"],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    process_group=0,
                    preexec_fn=_die_with_parent,
                )
            except OSError as error:
                self._tell({"component": order["component"], "failed": f"cannot start {order['command'][0]}: {error}"})
                return
        process.returncode = 0  # reaped below, not by subprocess
        self._running[process.pid] = order["component"]

    def _reap(self) -> None:
        while self._running:
            try:
                pid, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return
            if pid == 0:
                return
            if component := self._running.pop(pid, None):
                _kill_group(pid)
                self._tell({"component": component, "exit": os.waitstatus_to_exitcode(status)})

    def _kill_all(self) -> None:
        for pid in self._running:
            _kill_group(pid)

    def _tell(self, event: dict[str, Any]) -> None:
        with contextlib.suppress(BrokenPipeError):
            os.write(self._events, json.dumps(event).encode() + b"\n")


def _become_component(order: dict[str, Any], inherited: tuple[int, ...]) -> None:
    """The child's side of a fork: host the component, and never return."""
    code = 1
    try:
        os.setpgid(0, 0)
        _die_with_parent()
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        log = os.open(order["log"], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        null = os.open(os.devnull, os.O_RDONLY)
        os.dup2(null, 0)
        os.dup2(log, 1)
        os.dup2(log, 2)
        for descriptor in inherited:
            if descriptor > 2:
                os.close(descriptor)
        from crowdcosim.credentials import Credentials
        from crowdcosim.node import serve

        shown = Credentials(**order["identity"])
        code = serve(order["endpoint"], order["run"], order["component"], order["use"], shown)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _initialise_numba() -> None:
    """Run a trivial kernel: numba's first takes a second, and every process forked from here is spared it."""
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.njit("int64(int64)")(lambda number: number + 1)


def _die_with_parent() -> None:
    """Linux: be killed when the launcher is; elsewhere the launcher's own end of stdin does it."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _kill_group(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)


def main() -> None:
    """Keep stdin and stdout for orders and events; what components print must not mix with them."""
    orders, events = os.dup(0), os.dup(1)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    Launcher(orders, events).serve()


if __name__ == "__main__":
    main()
