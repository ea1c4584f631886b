"""The plain controller, which also writes down what it is asked and answers: `python protocol_scribe.py FILE`."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import zenoh

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples"))
import plain_controller


class Scribe(plain_controller.Node):  # type: ignore[misc]
    """Adds a line of JSON to the file for each request: its name, its body and the answer."""

    def hello(self, **body: Any) -> Any:
        return self._noted("hello", body, super().hello(**body))

    def configure(self, **body: Any) -> Any:
        return self._noted("configure", body, super().configure(**body))

    def connect(self, **body: Any) -> Any:
        return self._noted("connect", body, super().connect(**body))

    def _noted(self, request: str, body: dict[str, Any], answer: Any) -> Any:
        with open(sys.argv[1], "a") as notes:
            print(json.dumps([request, body, answer or {}]), file=notes)
        return answer


if __name__ == "__main__":
    config = {"mode": "client", "connect": {"endpoints": [os.environ["CROWDCOSIM_ENDPOINT"]]}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(config))) as session:
        node = Scribe(session, os.environ["CROWDCOSIM_RUN"], os.environ["CROWDCOSIM_COMPONENT"])
        while node.answer() != "connect":
            pass
        while node.obey() != plain_controller.STOP:
            pass
