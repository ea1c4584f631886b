"""Files that a component's options name: `./this` and `../that` count from the file in which they are written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from orchestrator.scenario.yaml_tree import Node


def with_absolute_paths(node: Node) -> Node:
    """The options with every text that begins with `./` or `../` made absolute."""
    if isinstance(node.value, dict):
        return replace(node, value={key: with_absolute_paths(below) for key, below in node.value.items()})
    if isinstance(node.value, list):
        return replace(node, value=[with_absolute_paths(below) for below in node.value])
    if isinstance(node.value, str) and node.value.startswith(("./", "../")):
        return replace(node, value=os.path.abspath(node.place.folder / node.value))
    return node


def files_in(config: Any) -> Iterator[Path]:
    """Every file that the options name by an absolute path, also as `/path/file.py:Class`."""
    if isinstance(config, dict):
        for below in config.values():
            yield from files_in(below)
    elif isinstance(config, list | tuple):
        for below in config:
            yield from files_in(below)
    elif isinstance(config, str) and os.path.isabs(config):
        for name in (config, config.rpartition(":")[0]):
            if "\0" not in name and os.path.isfile(name):
                yield Path(name)
                return
