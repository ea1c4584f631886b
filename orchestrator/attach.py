"""How components on other machines attach: the scenario's `attach`, checked, and the words that invite them."""

from __future__ import annotations

import os
import re
import socket
from pathlib import Path

from crowdcosim.credentials import Admission
from orchestrator.scenario.file import AttachEntry
from orchestrator.scenario.problems import Problem
from orchestrator.scenario.yaml_tree import Node

_ENDPOINT = re.compile(r"(tcp|tls)/(?:\[[0-9a-fA-F:.]+\]|[^\[\]/:\s]+):(\d{1,5})")
_TLS_ONLY = ("certificate", "key", "authority")


def admission_of(entry: AttachEntry | None, tree: Node, problems: list[Problem]) -> Admission | None:
    """Who is let in, with absolute paths; what the entry lacks goes to `problems`. No file is opened yet."""
    if entry is None:
        return None
    before = len(problems)

    def fault(key: str, text: str) -> None:
        problems.append(Problem(tree.nearest("attach", key).place, f"attach.{key}", text))

    match = _ENDPOINT.fullmatch(entry.listen)
    if match is None or not 0 < int(match[2]) < 65536:
        fault("listen", f"found '{entry.listen}', expected an endpoint such as tls/0.0.0.0:7450 or tcp/127.0.0.1:7450")
    elif match[1] == "tls":
        for key in ("certificate", "key"):
            if getattr(entry, key) is None:
                fault(key, f"missing: {entry.listen} needs a certificate and its private key, two PEM files")
    else:
        for key in _TLS_ONLY:
            if getattr(entry, key) is not None:
                fault(key, f"found with {entry.listen}, which is without encryption: expected tls/... in `listen`")
    if len(problems) > before:
        return None

    def path(key: str) -> Path | None:
        written = getattr(entry, key)
        folder = tree.nearest("attach", key).place.folder
        return None if written is None else Path(os.path.abspath(folder / os.path.expanduser(written)))

    return Admission(
        listen=entry.listen,
        certificate=path("certificate"),
        key=path("key"),
        authority=path("authority"),
        users=path("users"),
    )


def invitation(run: str, component: str, admission: Admission | None, loopback: str) -> str:
    """How to attach a component, for the terminal; `loopback` is where this machine's processes do."""
    options = f"--endpoint {_address(admission, loopback)} --run {run} --component {component}"
    demands = admission.demands() if admission else ""
    return f"waiting for {component} to attach: {options}{', with ' if demands else ''}{demands}"


def awaited(admission: Admission | None) -> str:
    """What an error says of a component that never came from outside."""
    if admission is None:
        return ": nobody came in at the loopback interface; components on other machines need the scenario's `attach`"
    demands = admission.demands()
    asked = f" and asked for {demands}" if demands else ""
    return (
        f": the orchestrator listened at {admission.listen}{asked}; "
        "if the component was started, what it printed says why it did not get in"
    )


def _address(admission: Admission | None, loopback: str) -> str:
    """The endpoint as another machine may write it: a wildcard address stands for this machine's name."""
    if admission is None:
        return loopback
    return re.sub(r"/(0\.0\.0\.0|\[::\]):", f"/{socket.gethostname()}:", admission.listen)
