"""The order of steps in a delta cycle can be chosen, and affects the order of records only."""

from pathlib import Path
from typing import Any

import pytest

from seoro.embed import load
from seoro.lang.frontend import lower
from seoro.runtime.execution.settings import Settings
from seoro.runtime.kernel.clock import VirtualClock
from seoro.runtime.kernel.delta import StepOrder
from seoro.runtime.run import Execution
from seoro.runtime.verdict import RunStatus

TEXT = """
import osc.helpers
scenario test:
    event go
    do parallel:
        serial:
            wait @go
            log("a")
        serial:
            wait @go
            log("b")
        emit go
"""


class _Logs:
    def __init__(self) -> None:
        self.messages: list[str] = []

    def record(self, record: dict[str, Any]) -> None:
        if record["kind"] == "log":
            self.messages.append(record["message"])


@pytest.mark.parametrize(
    ("step_order", "expected"),
    [(None, ["a", "b"]), (lambda path: tuple(-index for index in path), ["b", "a"])],
    ids=["in order of paths", "backwards"],
)
async def test_the_order_of_steps_can_be_chosen(
    step_order: StepOrder | None, expected: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "test.osc"
    path.write_text(TEXT)
    scenario, logs = load(path), _Logs()
    settings = Settings(
        seed=0,
        clock=VirtualClock(),
        observers=[logs],
        actions=scenario.functions.actions,
        modifiers=scenario.functions.modifiers,
        step_order=step_order,
    )
    verdict = await Execution(lower(scenario.checked), settings).run()
    assert verdict.status is RunStatus.PASSED
    assert logs.messages == expected
