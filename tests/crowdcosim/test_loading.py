"""From an import string to a component class, or to one clear error."""

from pathlib import Path

import pytest

from crowdcosim.component import ComponentError
from crowdcosim.loading import load_class

GOOD = """
from crowdcosim import Sensor
from crowdcosim.messages import Twist

class Good(Sensor):
    def step(self) -> Twist: ...

class Plain: ...
"""


def test_a_class_is_loaded_from_a_file_or_a_module(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(GOOD)
    cls = load_class(f"{tmp_path}/mine.py:Good")
    assert cls.__name__ == "Good"
    assert load_class(f"{tmp_path}/mine.py:Good") is cls
    assert load_class("components.controllers.baseline:Baseline").__name__ == "Baseline"


def test_two_files_of_one_name_are_two_modules(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(GOOD)
    assert load_class(f"{tmp_path}/a/mine.py:Good") is not load_class(f"{tmp_path}/b/mine.py:Good")


@pytest.mark.parametrize(
    ("text", "use", "words"),
    [
        (GOOD, "mine.py", "expected 'package.module:Class'"),
        (GOOD, "mine.py:Goood", "did you mean 'Good'?"),
        (GOOD, "mine.py:Plain", "not a subclass of crowdcosim.Component"),
        (GOOD, "other.py:Good", "there is no file"),
        ("import does_not_exist", "mine.py:Good", "does_not_exist"),
        ("raise RuntimeError('no licence')", "mine.py:Good", "RuntimeError: no licence"),
        ("raise SystemExit(3)", "mine.py:Good", "SystemExit"),
        ("def broken(:", "mine.py:Good", "SyntaxError"),
        ("", "no_such_package.x:Good", "there is no module 'no_such_package'"),
    ],
)
def test_what_cannot_be_loaded_says_why(tmp_path: Path, monkeypatch, text, use, words) -> None:
    (tmp_path / "mine.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ComponentError) as error:
        load_class(use)
    assert words in str(error.value)
