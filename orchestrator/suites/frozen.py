"""Frozen scenario files: all that an experiment needs in one file, written the same bytes every time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

WIDTH = 118
SHORT = 8
"""lists up to this long stand in a line with what is around them"""


@dataclass(frozen=True, kw_only=True)
class Frozen:
    """One scenario file of a suite."""

    name: str
    """the file's, without `.yaml`"""
    comment: str
    """opens the file"""
    body: Mapping[str, Any]
    """the scenario as plain data"""

    def text(self) -> str:
        """The file's text."""
        comment = "".join(f"# {line}\n" for line in self.comment.splitlines())
        # With a mapping beside it, the outermost mapping is in block style whatever the body is.
        body: str = yaml.dump({**self.body, "_": {"_": {}}}, Dumper=_Dumper, sort_keys=False, width=WIDTH)
        return comment + body.rpartition("_:\n")[0]


def write(files: Iterable[Frozen], folder: Path) -> list[Path]:
    """Write the files into `folder`, over earlier ones of the same names; returns where they are."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for file in files:
        path = folder / f"{file.name}.yaml"
        path.write_text(file.text(), encoding="utf-8", newline="\n")
        written.append(path)
    return written


class _Dumper(yaml.SafeDumper):
    """Block style outside; lists and mappings of a few plain values in flow style, as one would write it by hand."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _mapping(dumper: _Dumper, mapping: Mapping[str, Any]) -> yaml.MappingNode:
    block = any(isinstance(v, Mapping) or (isinstance(v, list) and len(v) > SHORT) for v in mapping.values())
    return dumper.represent_mapping("tag:yaml.org,2002:map", mapping, flow_style=not block)


def _sequence(dumper: _Dumper, items: list[Any]) -> yaml.SequenceNode:
    return dumper.represent_sequence("tag:yaml.org,2002:seq", items, flow_style=True)


_Dumper.add_representer(dict, _mapping)
_Dumper.add_representer(list, _sequence)
