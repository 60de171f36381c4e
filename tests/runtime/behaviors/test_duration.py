"""`duration`: how long compositions and invocations last."""

import pytest

from seoro import ActionContext, action
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

DECLARATIONS = """
action drive
action nap:
    length: time

"""


@action("drive", open_ended=True)
async def drive(ctx: ActionContext) -> None:
    """Drive without an end."""
    try:
        await ctx.sleep(1e6)
    finally:
        ctx.log("stopped")


@action("nap")
async def nap(ctx: ActionContext, length: float) -> None:
    await ctx.sleep(length)


ACTIONS = (drive, nap)


async def test_a_behavior_that_ends_early_is_held_until_the_lower_bound(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        serial(duration: [3s..5s]):
            log("early")
        log("after")
""")
    assert ran.logs == [(0.0, "early"), (3.0, "after")]


async def test_a_behavior_that_fails_early_is_not_held(run_text: RunText) -> None:
    ran = await run_text("""
scenario broken:
    do emit fail

scenario main:
    do broken(duration: 3s)
""")
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.duration == 0.0


async def test_a_behavior_still_running_at_the_upper_bound_fails(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do serial(duration: [1s..2s]):\n        wait elapsed(3s)\n")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 2.0)
    assert ran.verdict.reason == "still running after 2 s"
    assert ran.verdict.span is not None
    assert ran.verdict.span.text == "[1s..2s]"


async def test_the_bounds_of_a_duration_are_inclusive(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial(duration: 2s):
        wait elapsed(2s)
        wait elapsed(0s)
        log("in time")
        wait elapsed(0s)
""")
    assert ran.logs == [(2.0, "in time")]
    assert ran.verdict.passed


async def test_the_innermost_of_simultaneous_limits_acts_first(run_text: RunText) -> None:
    """Both members and the composition are in time."""
    ran = await run_text(
        DECLARATIONS
        + """
scenario main:
    do serial(duration: [0s..4s]):
        drive(duration: 2s)
        drive(duration: 2s)
        log("in time")
""",
        actions=ACTIONS,
    )
    assert ran.logs == [(2.0, "stopped"), (4.0, "stopped"), (4.0, "in time")]
    assert ran.verdict.passed


async def test_an_open_ended_behavior_is_ended_with_success(run_text: RunText) -> None:
    ran = await run_text(
        DECLARATIONS
        + """
scenario main:
    do serial:
        parallel(duration: 2s):
            drive()
            serial:
                nap(1s)
                drive()
        log("after")
""",
        actions=ACTIONS,
    )
    assert ran.logs == [(2.0, "stopped"), (2.0, "stopped"), (2.0, "after")]


@pytest.mark.parametrize("member", ["nap(3s)", "drive(duration: 5s)", "wait elapsed(3s)"])
async def test_members_beside_an_open_ended_one_must_end_in_time(run_text: RunText, member: str) -> None:
    """A behavior with its own duration is not open-ended: it ends after that duration."""
    text = f"scenario main:\n    do parallel(duration: 2s):\n        drive()\n        {member}\n"
    ran = await run_text(DECLARATIONS + text, actions=ACTIONS)
    assert ran.verdict.reason == "still running after 2 s"


async def test_a_negative_duration_is_an_error(run_text: RunText) -> None:
    ran = await run_text('scenario main:\n    t: time = -1s\n    do serial(duration: t):\n        log("never")\n')
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.reason == "invalid duration: expected at least 0 s, found -1 s"
    assert ran.logs == []
