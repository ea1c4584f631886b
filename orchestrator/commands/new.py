"""`crowdcosim new`: files to start from."""

from __future__ import annotations

import json
import keyword
import re
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from rich.console import Console

from orchestrator.errors import InputError

_FILES = {"controller.py.jinja": "{}.py", "scenario.yaml.jinja": "{}.yaml", "test.py.jinja": "test_{}.py"}


def print_new_controller(name: str, folder: Path, as_json: bool) -> None:
    """Write a controller, a scenario that uses it and a test of it."""
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise InputError(f"the name is '{name}', expected lower-case letters, digits and _, such as polite_driver")
    paths = {template: folder / form.format(name) for template, form in _FILES.items()}
    if there := [str(path) for path in paths.values() if path.exists()]:
        raise InputError(f"there is {', '.join(there)} already; choose another name or folder")
    environment = Environment(
        loader=PackageLoader("orchestrator", "starters"), undefined=StrictUndefined, keep_trailing_newline=True
    )
    title = "".join(word.capitalize() for word in name.split("_"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for template, path in paths.items():
            path.write_text(environment.get_template(template).render(name=name, title=title), "utf-8")
    except OSError as error:
        raise InputError(f"cannot write into {folder}: {error.strerror}") from None
    controller, scenario, test = paths.values()
    if as_json:
        print(json.dumps({"controller": str(controller), "scenario": str(scenario), "test": str(test)}))
        return
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"{controller}    the controller, {title}", markup=False)
    console.print(f"{scenario}    a scenario: crowdcosim run {scenario}", markup=False)
    console.print(f"{test}    a test: python -m pytest {test}", markup=False)
    console.print(f"does it keep the contract? crowdcosim check {controller}:{title}", style="dim", markup=False)
