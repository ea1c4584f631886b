"""`crowdcosim check`: does a component keep the protocol?"""

from __future__ import annotations

import json
import shlex
from dataclasses import asdict
from typing import Any

from rich.console import Console

from crowdcosim.component import ComponentError, ports_of
from crowdcosim.loading import load_class
from orchestrator.conformance import Verdict, conformance
from orchestrator.errors import InputError
from orchestrator.trial import Subject


def print_check(component: list[str], config: str, deadline: float, as_json: bool) -> bool:
    """Print one line per examination; True if the component passed all."""
    console = Console(highlight=False, soft_wrap=True)
    verdicts = []
    for verdict in conformance(_subject(component, config, deadline)):
        verdicts.append(verdict)
        if not as_json:
            _show(console, verdict)
    passed = all(v.passed for v in verdicts)
    if as_json:
        print(json.dumps({"component": component, "passed": passed, "verdicts": [asdict(v) for v in verdicts]}))
    else:
        console.print("[green]conforms[/]" if passed else "[red]does not conform[/]")
    return passed


def json_object(config: str) -> dict[str, Any]:
    """What `--config` says.

    Raises:
        InputError: if it is no JSON object.
    """
    try:
        options = json.loads(config)
    except ValueError as error:
        raise InputError(f"--config is not JSON: {error}") from None
    if not isinstance(options, dict):
        raise InputError(f"--config is {config}, expected a JSON object such as '{{\"speed\": 1}}'")
    return options


def _subject(component: list[str], config: str, deadline: float) -> Subject:
    options = json_object(config)
    if ":" in component[0]:
        if len(component) > 1:
            after = shlex.join(component[1:])
            raise InputError(
                f"found {after} after '{component[0]}', expected options before the component: "
                f"crowdcosim check {after} {component[0]}"
            )
        try:
            ports_of(load_class(component[0]))
        except ComponentError as error:
            raise InputError(str(error)) from None
        return Subject(use=component[0], command=(), config=options, deadline=deadline)
    return Subject(use=None, command=tuple(component), config=options, deadline=deadline)


def _show(console: Console, verdict: Verdict) -> None:
    mark = "[green]pass[/]" if verdict.passed else "[red]FAIL[/]"
    console.print(f"{mark}  {verdict.name}")
    if verdict.detail:
        console.print(f"      {verdict.detail}", style="dim", markup=False)
