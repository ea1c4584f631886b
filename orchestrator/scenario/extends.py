"""Reads a scenario or robot file with all that it extends, and lays `--set` values over it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from orchestrator.scenario.problems import Place, Problem, ScenarioError, near_miss
from orchestrator.scenario.shipped import devices_folder, names_in, robots_folder, scenario_names, scenarios_folder
from orchestrator.scenario.yaml_tree import Node, parse

_OF_ONE_FILE = ("extends", "name", "description")


class Shelf(NamedTuple):
    """Where the files of one sort are found by name."""

    sort: str
    folder: Path
    names: list[str]


def scenarios() -> Shelf:
    return Shelf("scenario", scenarios_folder(), scenario_names())


def robots() -> Shelf:
    return Shelf("robot", robots_folder(), names_in(robots_folder()))


def devices() -> Shelf:
    return Shelf("device", devices_folder(), names_in(devices_folder()))


def read(reference: str | Path, shelf: Shelf, place: Place, key: str = "", chain: tuple[Path, ...] = ()) -> Node:
    """The file that `reference` names, over all that it extends.

    Args:
        reference: A path (`./mine.yaml`, relative to `place.folder`) or the name of a file on the shelf.
        place: Where the reference was written.
        key: Under which key.
        chain: The files that led here.

    Raises:
        ScenarioError: if a file is missing or is not YAML, or if a file extends itself.
    """
    path = find(str(reference), shelf, place, key)
    if path in chain:
        loop = " -> ".join(_name(p) for p in (*chain[chain.index(path) :], path))
        raise ScenarioError([Problem(place, key, f"files extend each other in a loop: {loop}")])
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise ScenarioError([Problem(place, key, f"cannot read {_name(path)}: {error.strerror}")]) from None
    except UnicodeDecodeError as error:
        at = Place(_name(path), error.object.count(b"\n", 0, error.start) + 1)
        text = f"found the byte {error.object[error.start]:#04x}, expected UTF-8"
        raise ScenarioError([Problem(at, "", text)]) from None
    return extended(parse(text, Place(_name(path), 1, path.parent)), shelf, "", (*chain, path))


def extended(node: Node, shelf: Shelf, key: str = "", chain: tuple[Path, ...] = ()) -> Node:
    """A mapping laid over the files that its key `extends` names, the later over the earlier."""
    bases = node.child("extends")
    if bases is None or bases.value is None:
        return _without(node, "extends")
    key = f"{key}.extends".removeprefix(".")
    under = Node({}, node.place)
    for base in bases.value if isinstance(bases.value, list) else [bases]:
        if not isinstance(base.value, str):
            raise ScenarioError([Problem(base.place, key, f"expected the name or path of a {shelf.sort}, or a list")])
        under = merge(under, _without(read(base.value, shelf, base.place, key, chain), *_OF_ONE_FILE))
    return merge(under, _without(node, "extends"))


def merge(base: Node, over: Node) -> Node:
    """`over` laid over `base`: mappings merge, null takes a key away, everything else replaces.

    A component for which `over` names another `use` or `exec`, and a mapping of another `kind`, is replaced as a whole.
    """
    if not (isinstance(base.value, dict) and isinstance(over.value, dict)):
        return over
    entries = dict(base.value)
    for key, node in over.value.items():
        below = entries.get(key)
        if node.value is None:
            entries.pop(key, None)
        elif below is None:
            entries[key] = node
        elif key == "model" and isinstance(below.value, str) and isinstance(node.value, dict):
            # A robot's file by name, then single values of it: `--set robots.robot.model.max_speed=0.5`.
            entries[key] = replace(node, value={"extends": below} | node.value)
        elif _is_another(below, node):
            # The options and inputs below belong to the component, or the kind, that was there.
            entries[key] = merge(replace(node, value={}), node)
        else:
            entries[key] = merge(below, node)
    return Node(entries, over.place)


def _is_another(below: Node, over: Node) -> bool:
    if not (isinstance(below.value, dict) and isinstance(over.value, dict)):
        return False
    keys = ("use", "exec", "kind")
    before, after = ({k: n.plain() for k, n in v.items() if k in keys} for v in (below.value, over.value))
    return bool(before and after and before != after)


def with_settings(node: Node, settings: Sequence[str]) -> Node:
    """The tree with each `key.path=value` laid over it, in their order; a value is YAML.

    Raises:
        ScenarioError: if a setting is not of that form.
    """
    problems: list[Problem] = []
    for setting in settings:
        place = Place(f"--set {setting}", folder=Path.cwd())
        path, separator, text = setting.partition("=")
        keys = path.split(".")
        if not separator or not all(key.strip() == key != "" for key in keys) or len(keys) > 20:
            problems.append(Problem(place, "", "expected key.path=value, such as crowd.config.count=200"))
            continue
        try:
            value = parse(text, place)
        except ScenarioError as error:
            problems.extend(replace(problem, key=path) for problem in error.problems)
            continue
        for key in reversed(keys):
            value = Node({key: value}, place)
        node = replace(merge(node, value), place=node.place)
    if problems:
        raise ScenarioError(problems)
    return node


def find(reference: str, shelf: Shelf, place: Place, key: str = "") -> Path:
    """The file that a path or name stands for.

    Raises:
        ScenarioError: if there is none.
    """
    if reference in shelf.names:
        return (shelf.folder / f"{reference}.yaml").resolve()
    if reference.endswith((".yaml", ".yml")):
        path = place.folder / reference
        try:
            if path.is_file():
                return path.resolve()
        except OSError as error:
            raise ScenarioError([Problem(place, key, f"cannot read {_name(path)}: {error.strerror}")]) from None
        hint = near_miss(path.stem, shelf.names)
        raise ScenarioError([Problem(place, key, f"there is no file {_name(path)}{hint}")])
    raise ScenarioError(
        [
            Problem(
                place,
                key,
                f"there is no {shelf.sort} '{reference}'{near_miss(reference, shelf.names)}; "
                f"shipped: {_shown(shelf)}; or give the path of a .yaml file",
            )
        ]
    )


def _shown(shelf: Shelf) -> str:
    """The names on a shelf; of a folder's many, only the folder."""
    names = dict.fromkeys(f"{folder}/..." if folder else name for name in shelf.names for folder in [_folder(name)])
    return ", ".join(names)


def _folder(name: str) -> str:
    return name.rpartition("/")[0]


def _without(node: Node, *keys: str) -> Node:
    if not isinstance(node.value, dict):
        return node
    return replace(node, value={k: v for k, v in node.value.items() if k not in keys})


def _name(path: Path) -> str:
    """A path as the user would write it from here."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)
