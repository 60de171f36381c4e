"""Events, `on`, sampled variables and coverage of modifiers while the modified behavior runs."""

from __future__ import annotations

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Ran, RunText

NAP = """
scenario nap:
    length: time
    event half
    do serial:
        wait elapsed(length / 2)
        emit half
        wait elapsed(length / 2)

"""


def emitted(ran: Ran, name: str) -> list[tuple[float, dict[str, object]]]:
    """Return time and arguments of each occurrence of an event, by the end of its path."""
    return [(r["t"], r["arguments"]) for r in ran.records if r["kind"] == "event" and r["name"].endswith(name)]


async def test_a_modifier_reacts_to_its_behavior_and_to_itself(run_text: RunText) -> None:
    ran = await run_text(f"""{NAP}
modifier watch of nap:
    event reported(what: string)
    event half_way is @it.half
    on @start:
        emit reported("start")
    on @half_way:
        emit reported("half")
    on @reported as t if t.what == "half":
        emit reported("received")
    on @end:
        emit reported("end")
    on @fail:
        emit reported("fail")

scenario main:
    do nap(2s) with:
        watch()
""")
    reported = [(time, arguments["what"]) for time, arguments in emitted(ran, ".reported")]
    assert reported == [(0.0, "start"), (1.0, "half"), (1.0, "received"), (2.0, "end")]
    assert ran.verdict.passed


@pytest.mark.parametrize(
    ("directive", "status", "end"),
    [
        ("on elapsed(1s):\n        emit end", RunStatus.PASSED, 1.0),
        ("on elapsed(1s):\n        emit fail", RunStatus.FAILED, 1.0),
        ("on elapsed(3s):\n        emit fail", RunStatus.PASSED, 2.0),
    ],
)
@pytest.mark.parametrize("what", ["nap(2s)", "serial:\n        nap(2s)\n   "])
async def test_the_end_of_a_modifier_is_that_of_its_behavior(
    run_text: RunText, what: str, directive: str, status: RunStatus, end: float
) -> None:
    block = "with:\n        watch()\n"
    ran = await run_text(f"{NAP}modifier watch:\n    {directive}\n\nscenario main:\n    do {what} {block}")
    assert (ran.verdict.status, ran.verdict.duration) == (status, end)


async def test_a_modifier_lives_as_long_as_its_behavior(run_text: RunText) -> None:
    """An outer modifier restarts the inner one; the inner modifier applies to one run."""
    ran = await run_text(f"""{NAP}
modifier watch:
    var n: int = sample(n + 1, @tick)
    event tick is every(1s, offset: 1s)
    event last(n: int)
    on @end:
        emit last(n)

scenario main:
    do serial:
        nap(2s) with:
            watch()
            repeat(2)
        nap(2s) with:
            repeat(2)
            watch()
""")
    found = [(time, arguments["n"]) for time, arguments in emitted(ran, ".last")]
    assert found == [(4.0, 4), (6.0, 2), (8.0, 2)]


async def test_modifiers_of_a_scenario_and_nested_ones_react(run_text: RunText) -> None:
    ran = await run_text(f"""{NAP}
actor cat:
    name: string = "tom"

scenario cat.rest:
    purring()
    do nap(1s)

modifier cat.purring:
    event purr(name: string)
    deeply()
    on @start:
        emit purr(actor.name)

modifier deeply:
    event deep
    on elapsed(0.5s):
        emit deep

scenario main:
    c: cat
    do c.rest()
""")
    assert emitted(ran, ".purr") == [(0.0, {"name": "tom"})]
    assert emitted(ran, ".deep") == [(0.5, {})]


async def test_conditions_of_modifiers_use_variables_and_global_parameters(run_text: RunText) -> None:
    ran = await run_text("""
global most: int = 2

scenario count:
    var n: int = 0
    do serial:
        serial:
            wait elapsed(1s)
            increment(n)
        with:
            repeat(5)

modifier at_most of count:
    var seen: int = sample(it.n, rise(it.n > most))
    on it.n > most:
        emit fail
    cover(seen, event: fail, range: [0..3], every: 1)

scenario main:
    do count() with:
        at_most()
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 3.0)
    items = [(r["item"], r["value"]) for r in ran.records if r["kind"] == "cover"]
    assert items == [("seen", 3)]


async def test_items_of_modifiers_are_sampled_at_the_end_of_their_behavior(run_text: RunText) -> None:
    ran = await run_text(f"""{NAP}
modifier timed of nap:
    allowed: time
    record(allowed, unit: s)
    cover(slow, expression: it.length > allowed)
    record(pair, items: [allowed, slow])

scenario main:
    do serial:
        nap(1s) with:
            timed(3s)
        nap(4s) with:
            timed(2s)
""")
    found = [(r["t"], r["item"], r["value"]) for r in ran.records if r["kind"] in {"cover", "record"}]
    assert found == [
        (1.0, "allowed", 3.0),
        (1.0, "slow", False),
        (1.0, "pair", {"allowed": 3.0, "slow": False}),
        (5.0, "allowed", 2.0),
        (5.0, "slow", True),
        (5.0, "pair", {"allowed": 2.0, "slow": True}),
    ]
    grades = {item.item: item.grade for item in ran.verdict.coverage}
    assert grades["timed.slow"] == 1.0


# ---------------------------------------------------------------- cancelled behaviors


@pytest.mark.parametrize(
    ("modification", "phase"),
    [
        ("until elapsed(1s)", "end"),
        ("ending()", "end"),
        ("failing()", "fail"),
    ],
)
async def test_blocks_of_an_invocation_end_it_with_its_events(
    run_text: RunText, modification: str, phase: str
) -> None:
    """7.3.10.3: the end of the allotted time gives `fail`, the end of the execution gives `end`."""
    ran = await run_text(f"""
modifier ending:
    on elapsed(1s):
        emit end

modifier failing:
    on elapsed(1s):
        emit fail

scenario watched:
    event reported(what: string)
    record(n, expression: 1, event: {phase})
    on @end:
        emit reported("end")
    on @fail:
        emit reported("fail")
    do wait elapsed(5s)

scenario main:
    do serial:
        watched() with:
            failure_is_success()
            {modification}
        wait elapsed(1s)
""")
    assert emitted(ran, ".reported") == [(1.0, {"what": phase})]
    assert [r["t"] for r in ran.records if r["kind"] == "record"] == [1.0]


async def test_the_end_of_the_allotted_duration_is_a_failure(run_text: RunText) -> None:
    ran = await run_text("""
scenario watched:
    event reported(what: string)
    on @fail:
        emit reported("fail")
    on elapsed(1s):
        emit reported("last instant")
    do wait elapsed(5s)

scenario main:
    do serial:
        watched(duration: 1s) with:
            failure_is_success()
        wait elapsed(1s)
""")
    assert [arguments["what"] for _, arguments in emitted(ran, ".reported")] == ["last instant", "fail"]


async def test_a_cancelled_invocation_does_not_react(run_text: RunText) -> None:
    ran = await run_text("""
scenario watched:
    event reported(what: string)
    on @end:
        emit reported("end")
    on @fail:
        emit reported("fail")
    do wait elapsed(5s)

scenario main:
    do serial:
        one_of:
            watched()
            wait elapsed(1s)
        wait elapsed(1s)
""")
    assert emitted(ran, ".reported") == []
