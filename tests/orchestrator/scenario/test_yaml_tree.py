"""YAML with places: what is text and what is a number, which line a value has, and what is refused."""

from __future__ import annotations

import contextlib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.scenario.problems import Place, ScenarioError
from orchestrator.scenario.yaml_tree import from_python, parse

FILE = Place("f.yaml", 1)


def value_of(text: str) -> Any:
    return parse(text, FILE).plain()


def problems_of(text: str) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        parse(text, FILE)
    return [str(problem) for problem in caught.value.problems]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),  # YAML 1.1 takes it for text, as it has no dot
        ("1E3", 1000.0),
        ("-.5", -0.5),
        ("5.", 5.0),
        ("+7", 7),
        ("012", 12),  # YAML 1.1: octal, 10
        ("0o17", 15),
        ("0x1F", 31),
        ("1_000", "1_000"),  # YAML 1.1: 1000
        ("1:30", "1:30"),  # YAML 1.1: sixty-based, 90
        ("on", "on"),
        ("off", "off"),
        ("yes", "yes"),
        ("No", "No"),
        ("true", True),
        ("False", False),
        ("~", None),
        ("null", None),
        ("", None),
        ("'12'", "12"),
        ('"true"', "true"),
        ("1d+", "1d+"),
        ("1d-", "1d-"),
        ("2dx", "2dx"),
        ("2001-01-01", "2001-01-01"),
        ("./mine.py:Mine", "./mine.py:Mine"),
    ],
)
def test_scalars_follow_the_core_schema(text: str, value: Any) -> None:
    found = value_of(text)
    assert found == value
    assert type(found) is type(value)


def test_every_key_and_list_item_has_its_line() -> None:
    node = parse("a: 1\nb:\n  c:\n    - 5\n    - {d: 6}\n  # comment\n  e:\n    7\n", FILE)
    lines = {
        path: node.nearest(*path).place.line for path in [("a",), ("b",), ("b", "c"), ("b", "c", 1, "d"), ("b", "e")]
    }
    assert lines == {("a",): 1, ("b",): 2, ("b", "c"): 3, ("b", "c", 1, "d"): 5, ("b", "e"): 7}


def test_what_is_missing_is_placed_at_what_would_hold_it() -> None:
    node = parse("a:\n  b: {c: 1}\n", FILE)
    assert node.nearest("a", "b", "missing", "deeper").place == Place("f.yaml", 2)


def test_an_alias_repeats_a_value() -> None:
    assert value_of("a: &x {b: [1]}\nc: *x\n") == {"a": {"b": [1]}, "c": {"b": [1]}}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("a: 1\nb: 2\na: 3\n", "f.yaml:3: a: duplicate key; it is also at f.yaml:1"),
        ("x:\n  a: 1\n  a: 1\n", "f.yaml:3: x.a: duplicate key; it is also at f.yaml:2"),
        ("a: 1\n3: 2\n", "f.yaml:2: found 3 as a key, expected text; put it in quotes if it is a name"),
        ("a: .inf\n", "f.yaml:1: a: found inf, expected a finite number"),
        ("a: [1, .nan]\n", "f.yaml:1: a[1]: found nan, expected a finite number"),
        ("a: 1e999\n", "f.yaml:1: a: found inf, expected a finite number"),
        (
            "a: !!int 3\n",
            "f.yaml:1: a: the tag tag:yaml.org,2002:int is not supported; put text in quotes, the rest plain",
        ),
        ("---\na: 1\n---\nb: 2\n", "f.yaml:3: a second document begins; expected one"),
        ("a: *b\n", "f.yaml:1: a: the alias *b has no anchor before it"),
        ("a: &a [*a]\n", "f.yaml:1: a[0]: the alias *a has no anchor before it"),
        ('\na: "\\0"\n', "f.yaml:2: a: found '\\x00', expected text without null characters and halves of characters"),
        ("a: 1\nb: \x07\n", "f.yaml:2: found the character '\\x07', expected printable text"),
        ("a: " + "9" * 5000, "f.yaml:1: a: found a whole number beyond 128 bits, expected a smaller one"),
    ],
)
def test_what_is_refused_is_named_with_its_line(text: str, problem: str) -> None:
    assert problems_of(text) == [problem]


@pytest.mark.parametrize(
    ("text", "line"), [("a: 1\n\tb: 2\n", 2), ("a:\n  - [1, 2\nb: 3\n", 3), ("a: 'x\n", 2), ("a: b: c\n", 1)]
)
def test_broken_syntax_is_placed(text: str, line: int) -> None:
    (problem,) = problems_of(text)
    assert problem.startswith(f"f.yaml:{line}: this is not YAML: ")


def test_all_faults_of_a_file_are_reported_together() -> None:
    assert len(problems_of("a: 1\na: 2\nb: .inf\nb: 2\n")) == 3


@pytest.mark.parametrize("text", ["[" * 100_000, "{a: " * 100_000, "- " * 100_000 + "1", "? " * 5000])
def test_deep_nesting_is_refused(text: str) -> None:
    (problem,) = problems_of(text)
    assert problem == "f.yaml:1: nested deeper than 100 levels"


def test_aliases_that_multiply_are_refused() -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 9)]
    assert problems_of("\n".join(lines))[0].endswith("more than 1000000 values")


def test_plain_python_data_becomes_a_tree() -> None:
    data = {"a": [1, (2.5, None)], "b": {"c": True, "d": "x"}}
    assert from_python(data, Place("scenario")).plain() == {"a": [1, [2.5, None]], "b": {"c": True, "d": "x"}}


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        ({"a": {1: 2}}, "scenario: a: the key 1 is not a string"),
        ({"a": [object]}, "scenario: a[0]: found a type, expected a mapping, list, text or number"),
        ({"a": float("nan")}, "scenario: a: found nan, expected a finite number"),
        (
            {"a": "\ud800"},
            "scenario: a: found '\\ud800', expected text without null characters and halves of characters",
        ),
    ],
)
def test_python_data_that_yaml_could_not_hold_is_refused(data: Any, problem: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        from_python(data, Place("scenario"))
    assert str(caught.value) == problem


def test_data_that_contains_itself_is_refused() -> None:
    data: dict[str, Any] = {}
    data["a"] = data
    with pytest.raises(ScenarioError, match="nested deeper"):
        from_python(data, Place("scenario"))


@given(st.text(alphabet=st.sampled_from("ab:-[]{}&*!|>'\"#%@`,? \n\t01.e+~<"), max_size=60) | st.text(max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(ScenarioError):
        parse(text, FILE).plain()
