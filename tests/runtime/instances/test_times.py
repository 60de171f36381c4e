"""Constraints on the times of behaviors: `duration`, `overlap` and offsets of `it` (7.3.13, 7.6.2.4)."""

from __future__ import annotations

import pytest

from seoro import UsageError
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare, RunText

NAP = """
scenario nap:
    length: time
    do wait elapsed(length)

"""
PLACES = {
    "serial": "serial:\n        nap({length})\n    with:\n{lines}",
    "one_of": "one_of:\n        nap({length})\n        nap({length})\n    with:\n{lines}",
    "parallel": "parallel:\n        nap({length})\n        nap(0s)\n    with:\n{lines}",
    "scenario": "nap({length}) with:\n{lines}",
}


def within(place: str, length: str, *lines: str) -> str:
    """Return a scenario with constraints on a behavior of some length."""
    block = "".join(f"        {line}\n" for line in lines)
    return f"{NAP}scenario main:\n    do {PLACES[place].format(length=length, lines=block)}"


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    ("length", "constraint", "status", "end"),
    [
        ("2s", "keep(it.duration < 5s)", RunStatus.PASSED, 2.0),
        ("5s", "keep(it.duration <= 5s)", RunStatus.PASSED, 5.0),
        ("6s", "keep(it.duration <= 5s)", RunStatus.FAILED, 5.0),
        ("2s", "keep(it.duration >= 5s)", RunStatus.PASSED, 5.0),
        ("2s", "keep(it.duration in [3s..4s])", RunStatus.PASSED, 3.0),
        ("2s", "keep(it.duration == [3s..4s])", RunStatus.PASSED, 3.0),
        ("9s", "keep(it.duration == [3s..4s])", RunStatus.FAILED, 4.0),
        ("2s", "keep(it.duration.lower() == 2.5s)", RunStatus.PASSED, 2.5),
        ("2s", "keep(default it.duration in [3s..4s])", RunStatus.PASSED, 3.0),
        ("2s", "keep(it.duration < 1s or it.duration < 4s)", RunStatus.PASSED, 2.0),
    ],
)
async def test_constraints_bound_the_duration(
    run_text: RunText, place: str, length: str, constraint: str, status: RunStatus, end: float
) -> None:
    ran = await run_text(within(place, length, constraint))
    assert (ran.verdict.status, ran.verdict.duration) == (status, end), ran.verdict


async def test_a_duration_at_an_excluded_bound_fails(run_text: RunText) -> None:
    ran = await run_text(within("serial", "5s", "keep(it.duration < 5s)"))
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 4.999999999)
    assert ran.verdict.reason == "still running after 5 s; expected `keep(it.duration < 5s)`"
    assert ran.verdict.span is not None and ran.verdict.span.text == "keep(it.duration < 5s)"


@pytest.mark.parametrize(
    ("lines", "status", "end"),
    [
        (("keep(it.duration < 4s)", "keep(it.duration > 2s)"), RunStatus.PASSED, 2.000000001),
        (("keep(default it.duration in [3s..4s])", "remove_default(it.duration)"), RunStatus.PASSED, 1.0),
        (("keep(default it.duration in [3s..4s])", "keep(it.duration in [2s..5s])"), RunStatus.PASSED, 2.0),
        (("keep(it.duration < it.length)",), RunStatus.FAILED, 0.999999999),
        (("keep(it.duration.upper() == 2 * it.length)", "keep(it.duration > it.length)"), RunStatus.PASSED, 1.0),
    ],
)
async def test_several_constraints_bound_a_duration_together(
    run_text: RunText, lines: tuple[str, ...], status: RunStatus, end: float
) -> None:
    ran = await run_text(within("scenario", "1s", *lines))
    assert ran.verdict.status is status
    assert ran.verdict.duration == pytest.approx(end, abs=1e-8)


@pytest.mark.parametrize(
    ("argument", "constraint", "status", "end"),
    [
        ("[1s..6s]", "keep(it.duration < 3s)", RunStatus.PASSED, 2.0),
        ("[1s..6s]", "keep(it.duration > 4s)", RunStatus.PASSED, 4.000000001),
        ("[1s..6s]", "keep(it.duration.upper() <= 1.5s)", RunStatus.FAILED, 1.5),
        ("1s", "keep(it.duration > 2s)", RunStatus.ERROR, 0.0),
    ],
)
@pytest.mark.parametrize("place", ["serial", "scenario"])
async def test_constraints_narrow_the_duration_argument(
    run_text: RunText, place: str, argument: str, constraint: str, status: RunStatus, end: float
) -> None:
    text = within(place, "2s", constraint)
    if place == "serial":
        text = text.replace("do serial:", f"do serial(duration: {argument}):")
    else:
        text = text.replace("do nap(2s)", f"do nap(2s, duration: {argument})")
    ran = await run_text(text)
    assert (ran.verdict.status, ran.verdict.duration) == (status, end), ran.verdict


async def test_an_open_ended_behavior_lasts_until_its_upper_bound(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        log("on") with:
            success_is_running()
    with:
        keep(it.duration in [1s..3s])
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.PASSED, 3.0)


async def test_parameters_are_chosen_with_the_duration(run_text: RunText) -> None:
    """Drawn values stay; values that depend on the duration follow it."""
    ran = await run_text(f"""{NAP}
scenario shown:
    most: time
    n: int
    keep(n in [2..4])
    do serial:
        nap(1s)
        log(most == 4s and n == 4 ? "four" : most == 3s and n == 3 ? "three" : "two")

scenario main:
    do shown() with:
        keep(it.duration.upper() == it.n * 1s)
        keep(it.most == it.duration.upper())
        repeat(9)
""")
    assert ran.verdict.passed, ran.verdict
    assert {text for _, text in ran.logs} == {"two", "three", "four"}


@pytest.mark.parametrize("what", ["log('x')", "serial:\n        log('x')\n   "])
async def test_modifiers_use_and_bound_the_duration(run_text: RunText, what: str) -> None:
    ran = await run_text(f"""
modifier briefly:
    limit: time
    keep(it.duration <= limit)

modifier patiently:
    keep(it.duration >= 2s)
    timeout(it.duration.upper() - 1s)

scenario main:
    do {what} with:
        failure_is_success()
        patiently()
        briefly(4s)
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.PASSED, 2.0), ran.verdict


async def test_constraints_bound_the_duration_of_the_entry_scenario(run_text: RunText) -> None:
    ran = await run_text("""
modifier briefly:
    keep(it.duration <= 2s)

scenario main:
    briefly()
    do wait elapsed(3s)
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 2.0)


async def test_an_impossible_entry_scenario_is_reported(prepare_text: Prepare) -> None:
    text = "modifier never:\n    keep(it.duration < 0s)\n\nscenario main:\n    never()\n    do log('x')\n"
    with pytest.raises(UsageError) as caught:
        async with prepare_text(text):
            raise AssertionError("it must not start")
    assert caught.value.code == "E0442"


async def test_a_field_named_duration_is_not_replaced(run_text: RunText) -> None:
    ran = await run_text("""
scenario long:
    duration: time
    do wait elapsed(duration)

scenario main:
    do long() with:
        keep(it.duration == 3s)
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.PASSED, 3.0)


@pytest.mark.parametrize(
    "text",
    [
        "scenario main:\n    duration: time = 3s\n    do wait elapsed(duration)\n",
        "scenario main:\n    duration: time\n    keep(duration == 3s)\n    do wait elapsed(duration)\n",
        "global duration: time = 3s\nscenario main:\n    do wait elapsed(duration)\n",
    ],
)
async def test_a_field_named_duration_of_the_entry_scenario_is_not_replaced(run_text: RunText, text: str) -> None:
    ran = await run_text(text)
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.PASSED, 3.0)


# ---------------------------------------------------------------- parallel


@pytest.mark.parametrize(
    ("arguments", "lines", "starts", "status"),
    [
        ("", ("keep(it.overlap == equal)",), (0.0, 0.0), RunStatus.FAILED),
        ("", ("keep(it.overlap in [any, final])",), (0.0, 0.0), None),
        ("overlap: equal", ("keep(it.overlap == any)",), (), RunStatus.ERROR),
        ("", ("keep(it.start_to_start == 1s)",), (0.0, 1.0), RunStatus.PASSED),
        ("", ("keep(it.start_to_start >= 1s)",), (0.0, 1.0), RunStatus.PASSED),
        ("", ("keep(it.start_to_start < -1s)",), (1.000000001, 0.0), RunStatus.PASSED),
        ("", ("keep(it.start_to_start < 3s)",), (0.0, 0.0), RunStatus.PASSED),
        ("start_to_start: [0s..2s]", ("keep(it.start_to_start >= 2s)",), (0.0, 2.0), RunStatus.PASSED),
        ("", ("keep(it.end_to_end in [-1s..1s])",), (0.0, 0.0), RunStatus.FAILED),
        ("", ("keep(it.end_to_end >= -2s)",), (0.0, 0.0), RunStatus.PASSED),
        ("", ("keep(it.overlap == start)", "keep(it.start_to_start == 1s)"), (), RunStatus.ERROR),
    ],
)
async def test_constraints_bound_overlaps_and_offsets(
    run_text: RunText, arguments: str, lines: tuple[str, ...], starts: tuple[float, ...], status: RunStatus | None
) -> None:
    block = "".join(f"        {line}\n" for line in lines)
    members = "        a: nap(4s)\n        b: nap(2s)\n"
    ran = await run_text(f"{NAP}scenario main:\n    do parallel({arguments}):\n{members}    with:\n{block}")
    found = {r["name"]: r["t"] for r in ran.records if r["kind"] == "behavior.start" and r["name"] in {"a", "b"}}
    assert tuple(found[name] for name in ("a", "b") if name in found) == starts
    assert status is None or ran.verdict.status is status, ran.verdict


# ---------------------------------------------------------------- events of compositions


async def test_blocks_of_compositions_may_use_their_events(run_text: RunText) -> None:
    ran = await run_text("""
modifier watch:
    event reported(what: string)
    on @it.start:
        emit reported("start")
    on @it.end:
        emit reported("end")
    on @it.fail:
        emit reported("fail")

scenario main:
    do serial:
        serial:
            wait elapsed(1s)
        with:
            watch()
        serial:
            wait elapsed(1s)
            emit fail
        with:
            watch()
            until @it.fail
""")
    reported = [
        (r["t"], r["arguments"]["what"]) for r in ran.records if r["kind"] == "event" and "reported" in r["name"]
    ]
    assert reported == [(0.0, "start"), (1.0, "end"), (1.0, "start")]
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 2.0), "`emit fail` ends the scenario"
