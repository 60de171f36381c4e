"""Defects of seoro: each ends the run as an error with its name, and with clean-up."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from seoro import ActionContext, action
from seoro.embed.options import Options
from seoro.runtime.events.conditions import Conditions
from seoro.runtime.execution.services import Services
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.settling import Settling
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare

TEXT = """
action hold
scenario main:
    event go
    event gone
    var n: int = sample(n + 1, @gone, 0)
    on @go:
        emit gone
    do parallel:
        hold()
        wait n == 2
        serial:
            wait elapsed(1s)
            emit go
            hold()
    with:
        timeout(5s)
"""
SECONDS = 30.0  # of the wall clock; a run that hangs takes longer


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (Scheduler, "_resume_woken"),
        (Scheduler, "_act_at_end"),
        (Settling, "act"),
        (CancelScope, "cancel"),
        (Scheduler, "react"),
        (Conditions, "changed"),
        (Services, "write"),
        (Services, "_record_change"),
    ],
)
async def test_a_defect_ends_the_run_as_an_error_with_its_name(
    prepare_text: Prepare, monkeypatch: pytest.MonkeyPatch, owner: type[object], name: str
) -> None:
    cleaned: list[str] = []

    @action("hold", open_ended=True)
    async def hold(ctx: ActionContext) -> None:
        """Wait for the cancellation."""
        try:
            await ctx.sleep(1e6)
        finally:
            cleaned.append("hold")

    monkeypatch.setattr(owner, name, once_raising(getattr(owner, name)))
    options = Options(clock="virtual", grace=0.2)
    async with prepare_text(TEXT, options, [hold]) as run, asyncio.timeout(SECONDS), run.running():
        records = [record async for record in run.trace()]
        verdict = await run.result()
    assert verdict.status is RunStatus.ERROR
    assert verdict.reason == "internal error: ArithmeticError: of a defect"
    assert isinstance(run.fault, ArithmeticError)
    assert records[-1]["kind"] == "run.end"
    assert records[-1]["reason"] == verdict.reason
    started = sum(record.get("name") == "hold" for record in records if record["kind"] == "behavior.start")
    assert len(cleaned) == started > 0


def once_raising(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that raises at its first call, and works afterwards."""
    has_raised = False

    def raising(*args: Any, **kwargs: Any) -> Any:
        nonlocal has_raised
        if has_raised:
            return function(*args, **kwargs)
        has_raised = True
        raise ArithmeticError("of a defect")

    return raising
