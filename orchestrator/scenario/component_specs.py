"""The components of a scenario: their slots in the file, and what each is, checked down to its own options."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pydantic import TypeAdapter

from crowdcosim.component import ComponentError, config_adapter
from orchestrator.processes import search_path
from orchestrator.scenario.config_files import with_absolute_paths
from orchestrator.scenario.file import (
    ComponentEntry,
    ControllerEntry,
    SensorEntry,
    component_adapter,
    controller_adapter,
    sensor_adapter,
)
from orchestrator.scenario.problems import Problem, key_path
from orchestrator.scenario.registry import Family, component_class, import_string
from orchestrator.scenario.validation import check
from orchestrator.scenario.yaml_tree import Node
from orchestrator.wiring import Reference

Host = Literal["process", "inline", "external", "exec"]


_ADAPTERS: Mapping[Family, Callable[[], TypeAdapter[Any]]] = {
    "sensor": sensor_adapter,
    "controller": controller_adapter,
}
"""of what may stand for a component of these families, other than a `ComponentEntry`"""


class Slot(NamedTuple):
    """A place for a component in a scenario."""

    name: str
    robot: str | None
    family: Family
    path: tuple[str, ...]

    @property
    def adapter(self) -> TypeAdapter[Any]:
        """Validator of what may stand there."""
        return _ADAPTERS.get(self.family, component_adapter)()


@dataclass(frozen=True, kw_only=True)
class ComponentSpec:
    """One component of a scenario."""

    name: str
    """`crowd`, `evaluator`, `ROBOT` (its drive), `ROBOT/SENSOR` or `ROBOT/controller`"""
    robot: str | None
    """whose it is, None for the crowd and the evaluator"""
    host: Host
    use: str | None
    """import string; None if `exec`, or if `external` and of no class that we know"""
    exec: tuple[str, ...] = ()
    """command line of an `exec` component, empty for others"""
    cwd: Path | None = None
    """absolute folder in which the command line runs"""
    every: int
    config: Mapping[str, Any]
    """every option as plain data, the defaults filled in where the class is known"""
    inputs: Mapping[str, Reference] = field(default_factory=dict)
    latency: float | Literal["measured"] = 0.0
    """of a controller: how long after its tick a command takes effect [s]"""
    entry: Mapping[str, Any] = field(compare=False, repr=False)
    """as the resolved scenario writes it"""
    path: tuple[str, ...] = field(compare=False, repr=False)
    node: Node = field(compare=False, repr=False)

    def problem(self, text: str, *keys: str) -> Problem:
        """Something wrong with this component, placed where the scenario writes it, or its `keys`."""
        return Problem(self.node.nearest(*keys).place, key_path((*self.path, *keys)), text)


def slots(tree: Node) -> Iterator[Slot]:
    """Every component that a scenario names, in canonical order."""
    for slot in _all_slots(tree):
        node: Node | None = tree
        for part in slot.path:
            node = node.child(part) if node else None
        if node is not None and node.value is not None:
            yield slot


def _all_slots(tree: Node) -> Iterator[Slot]:
    yield Slot("crowd", None, "crowd", ("crowd",))
    for robot, entry in tree.nearest("robots").items() if tree.child("robots") else ():
        path = ("robots", robot)
        yield Slot(robot, robot, "drive", (*path, "drive"))
        for sensor, _ in entry.nearest("sensors").items() if entry.child("sensors") else ():
            yield Slot(f"{robot}/{sensor}", robot, "sensor", (*path, "sensors", sensor))
        yield Slot(f"{robot}/controller", robot, "controller", (*path, "controller"))
    yield Slot("evaluator", None, "evaluator", ("evaluator",))


def component_specs(
    tree: Node, default_host: Host, problems: list[Problem], *, trust: bool = False
) -> tuple[ComponentSpec, ...]:
    """Every component that can be made; for those that cannot, the reasons are added to `problems`.

    What has the wrong keys or types is passed over: checking the whole file says so. With `trust`, nothing is
    imported or looked for: the scenario is a log's, and its components may be on another machine.
    """
    specs = []
    for slot in slots(tree):
        node = tree.nearest(*slot.path)
        entry: ComponentEntry | None = check(slot.adapter, node, "", [])
        if entry is None:
            continue
        draft = _Draft(slot, node, entry, default_host)
        draft.check_keys()
        if not (draft.faults or trust):
            draft.check_class()
            draft.check_command()
        if not draft.faults:
            specs.append(draft.spec())
        problems.extend(draft.faults)
    return tuple(specs)


class _Draft:
    """One component on its way from the file's entry to a spec, and what is wrong with it."""

    def __init__(self, slot: Slot, node: Node, entry: ComponentEntry, default_host: Host) -> None:
        self.faults: list[Problem] = []
        self._slot = slot
        self._node = node
        self._entry = entry
        self._host: Host = "exec" if entry.exec else entry.host or default_host
        self._use: str | None = None
        options = node.child("config")
        self._options = with_absolute_paths(options) if options else Node({}, node.place)
        self._config = self._options.plain()
        self._cwd: Path | None = None

    def check_keys(self) -> None:
        """Keys that do not go together, and what `use` and `cwd` stand for."""
        entry = self._entry
        preset = isinstance(entry, SensorEntry) and entry.preset  # that could not be read: somebody has said so
        if entry.use is None and entry.exec is None and not preset and self._host != "external":
            self._fault("found no component, expected `use: ...`, `exec: [...]`, or `host: external`")
        if entry.use is not None and entry.exec is not None:
            self._fault("found beside `use`, expected one of the two", "exec")
        if entry.exec is not None and entry.host is not None:
            self._fault(
                f"found '{entry.host}' beside `exec`, which is always a process of its own; leave it out", "host"
            )
        if entry.cwd is not None and entry.exec is None:
            self._fault("found without `exec`; leave it out", "cwd")
        if entry.exec is not None:
            place = self._node.nearest("exec" if entry.cwd is None else "cwd").place
            self._cwd = Path(os.path.abspath(place.folder / (entry.cwd or "")))
        if entry.use is not None:
            try:
                self._use = import_string(entry.use, self._slot.family, self._node.nearest("use").place.folder)
            except ComponentError as error:
                self._fault(str(error), "use")

    def check_class(self) -> None:
        """That the class can be imported and takes the options."""
        if self._use is None:
            return
        try:
            adapter = config_adapter(component_class(self._use, self._slot.family))
        except ComponentError as error:
            self._fault(str(error), "use")
            return
        config = check(adapter, self._options, key_path((*self._slot.path, "config")), self.faults)
        if config is not None:
            self._config = adapter.dump_python(config, mode="json")

    def check_command(self) -> None:
        """That the command line can be started."""
        if self._entry.exec is None or self._cwd is None:
            return
        program = self._entry.exec[0]
        path = self._cwd / program
        if not self._cwd.is_dir():
            self._fault(f"there is no folder {self._cwd}", "cwd")
        elif "/" not in program:
            if not shutil.which(program, path=search_path()):
                self._fault(f"there is no program '{program}' on the PATH; a file here is './{program}'", "exec")
        elif not path.is_file():
            self._fault(f"there is no file {path}", "exec")
        elif not os.access(path, os.X_OK):
            self._fault(f"{path} may not be executed; allow it: chmod +x {path}", "exec")

    def spec(self) -> ComponentSpec:
        """The component, once nothing is wrong with it."""
        entry, slot = self._entry, self._slot
        # A short name outlives the file behind it; a path means the same only if it is absolute.
        use = entry.use if entry.use and ":" not in entry.use else self._use
        cwd = str(self._cwd) if self._cwd else None
        written = slot.adapter.dump_python(replace(entry, use=use, cwd=cwd), mode="json", exclude_none=True)
        return ComponentSpec(
            name=slot.name,
            robot=slot.robot,
            host=self._host,
            use=self._use,
            exec=entry.exec or (),
            cwd=self._cwd,
            every=entry.every,
            config=self._config,
            inputs={port: Reference(*text.split(".")) for port, text in entry.inputs.items()},
            latency=entry.latency if isinstance(entry, ControllerEntry) else 0.0,
            entry=written | {"config": dict(self._config)},
            path=slot.path,
            node=self._node,
        )

    def _fault(self, text: str, *keys: str) -> None:
        self.faults.append(Problem(self._node.nearest(*keys).place, key_path((*self._slot.path, *keys)), text))
