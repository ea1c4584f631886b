"""The JSON Schema of scenario files, by which editors complete and check them, shipped components' options included."""

from __future__ import annotations

from typing import Any

from crowdcosim.component import config_adapter
from orchestrator.scenario.field_docs import documented_schema
from orchestrator.scenario.file import adapter
from orchestrator.scenario.registry import SHIPPED, Family, component_class
from orchestrator.scenario.shipped import list_components, list_devices, list_robots, scenario_names

_DEFS = "#/$defs/"
_ENTRY: dict[Family, str] = {"sensor": "SensorEntry", "controller": "ControllerEntry"}
"""what may stand beside a component of these families, other than a `ComponentEntry`"""
_PARTIAL = "partial-"
_OWN = {"type": "string", "pattern": ":", "description": "package.module:Class, or ./file.py:Class"}
_FILE = {"type": "string", "pattern": r"\.ya?ml$", "description": "path, relative to this file"}


def schema() -> dict[str, Any]:
    """The schema (draft 2020-12) of a scenario file as it is written.

    A file that extends another may leave out any key, and take one away with null.
    """
    whole = documented_schema(adapter())
    defs: dict[str, Any] = whole.pop("$defs")
    for family in SHIPPED:
        defs |= _component_defs(family)
    robot = defs["RobotEntry"]["properties"]
    for family in ("crowd", "evaluator"):
        whole["properties"][family] = _renamed(whole["properties"][family], "ComponentEntry", family)
    for key, family in (("drive", "drive"), ("sensors", "sensor"), ("controller", "controller")):
        robot[key] = _renamed(robot[key], _ENTRY.get(family, "ComponentEntry"), family)
    robot["model"] = _model(robot["model"], defs)
    whole["required"].remove("name")  # a file has a name anyway
    whole["properties"]["extends"] = _extends("scenario", scenario_names())
    defs["scenario"] = whole
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:crowdcosim:scenario",
        "title": "crowdcosim scenario",
        "description": "One experiment with robots in a crowd. SI units; frames as in REP 103.",
        "if": {"required": ["extends"]},
        "then": {"$ref": f"{_DEFS}{_PARTIAL}scenario"},
        "else": {"$ref": f"{_DEFS}scenario"},
        "$defs": defs | {f"{_PARTIAL}{name}": _partial(part) for name, part in defs.items()},
    }


def _component_defs(family: Family) -> dict[str, Any]:
    """A component of a family: the entry, with the options of each shipped class where `use` names it."""
    defs: dict[str, Any] = {}
    cases = []
    for name, use in SHIPPED[family].items():
        config = documented_schema(config_adapter(component_class(use, family)))
        own = config.pop("$defs", {})
        for inner, part in {"": config, **{f".{key}": part for key, part in own.items()}}.items():
            for key in own:
                part = _renamed(part, key, f"{family}.{name}.{key}")
            defs[f"{family}.{name}{inner}"] = part
        then: dict[str, Any] = {"properties": {"config": {"$ref": f"{_DEFS}{family}.{name}"}}}
        if config.get("required"):
            then["required"] = ["config"]
        cases.append({"if": {"properties": {"use": {"const": name}}, "required": ["use"]}, "then": then})
    names = [{"const": entry.name, "description": entry.description} for entry in list_components()[family]]
    defs[family] = {
        "$ref": f"{_DEFS}{_ENTRY.get(family, 'ComponentEntry')}",
        "properties": {"use": {"anyOf": [*names, _OWN, {"type": "null"}]}} | _preset(family),
        "allOf": cases,
    }
    return defs


def _preset(family: Family) -> dict[str, Any]:
    """The key by which a sensor is a device, by name or by file."""
    if family != "sensor":
        return {}
    names = [{"const": device.name, "description": device.description} for device in list_devices()]
    return {"preset": {"anyOf": [*names, _FILE, {"type": "null"}]}}


def _model(entry: dict[str, Any], defs: dict[str, Any]) -> dict[str, Any]:
    """A robot's model by name, by file, in full, or as changes to another."""
    full = defs["RobotModel"]
    changes = {key: value for key, value in full.items() if key != "required"}
    changes["properties"] = full["properties"] | {"extends": _extends("robot", [r.name for r in list_robots()])}
    defs["RobotModelChanges"] = changes | {"required": ["extends"]}
    names = [{"const": robot.name, "description": robot.description} for robot in list_robots()]
    mappings = [{"$ref": f"{_DEFS}RobotModel"}, {"$ref": f"{_DEFS}RobotModelChanges"}]
    return {"description": entry["description"], "anyOf": [*names, _FILE, *mappings]}


def _extends(sort: str, names: list[str]) -> dict[str, Any]:
    one = {"anyOf": [{"enum": names}, _FILE]}
    several = {"type": "array", "items": one}
    return {"description": f"the {sort}, or {sort}s, that this one changes", "anyOf": [one, several]}


def _renamed(part: Any, old: str, new: str) -> Any:
    """A part of a schema with one definition's references turned to another."""
    if isinstance(part, list):
        return [_renamed(item, old, new) for item in part]
    if isinstance(part, dict):
        if part.get("$ref") == f"{_DEFS}{old}":
            part = part | {"$ref": f"{_DEFS}{new}"}
        return {key: _renamed(value, old, new) for key, value in part.items()}
    return part


def _partial(part: Any) -> Any:
    """A part of a schema for files that extend another: nothing is required, and everything may be null."""
    if isinstance(part, list):
        return [_partial(item) for item in part]
    if not isinstance(part, dict):
        return part
    partial: dict[str, Any] = {}
    for key, value in part.items():
        if key in ("properties", "patternProperties"):
            partial[key] = {k: {"anyOf": [_partial(v), {"type": "null"}]} for k, v in value.items()}
        elif key == "$ref":
            partial[key] = value.replace(_DEFS, f"{_DEFS}{_PARTIAL}")
        elif key == "if":
            partial[key] = value
        elif key == "oneOf":
            partial["anyOf"] = _partial(value)  # without the key that tells the choices apart, several may fit
        elif key not in ("required", "discriminator"):
            partial[key] = _partial(value)
    return partial
