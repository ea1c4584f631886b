"""JSON Schemas whose properties are described by the docstrings under a dataclass's fields."""

from __future__ import annotations

import ast
import inspect
import itertools
import textwrap
from dataclasses import is_dataclass
from functools import cache
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema


def documented_schema(adapter: TypeAdapter[Any]) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what an adapter accepts."""
    return adapter.json_schema(schema_generator=_Documented)


class _Documented(GenerateJsonSchema):
    def dataclass_schema(self, schema: core_schema.DataclassSchema) -> JsonSchemaValue:
        json_schema = super().dataclass_schema(schema)
        cls: Any = schema["cls"]
        docs = field_docs(cls)
        for name, found in json_schema.get("properties", {}).items():
            found.pop("title", None)  # pydantic's titles repeat the key
            if name in docs:
                found["description"] = docs[name]
        return json_schema

    def dict_schema(self, schema: core_schema.DictSchema) -> JsonSchemaValue:
        json_schema = super().dict_schema(schema)
        if "patternProperties" in json_schema:
            json_schema["additionalProperties"] = False  # a key that is no name is an error
        return json_schema


@cache
def field_docs(cls: type) -> dict[str, str]:
    """The docstring under each field of a dataclass and of the dataclasses it is derived from."""
    docs: dict[str, str] = {}
    for ancestor in reversed(cls.__mro__):
        if is_dataclass(ancestor):
            docs |= _own_docs(ancestor)
    return docs


def _own_docs(cls: type) -> dict[str, str]:
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(cls)))
    except (OSError, TypeError, SyntaxError):  # made at run time: there is no source to read
        return {}
    assert isinstance(tree.body[0], ast.ClassDef)
    body = tree.body[0].body
    docs: dict[str, str] = {}
    for statement, after in itertools.pairwise(body):
        if not (isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)):
            continue
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str):
            docs[statement.target.id] = inspect.cleandoc(after.value.value)
    return docs
