"""Checks a part of a scenario against its type and says what is wrong, where, and what was meant."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic.errors import PydanticInvalidForJsonSchema
from pydantic_core import ErrorDetails

from orchestrator.scenario.field_docs import documented_schema
from orchestrator.scenario.file import FORMS
from orchestrator.scenario.problems import Problem, key_path, near_miss, shown
from orchestrator.scenario.yaml_tree import Node

T = TypeVar("T")

_EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a mapping",
    "mapping_type": "a mapping",
    "dataclass_type": "a mapping",
    "finite_number": "a finite number",
    "greater_than": "more than {gt}",
    "greater_than_equal": "at least {ge}",
    "less_than": "less than {lt}",
    "less_than_equal": "at most {le}",
    "literal_error": "{expected}",
    "string_pattern_mismatch": "{form}",
    "too_short": "at least {min_length} items",
    "too_long": "at most {max_length} items",
    "string_too_short": "at least {min_length} characters",
}
_WORDS = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a mapping",
}
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")


def check(adapter: TypeAdapter[T], node: Node, key: str, problems: list[Problem]) -> T | None:
    """The value of a part of a scenario, or None and one more problem for each thing that is wrong.

    Args:
        adapter: The part's type.
        node: The part.
        key: Dotted path of the part, to name it.
        problems: Where problems are added.
    """
    try:
        # As JSON, strictly: lists become tuples, but "3" is no number and 1 is not true.
        return adapter.validate_json(json.dumps(node.plain()), strict=True)
    except ValidationError as error:
        problems.extend(_Explainer(adapter, node, key).problems(error.errors(include_url=False)))
    except Exception as error:  # a config's own __post_init__ may raise anything
        problems.append(Problem(node.place, key, f"{type(error).__name__}: {error}"))
    return None


class _Explainer:
    def __init__(self, adapter: TypeAdapter[Any], node: Node, key: str) -> None:
        self._schema = _schema(adapter)
        self._node = node
        self._key = key

    def problems(self, errors: Iterable[ErrorDetails]) -> list[Problem]:
        """One problem per place: where a union has several complaints about one value, any of them would do."""
        found: dict[tuple[str | int, ...], tuple[str, list[str]]] = {}
        for error in errors:
            path = self._path(error)
            text, expected = self._explain(error, path)
            found.setdefault(path, (text, []))[1].append(expected)
        return [self._problem(path, text, expected) for path, (text, expected) in found.items()]

    def _problem(self, path: tuple[str | int, ...], text: str, expected: list[str]) -> Problem:
        choices = " or ".join(dict.fromkeys(e for e in expected if e))
        key = ".".join(part for part in (self._key, key_path(path)) if part)
        return Problem(self._node.nearest(*path).place, key, f"{text}, expected {choices}" if choices else text)

    def _path(self, error: ErrorDetails) -> tuple[str | int, ...]:
        """The error's location in the file; pydantic's also names the members of unions."""
        path: list[str | int] = []
        node: Node | None = self._node
        for part in error["loc"]:
            below = node.child(part) if node else None
            if below is not None:
                path.append(part)
                node = below
        if error["type"] == "missing" and isinstance(error["loc"][-1], str):
            path.append(error["loc"][-1])
        if error["type"] == "value_error" and (field := self._field_named_in(str(error["ctx"]["error"]), path)):
            path.append(field)
        return tuple(path)

    def _field_named_in(self, message: str, path: list[str | int]) -> str:
        """`speed` in "speed is -1.0, expected ...", if that is a field here."""
        word = re.match(r"\w*", message)
        return word[0] if word and word[0] in _properties(self._schema, path) else ""

    def _explain(self, error: ErrorDetails, path: tuple[str | int, ...]) -> tuple[str, str]:
        """What was found, and what was expected."""
        kind = error["type"]
        if kind in _UNKNOWN:
            known = {k: v for k, v in _properties(self._schema, path[:-1]).items() if k != path[-1]}
            hint = near_miss(path[-1], known) or f"; known here: {', '.join(known) or 'none'}"
            if "config" in known:
                hint += "; a component's own options stand under `config`"
            return f"unknown key{hint}", ""
        if kind == "missing":
            return self._missing(error, path)
        if kind == "value_error":
            return str(error["ctx"]["error"]), ""
        value = error["input"]
        if kind in ("union_tag_invalid", "union_tag_not_found"):
            return self._untagged(error)
        if kind == "too_long" and error["ctx"].get("field_type") == "Tuple":
            return f"found a list of {len(value)}", f"a list of {error['ctx']['max_length']}"
        if kind not in _EXPECTED:
            return f"found {shown(value)}: {error['msg']}", ""
        context = {key: _short(value) for key, value in error.get("ctx", {}).items()}
        if pattern := context.get("pattern"):
            context["form"] = FORMS.get(pattern, f"text of the form {pattern}")
        choices = re.findall(r"'([^']*)'", context["expected"]) if kind == "literal_error" else []
        return f"found {shown(value)}", _EXPECTED[kind].format(**context) + near_miss(value, choices)

    def _untagged(self, error: ErrorDetails) -> tuple[str, str]:
        """A mapping of which one key says what it is, and that key is missing or wrong."""
        key = error["ctx"]["discriminator"].strip("'")
        choices = re.findall(r"'([^']*)'", error["ctx"].get("expected_tags", ""))
        if not choices:
            return f"key '{key}' is missing", "it to say what this is"
        tag = error["ctx"]["tag"]
        return f"found {key} '{tag}'", " or ".join(f"'{c}'" for c in choices) + near_miss(tag, choices)

    def _missing(self, error: ErrorDetails, path: tuple[str | int, ...]) -> tuple[str, str]:
        if isinstance(error["loc"][-1], int):
            value = error["input"]
            return f"found a list of {len(value)}", f"a list of {_at(self._schema, path).get('minItems', 'more')}"
        described = _properties(self._schema, path[:-1]).get(str(path[-1]), {})
        what = _WORDS.get(_followed(described, self._schema).get("type", ""), "a value")
        description = described.get("description", "")
        return "missing", f"{what}{' ' if description.startswith('[') else ': ' if description else ''}{description}"


def _short(value: Any) -> Any:
    """A limit as one writes it: 0, not 0.0."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _schema(adapter: TypeAdapter[Any]) -> dict[str, Any]:
    try:
        return documented_schema(adapter)
    except PydanticInvalidForJsonSchema:  # a config of exotic types is explained without hints
        return {}


def _properties(schema: dict[str, Any], path: Iterable[str | int]) -> dict[str, Any]:
    """The keys that the schema allows at `path`, with their schemas."""
    properties: dict[str, Any] = _at(schema, path).get("properties", {})
    return properties


def _at(schema: dict[str, Any], path: Iterable[str | int]) -> dict[str, Any]:
    """The part of a JSON Schema that describes what is at `path`; empty if it does not say."""
    here = _followed(schema, schema)
    for part in path:
        if isinstance(part, int):
            below = here.get("items") or (here.get("prefixItems", [])[part : part + 1] or [{}])[0]
        else:
            others = [*here.get("patternProperties", {}).values(), here.get("additionalProperties")]
            below = here.get("properties", {}).get(part) or next((o for o in others if isinstance(o, dict)), {})
        here = _followed(below, schema)
    return here


def _followed(part: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    """A part of a schema with its reference followed.

    Of several choices it is the first that is a mapping; of those that one key tells apart, all of their keys.
    """
    while "$ref" in part:
        part = schema["$defs"][part["$ref"].removeprefix("#/$defs/")]
    if "oneOf" in part:
        members = [_followed(choice, schema) for choice in part["oneOf"]]
        return {"type": "object", "properties": {k: v for m in members for k, v in m.get("properties", {}).items()}}
    choices = [_followed(choice, schema) for choice in part.get("anyOf", [])]
    return next((c for c in choices if "properties" in c), choices[0] if choices else part)
