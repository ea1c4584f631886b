"""Write the generated parts of `protocol.md` from the code and from a real run: `python docs/generate_protocol.py`."""

from __future__ import annotations

import json
import re
import sys
import tempfile
import types
import typing
from pathlib import Path
from typing import Any

from protocol_vectors import attachment, vectors
from rosbags.interfaces import Nodetype

from crowdcosim.cdr import store, type_hash
from crowdcosim.component import ports_of
from crowdcosim.interfaces.generate import own_messages
from crowdcosim.loading import load_class
from crowdcosim.messages import MESSAGES
from crowdcosim.robots import Car, Differential, Holonomic, Mount, Robot, RobotModel, Target
from crowdcosim.robots import Pose as Place
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World
from orchestrator.scenario.field_docs import field_docs
from orchestrator.scenario.registry import SHIPPED
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation, component_seed

HERE = Path(__file__).resolve().parent
PAGE = HERE / "protocol.md"
EXAMPLES = HERE.parent / "examples"

SOURCES = {
    "crowd": "crowd",
    "drive": "kinematic",
    "sensor": "lidar odometry",
    "controller": "dwa",
    "evaluator": "paper",
}
"""family -> shipped components in the table of ports"""

PARTS = (Setup, World, Wall, Robot, RobotModel, Differential, Holonomic, Car, Mount, Place, Target)
"""What the JSON of a setup is made of."""


# --- types -----------------------------------------------------------------------------------------------------------


def types_table() -> str:
    """Every message type with its hash."""
    own = own_messages()
    lines = ["| type | hash |", "|---|---|"]
    for name in MESSAGES:
        link = f"[{name}](../crowdcosim/interfaces/msg/{name.rpartition('/')[2]}.msg)" if name in own else f"{name}"
        lines.append(f"| {link} | `{type_hash(name)}` |")
    return "\n".join(lines)


def layouts() -> str:
    """The fields of the standard types, in their order."""
    lines = []
    for name in MESSAGES:
        if name not in own_messages():
            _, fields = store().fielddefs[name]
            lines += [name, *(f"    {_field_type(node, detail)} {field}" for field, (node, detail) in fields)]
    return "```text\n" + "\n".join(lines) + "\n```"


def _field_type(node: Nodetype, detail: Any) -> str:
    if node is Nodetype.BASE:
        return str(detail[0])
    if node is Nodetype.NAME:
        return str(detail).replace("/msg/", "/")
    item, count = detail
    return f"{_field_type(*item)}[{count if node is Nodetype.ARRAY else ''}]"


def ports() -> str:
    """What the shipped components take and give."""
    lines = ["| component | kind | takes | gives |", "|---|---|---|---|"]
    for family, names in SOURCES.items():
        for name in names.split():
            found = ports_of(load_class(SHIPPED[family][name]))  # type: ignore[index]
            takes = ", ".join(f"`{p.name}: {p.type.__name__}`{' (all)' if p.many else ''}" for p in found.inputs)
            gives = ", ".join(f"`{p.name}: {p.type.__name__}`" for p in found.outputs)
            lines.append(f"| {name} ({family}) | {found.kind} | {takes} | {gives} |")
    lines.append("| `ROBOT/goal` (the orchestrator's own) | every 0 | | `goal: Goal` |")
    return "\n".join(lines)


# --- JSON ------------------------------------------------------------------------------------------------------------


def setup_fields() -> str:
    """Every field of the setup, from the docstrings of the code."""
    sections = []
    for cls in PARTS:
        hints, docs = typing.get_type_hints(cls), field_docs(cls)
        rows = [f"| `{name}` | {_json_type(hint)} | {_in_json(docs.get(name, ''))} |" for name, hint in hints.items()]
        sections.append("\n".join([f"**{cls.__name__}**", "", "| key | JSON | meaning |", "|---|---|---|", *rows]))
    return "\n\n".join(sections)


def _in_json(text: str) -> str:
    """The words of a docstring, with JSON's names for Python's constants."""
    return re.sub(r"\b(None|True|False)\b", lambda match: {"None": "null"}.get(match[1], match[1].lower()), text)


def _json_type(hint: Any) -> str:
    arguments = typing.get_args(hint)
    if isinstance(hint, types.UnionType):
        return " or ".join(_json_type(a) for a in arguments)
    if typing.get_origin(hint) is typing.Literal:
        return " or ".join(json.dumps(a) for a in arguments)
    if typing.get_origin(hint) is tuple:
        if arguments[-1] is Ellipsis:
            return f"list of {_json_type(arguments[0])}"
        return f"list of {len(arguments)} {_json_type(arguments[0])}s"
    if arguments:
        return "object"
    names = {int: "integer", float: "number", str: "string", bool: "boolean", types.NoneType: "null"}
    return names.get(hint, hint.__name__)


def seeds() -> str:
    """A few seeds."""
    lines = ["| scenario's seed | component | its seed |", "|---|---|---|"]
    for seed, component in ((1, "robot/controller"), (1, "crowd"), (2**64 - 1, "robot")):
        lines.append(f"| {seed} | `{component}` | {component_seed(seed, component)} |")
    return "\n".join(lines)


def handshake() -> dict[str, str]:
    """What `examples/plain_controller.py` is asked and answers when a run begins."""
    with tempfile.TemporaryDirectory() as folder:
        notes = Path(folder) / "notes"
        scenario = load(
            {
                "extends": str(EXAMPLES / "plain_controller.yaml"),
                "name": "plain_controller",
                "host": "inline",
                "robots": {"robot": {"controller": _scribe(notes)}},
            }
        )
        Simulation(scenario, logs=Path(folder)).close()
        requests = [json.loads(line) for line in notes.read_text().splitlines()]
    blocks = {}
    for name, body, answer in requests:
        blocks[f"{name} request"] = f"```json\n{pretty(body)}\n```"
        blocks[f"{name} answer"] = f"```json\n{pretty(answer)}\n```"
    return blocks


def _scribe(notes: Path) -> dict[str, Any]:
    """The plain controller of the example, but one that takes notes."""
    (example,) = [spec for spec in load(EXAMPLES / "plain_controller.yaml").components if spec.exec]
    command = [sys.executable, str(HERE / "protocol_scribe.py"), str(notes)]
    return {"exec": command, "config": dict(example.config)}


def pretty(value: Any, indent: str = "", width: int = 110) -> str:
    """JSON that breaks only the lines that are too long."""
    flat = json.dumps(value)
    if not value or not isinstance(value, dict | list) or len(indent) + len(flat) <= width:
        return flat
    inner = indent + "  "
    if isinstance(value, dict):
        items = [f"{inner}{json.dumps(k)}: {pretty(v, inner, width - len(k) - 5)}" for k, v in value.items()]
        return "{\n" + ",\n".join(items) + f"\n{indent}}}"
    return "[\n" + ",\n".join(inner + pretty(v, inner, width) for v in value) + f"\n{indent}]"


# --- the page --------------------------------------------------------------------------------------------------------


def blocks() -> dict[str, str]:
    """Every generated part, by the name in its marker."""
    return {
        "types": types_table(),
        "layouts": layouts(),
        "ports": ports(),
        "setup": setup_fields(),
        "seeds": seeds(),
        "attachment": attachment(),
        "vectors": vectors(),
        **handshake(),
    }


def regenerated(page: str) -> str:
    """The page with every generated part anew."""
    for name, text in blocks().items():
        part = re.compile(rf"(<!-- generated: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        page, count = part.subn(lambda match, text=text: f"{match[1]}{text}\n{match[2]}", page)  # type: ignore[misc]
        if count != 1:
            raise SystemExit(f"{PAGE}: found {count} markers `<!-- generated: {name} -->`, expected 1")
    return page


if __name__ == "__main__":
    PAGE.write_text(regenerated(PAGE.read_text()))
