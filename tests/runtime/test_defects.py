"""A defect of seoro's own, wherever it shows, ends the run as an error that names it, with clean-up."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from seoro import ActionContext, action
from seoro.embed.options import Options
from seoro.runtime.agenda import Agenda
from seoro.runtime.conditions import Conditions
from seoro.runtime.services import Services
from seoro.runtime.settling import Settling
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
SECONDS = 5.0  # of the wall clock; a run that hangs takes longer


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (Agenda, "_wake_fired"),
        (Agenda, "_act_at_end"),
        (Settling, "act"),
        (Agenda, "end"),
        (Agenda, "react"),
        (Conditions, "changed"),
        (Services, "write"),
        (Services, "_record_change"),
    ],
)
async def test_a_defect_ends_the_run_as_an_error_that_names_it(
    prepare_text: Prepare, monkeypatch: pytest.MonkeyPatch, owner: type[object], name: str
) -> None:
    cleaned: list[str] = []

    @action("hold", open_ended=True)
    async def hold(ctx: ActionContext) -> None:
        """Go on until it is ended."""
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
    """A function that raises when it is called for the first time, and is itself from then on."""
    has_raised = False

    def raising(*args: Any, **kwargs: Any) -> Any:
        nonlocal has_raised
        if has_raised:
            return function(*args, **kwargs)
        has_raised = True
        raise ArithmeticError("of a defect")

    return raising
