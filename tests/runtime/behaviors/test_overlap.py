"""`overlap`, `start_to_start` and `end_to_end` of `parallel`."""

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.behaviors.test_duration import ACTIONS, DECLARATIONS
from tests.runtime.conftest import RunText


async def lengths(run_text: RunText, arguments: str, *members: float | str) -> tuple[bool, float]:
    """Run members with given durations [s]; return whether the run passed, and its end."""
    texts = [member if isinstance(member, str) else f"wait elapsed({member}s)" for member in members]
    lines = "".join(f"        {text}\n" for text in texts)
    ran = await run_text(f"{DECLARATIONS}scenario main:\n    do parallel({arguments}):\n{lines}", actions=ACTIONS)
    assert ran.verdict.status in (RunStatus.PASSED, RunStatus.FAILED)
    return ran.verdict.passed, ran.verdict.duration


@pytest.mark.parametrize(
    ("kind", "shorter", "equal", "longer"),
    [
        ("start", True, True, True),
        ("any", True, True, True),
        ("initial", True, True, True),
        ("inside", True, True, False),
        ("final", False, True, True),
        ("full", False, True, True),
        ("end", False, True, False),
        ("equal", False, True, False),
    ],
)
async def test_kinds_of_overlap_bound_the_ends_of_secondary_members(
    run_text: RunText, kind: str, shorter: bool, equal: bool, longer: bool
) -> None:
    assert await lengths(run_text, f"overlap: {kind}", 2.0, 1.0) == (shorter, 2.0 if shorter else 1.0)
    assert await lengths(run_text, f"overlap: {kind}", 2.0, 2.0) == (equal, 2.0)
    assert await lengths(run_text, f"overlap: {kind}", 2.0, 3.0) == (longer, 3.0 if longer else 2.0)


@pytest.mark.parametrize("kind", ["equal", "end", "inside"])
async def test_open_ended_members_end_with_the_primary_one(run_text: RunText, kind: str) -> None:
    ran = await run_text(
        f"""{DECLARATIONS}
scenario main:
    do serial:
        parallel(overlap: {kind}):
            wait elapsed(2s)
            member: serial:
                drive()
            parallel:
                drive()
                wait elapsed(5s)
        log("after")
""",
        actions=ACTIONS,
    )
    assert ran.logs == [(2.0, "stopped"), (2.0, "stopped"), (2.0, "after")]
    assert ran.ends["member"] == "succeeded"


async def test_ends_are_compared_by_instant_not_by_delta_cycle(run_text: RunText) -> None:
    members = "serial:\n            wait elapsed(2s)\n            wait elapsed(0s)\n            emit go"
    for first, second in (members, "wait elapsed(2s)"), ("wait elapsed(2s)", members):
        text = f"scenario main:\n    event go\n    do parallel(equal):\n        {first}\n        {second}\n"
        assert (await run_text(text)).verdict.passed


@pytest.mark.parametrize(
    ("offset", "primary", "secondary", "expected"),
    [
        ("1s", 1.0, 2.0, (True, 2.0)),
        ("1s", 1.0, 3.0, (False, 2.0)),
        ("1s", 1.0, 1.5, (False, 1.5)),
        ("1s", 1.0, 1.0, (False, 1.0)),
        ("-1s", 3.0, 2.0, (True, 3.0)),
        ("-1s", 3.0, 1.0, (False, 2.0)),
        ("-1s", 3.0, 2.5, (False, 3.0)),
        ("-1s", 3.0, 4.0, (False, 3.0)),
        ("[-1s..1s]", 2.0, 3.0, (True, 3.0)),
        ("[-1s..1s]", 2.0, 4.0, (False, 3.0)),
        ("1s", 1.0, "drive()", (True, 2.0)),
        ("[1s..1s]", 1.0, "drive()", (True, 2.0)),
        ("-1s", 1.0, "drive()", (False, 1.0)),
    ],
)
async def test_wrong_offsets_of_ends_are_rejected(
    run_text: RunText, offset: str, primary: float, secondary: float | str, expected: tuple[bool, float]
) -> None:
    assert await lengths(run_text, f"overlap: any, end_to_end: {offset}", primary, secondary) == expected


async def test_an_offset_of_the_end_of_an_open_ended_member_is_drawn(run_text: RunText) -> None:
    arguments = "overlap: any, end_to_end: [1s..3s]"
    passed, end = await lengths(run_text, arguments, 2.0, "drive()")
    assert passed
    assert 3.0 < end < 5.0
    assert (passed, end) == await lengths(run_text, arguments, 2.0, "drive()"), "from the seed"


STARTS = """
scenario main:
    do parallel({arguments}):
        serial:
            log("first")
            wait elapsed(2s)
        serial:
            log("second")
            wait elapsed(2s)
"""


@pytest.mark.parametrize(
    ("arguments", "starts"),
    [
        ("start_to_start: 1s", [(0.0, "first"), (1.0, "second")]),
        ("start_to_start: -1s", [(0.0, "second"), (1.0, "first")]),
        ("start_to_start: 2s", [(0.0, "first"), (2.0, "second")]),
        ("overlap: start, start_to_start: [-1s..1s]", [(0.0, "first"), (0.0, "second")]),
    ],
)
async def test_wrong_offsets_of_starts_are_rejected(
    run_text: RunText, arguments: str, starts: list[tuple[float, str]]
) -> None:
    ran = await run_text(STARTS.format(arguments=arguments))
    assert ran.logs == starts
    assert ran.verdict.passed


async def test_an_offset_of_the_start_is_drawn_within_the_overlap(run_text: RunText) -> None:
    text = STARTS.format(arguments="overlap: inside, start_to_start: [-1s..1s]")
    found = {(await run_text(text, seed=seed)).logs[1] for seed in range(4)}
    assert len(found) > 1
    assert all(0.0 <= time <= 1.0 and message == "second" for time, message in found)


async def test_a_parallel_fails_without_an_instant_of_all_members(run_text: RunText) -> None:
    ran = await run_text(STARTS.format(arguments="overlap: any, start_to_start: 3s"))
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 2.0)
    assert ran.verdict.reason == "`serial` ended before `serial` started"
    assert ran.logs == [(0.0, "first")]


async def test_an_offset_that_the_overlap_excludes_is_an_error(run_text: RunText) -> None:
    text = STARTS.format(arguments="overlap: inside, start_to_start: offset").replace(
        "    do", "    offset: time = -1s\n    do"
    )
    ran = await run_text(text)
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.reason == "an offset of -1 s contradicts `overlap: inside`"


async def test_a_composition_that_waits_to_start_members_can_be_ended(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel:
        parallel(start_to_start: 2s):
            wait elapsed(5s)
            log("never")
        serial:
            wait elapsed(1s)
            emit end
""")
    assert ran.verdict.passed
    assert (ran.verdict.duration, ran.logs) == (1.0, [])
