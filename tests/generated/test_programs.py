"""Guarantees of the runtime for generated scenarios (section 7.6.2 and the rules of rounds).

The order of tasks in a round affects only the order of its records. The order of members of `parallel` has no
effect. Runs with equal seeds are equal on any event loop. Traces obey the rules of the standard, by
`seoro.runtime.accept`.
"""

from __future__ import annotations

import asyncio
import json
import os
from collections import Counter
from collections.abc import Coroutine
from typing import Any

import pytest
import uvloop
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from seoro.runtime.accept import check_trace
from seoro.runtime.verdict import RunStatus
from tests.generated.model import Program
from tests.generated.running import Ran, execute, in_any_order, load_text
from tests.generated.strategies import programs

MAX_SECONDS = 20.0  # of the wall clock, for one run
QUICK = settings(
    max_examples=40, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
)
LONG = settings(
    QUICK, derandomize=False, max_examples=int(os.environ.get("SEORO_FUZZ_EXAMPLES", "25000")), print_blob=True
)


def on(loop_factory: Any, running: Coroutine[Any, Any, Ran]) -> Ran:
    """Return the result of a run on an event loop."""
    with asyncio.Runner(loop_factory=loop_factory) as runner:
        return runner.run(asyncio.wait_for(running, MAX_SECONDS))


def keeps_its_promises(program: Program, order: int) -> None:
    """Check the guarantees of the runtime for a program.

    Args:
        program: The program.
        order: Seed of the order of the tasks in a round.
    """
    loaded = load_text(program.text())
    ran = on(asyncio.new_event_loop, execute(loaded))
    assert ran.verdict is not None
    assert ran.verdict.status in (RunStatus.PASSED, RunStatus.FAILED), ran.verdict.reason
    assert lines(on(uvloop.new_event_loop, execute(loaded))) == lines(ran)
    shuffled = on(asyncio.new_event_loop, execute(loaded, order))
    assert in_any_order(shuffled) == in_any_order(ran)
    for each in (ran, shuffled):
        accepted = check_trace(loaded.plan, each.records)
        assert not accepted.violations, accepted.violations


def lines(ran: Ran) -> list[str]:
    """Return the lines of the trace file."""
    return [json.dumps(record) for record in ran.records]


def is_the_same_mirrored(program: Program) -> None:
    """Check that the order of the members of `parallel` has no effect."""
    forward, backward = (
        outcome(on(asyncio.new_event_loop, execute(load_text(program.text(mirrored)))))
        for mirrored in (False, True)
    )
    assert forward == backward


def outcome(ran: Ran) -> Any:
    """Return the results that are independent of the order of members: verdict, duration, logs and changes."""
    assert ran.verdict is not None
    # If two causes end the run in one round, the reason is the first one in the text.
    status = "stuck" if "nothing can happen" in ran.verdict.reason else ran.verdict.status
    logs = sorted((r["t"], r["message"]) for r in ran.records if r["kind"] == "log")
    # Changes of one round are committed one after the other, and tasks see only the final values. So the number of
    # changes and the final values are equal.
    changes = [(r["t"], r["path"], r["value"]) for r in ran.records if r["kind"] == "variable"]
    variables = {(t, path): value for t, path, value in changes}
    counts = Counter((t, path) for t, path, _ in changes)
    return status, ran.verdict.duration, logs, variables, counts


@QUICK
@given(programs(), st.integers(0, 2**32))
def test_a_run_is_the_same_again_on_any_loop_and_in_any_order_of_steps(program: Program, order: int) -> None:
    keeps_its_promises(program, order)


@settings(QUICK, max_examples=25)
@given(programs(drawn=False))
def test_the_order_of_parallel_members_changes_nothing(program: Program) -> None:
    is_the_same_mirrored(program)


@pytest.mark.slow
@LONG
@given(programs(), st.integers(0, 2**32))
def test_very_many_runs_are_the_same_again_on_any_loop_and_in_any_order_of_steps(
    program: Program, order: int
) -> None:
    keeps_its_promises(program, order)


@pytest.mark.slow
@LONG
@given(programs(drawn=False))
def test_the_order_of_parallel_members_changes_nothing_in_very_many_programs(program: Program) -> None:
    is_the_same_mirrored(program)
