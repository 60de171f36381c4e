"""`parallel`: all members start together."""

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


async def test_a_parallel_lasts_as_long_as_its_longest_member(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        parallel:
            wait elapsed(2s)
            wait elapsed(3s)
            log("at once")
        log("after")
""")
    assert ran.logs == [(0.0, "at once"), (3.0, "after")]


async def test_the_first_failing_member_cancels_the_others(run_text: RunText) -> None:
    ran = await run_text("""
scenario broken:
    do serial:
        wait elapsed(1s)
        emit fail

scenario main:
    do parallel:
        broken()
        serial:
            other: wait elapsed(2s)
            log("never")
""")
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.duration == 1.0
    assert ran.ends["other"] == "cancelled"


async def test_the_first_in_source_order_of_simultaneous_failures_counts(run_text: RunText) -> None:
    ran = await run_text("""
scenario first:
    do emit fail

scenario second:
    do emit fail

scenario main:
    do parallel:
        first()
        second()
""")
    assert ran.verdict.span is not None
    assert ran.verdict.span.line == 6


@pytest.mark.parametrize("members", [("emit go", 'log("seen")'), ('log("seen")', "emit go")])
async def test_members_do_not_receive_effects_of_the_same_delta_cycle(
    run_text: RunText, members: tuple[str, str]
) -> None:
    """In any order of members, the scenario ends only after the delta cycle."""
    text = "\n".join(f"        {member}" for member in members).replace("emit go", "emit end")
    ran = await run_text(f"scenario main:\n    do parallel:\n{text}\n")
    assert ran.logs == [(0.0, "seen")]


async def test_a_thousand_members_run_at_once(run_text: RunText) -> None:
    members = "\n".join(f"        wait elapsed({1 + number % 7}s)" for number in range(1000))
    ran = await run_text(f"scenario main:\n    do parallel:\n{members}\n")
    assert ran.verdict.passed
    assert ran.verdict.duration == 7.0


async def test_behaviors_cancelled_twice_in_an_instant_clean_up_in_order(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel(overlap: any, start_to_start: -1s):
        wait elapsed(1s)
        parallel:
            parallel:
                wait elapsed(3s)
            wait elapsed(3s)
        log("ends before the primary member starts")
    with:
        running_is_failure()
""")
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.duration == 0
