"""YAML as a tree whose every value knows its file and line: YAML 1.2's core schema, without tags and duplicate keys."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import yaml
from yaml.reader import Reader

from orchestrator.scenario.problems import Place, Problem, ScenarioError, key_path, shown

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MAX_DEPTH = 100
_MAX_VALUES = 1_000_000
_TOO_LARGE = 2**128
_NULL = re.compile(r"~|null|Null|NULL|")
_TRUE = re.compile(r"true|True|TRUE")
_FALSE = re.compile(r"false|False|FALSE")
_INT = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]+")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")

Scalar = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Node:
    """A value and where it was written: the line of its key, or its own in a list."""

    value: Scalar | dict[str, Node] | list[Node]
    place: Place

    def child(self, part: str | int) -> Node | None:
        """The value under a key or index, None if there is none."""
        if isinstance(self.value, dict) and isinstance(part, str):
            return self.value.get(part)
        if isinstance(self.value, list) and isinstance(part, int) and 0 <= part < len(self.value):
            return self.value[part]
        return None

    def nearest(self, *path: str | int) -> Node:
        """The value at `path`, or the innermost one around it that exists."""
        node = self
        for part in path:
            node = node.child(part) or node
        return node

    def items(self) -> Iterator[tuple[str, Node]]:
        """The entries of a mapping; none of anything else."""
        if isinstance(self.value, dict):
            yield from self.value.items()

    def plain(self) -> Any:
        """The value without its places."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value


def parse(text: str, place: Place) -> Node:
    """The one document in `text`. Lines count from that of `place`; 0 stays 0.

    Raises:
        ScenarioError: if it is not YAML, or uses what the core schema has not.
    """
    for strange in Reader.NON_PRINTABLE.finditer(text):
        at = _at(place, text.count("\n", 0, strange.start()))
        raise ScenarioError([Problem(at, "", f"found the character {strange.group()!r}, expected printable text")])
    composer = _Composer(text, place)
    try:
        node = composer.document()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        at = _at(place, mark.line if mark else 0)
        because = ", ".join(part for part in (error.context, error.problem) if part)
        composer.problems.append(Problem(at, "", f"this is not YAML: {because}"))
    except yaml.YAMLError as error:
        composer.problems.append(Problem(place, "", f"this is not YAML: {error}"))
    if composer.problems:
        raise ScenarioError(composer.problems)
    return node


def from_python(value: Any, place: Place) -> Node:
    """A tree of plain Python data: mappings, lists or tuples, and scalars.

    Raises:
        ScenarioError: if there is something else in it.
    """
    problems: list[Problem] = []
    node = _from_python(value, place, (), problems)
    if problems:
        raise ScenarioError(problems)
    return node


def _from_python(value: Any, place: Place, path: tuple[str | int, ...], problems: list[Problem]) -> Node:
    if len(path) > _MAX_DEPTH:
        problems.append(Problem(place, "", f"nested deeper than {_MAX_DEPTH} levels"))
    elif isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                problems.append(Problem(place, key_path(path), f"the key {shown(key)} is not a string"))
        entries = {k: v for k, v in value.items() if isinstance(k, str)}
        return Node({k: _from_python(v, place, (*path, k), problems) for k, v in entries.items()}, place)
    elif isinstance(value, list | tuple):
        return Node([_from_python(v, place, (*path, i), problems) for i, v in enumerate(value)], place)
    elif value is None or isinstance(value, str | int | float):
        if fault := _fault(value):
            problems.append(Problem(place, key_path(path), fault))
        else:
            return Node(value, place)
    else:
        problems.append(
            Problem(place, key_path(path), f"found a {type(value).__name__}, expected a mapping, list, text or number")
        )
    return Node(None, place)


class _Composer:
    """Builds the tree from the parser's events. PyYAML's own composer recurses in C, and deep input crashes it."""

    def __init__(self, text: str, place: Place) -> None:
        self.problems: list[Problem] = []
        self._events: Iterator[Any] = yaml.parse(text, Loader=_LOADER)
        self._place = place
        self._anchors: dict[str, tuple[Node, int]] = {}
        self._count = 0

    def document(self) -> Node:
        next(self._events)  # the stream's start
        if isinstance(next(self._events), yaml.StreamEndEvent):
            return Node(None, self._place)
        node = self._node(next(self._events), ())
        next(self._events)  # the document's end
        after = next(self._events)
        if not isinstance(after, yaml.StreamEndEvent):
            self._add(after, (), "a second document begins; expected one")
        return node

    def _node(self, event: Any, path: tuple[str | int, ...]) -> Node:
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event, path)
        before = self._count
        self._grow(1, event, path)
        if len(path) > _MAX_DEPTH:
            self._stop(event, (), f"nested deeper than {_MAX_DEPTH} levels")
        if event.tag not in (None, "!"):
            self._add(event, path, f"the tag {event.tag} is not supported; put text in quotes, the rest plain")
        place = self._at(event)
        if isinstance(event, yaml.MappingStartEvent):
            node = Node(self._mapping(path), place)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = Node(self._sequence(path), place)
        else:
            node = Node(self._scalar(event, path), place)
        if event.anchor:
            self._anchors[event.anchor] = node, self._count - before
        return node

    def _mapping(self, path: tuple[str | int, ...]) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key = self._key(event, path)
            place = self._at(event)
            value = replace(self._node(next(self._events), (*path, key)), place=place)
            if key in entries:
                self._add(event, (*path, key), f"duplicate key; it is also at {entries[key].place}")
            entries[key] = value
        return entries

    def _key(self, event: Any, path: tuple[str | int, ...]) -> str:
        key = self._node(event, (*path, "?")).value
        if not isinstance(key, str):
            self._add(event, path, f"found {shown(key)} as a key, expected text; put it in quotes if it is a name")
        return str(key)

    def _sequence(self, path: tuple[str | int, ...]) -> list[Node]:
        items: list[Node] = []
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            items.append(self._node(event, (*path, len(items))))
        return items

    def _scalar(self, event: Any, path: tuple[str | int, ...]) -> Scalar:
        value = event.value if not event.implicit[0] else _core(event.value)
        if fault := _fault(value):
            self._add(event, path, fault)
            return None
        return value

    def _alias(self, event: Any, path: tuple[str | int, ...]) -> Node:
        if event.anchor not in self._anchors:
            self._stop(event, path, f"the alias *{event.anchor} has no anchor before it")
        node, count = self._anchors[event.anchor]
        self._grow(count, event, path)
        return node

    def _grow(self, count: int, event: Any, path: tuple[str | int, ...]) -> None:
        # Aliases of aliases multiply: a few lines can stand for more values than memory holds.
        self._count += count
        if self._count > _MAX_VALUES:
            self._stop(event, path, f"more than {_MAX_VALUES} values")

    def _add(self, event: Any, path: tuple[str | int, ...], text: str) -> None:
        self.problems.append(Problem(self._at(event), key_path(path), text))

    def _stop(self, event: Any, path: tuple[str | int, ...], text: str) -> None:
        self._add(event, path, text)
        raise ScenarioError(self.problems)

    def _at(self, event: Any) -> Place:
        return _at(self._place, event.start_mark.line)


def _at(place: Place, lines: int) -> Place:
    return replace(place, line=place.line + lines) if place.line else place


def _core(text: str) -> Scalar:
    """A plain scalar by the core schema of YAML 1.2: `1e-3` is a number, `on` and `yes` are text."""
    if _NULL.fullmatch(text):
        return None
    if _TRUE.fullmatch(text):
        return True
    if _FALSE.fullmatch(text):
        return False
    for pattern, radix in ((_INT, 10), (_OCTAL, 8), (_HEX, 16)):
        if pattern.fullmatch(text):
            # int() refuses thousands of digits; _fault refuses what stands in for them.
            return int(text.replace("0o", ""), radix) if len(text) <= 50 else _TOO_LARGE
    if _FLOAT.fullmatch(text):
        return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
    return text


def _fault(value: Any) -> str:
    """What is wrong with a scalar, empty if nothing."""
    if isinstance(value, float) and not math.isfinite(value):
        return f"found {value}, expected a finite number"
    if isinstance(value, int) and abs(value) >= _TOO_LARGE:
        return "found a whole number beyond 128 bits, expected a smaller one"
    if isinstance(value, str) and re.search("[\0\ud800-\udfff]", value):
        return f"found {shown(value)}, expected text without null characters and halves of characters"
    return ""
