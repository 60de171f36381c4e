"""Conditions of event specifications: their evaluation and their occurrences (7.3.10.4)."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang.plan import Expression
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Value
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


async def times(run_text: RunText, waited: str, changes: str = "increment(n)") -> list[float]:
    """Return the end times of a wait that is repeated at once, with changes at 0 s, 1 s and so on."""
    steps = "".join(f"            {change}\n            wait elapsed(1s)\n" for change in changes.split("; "))
    text = f"""
scenario main:
    var n: int = 0
    event go
    do parallel:
        serial:
            wait {waited}
            log("met")
        serial:
{steps}
"""
    return [time for time, _ in (await run_text(text)).logs]


@pytest.mark.parametrize(
    ("waited", "when"),
    [
        ("n == 0", [0.0]),
        ("n == 2", [1.0]),
        ("not (n < 3)", [2.0]),
        ("rise(n >= 0)", []),
        ("rise(n == 2)", [1.0]),
        ("fall(n == 0)", [0.0]),
        ("fall(n == 1)", [1.0]),
        ("elapsed(1500ms)", [1.5]),
        ("every(2s)", [0.0]),
        ("every(2s, offset: 0.5s)", [0.5]),
    ],
)
async def test_a_wait_ends_when_its_condition_occurs(run_text: RunText, waited: str, when: list[float]) -> None:
    assert await times(run_text, waited, "increment(n); increment(n); increment(n)") == when


async def test_changes_of_one_delta_cycle_take_effect_together(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var n: int = 0
    do parallel:
        serial:
            one_of:
                serial:
                    wait n == 1
                    log("in between")
                serial:
                    wait n == 2
                    log("both")
        serial:
            wait elapsed(1s)
            parallel:
                increment(n)
                increment(n)
""")
    assert ran.logs == [(1.0, "both")]


@pytest.mark.parametrize(
    ("condition", "when"),
    [
        ("n == 2", 2.0),
        ("rise(n == 3)", 3.0),
        ("fall(n <= 1)", 2.0),
        ("elapsed(2.5s)", 3.0),
        ("every(1.5s, offset: 0.5s)", 2.0),
    ],
)
async def test_the_condition_of_an_event_is_evaluated_when_it_occurs(
    run_text: RunText, condition: str, when: float
) -> None:
    ran = await run_text(f"""
scenario main:
    var n: int = 0
    event go
    do parallel:
        serial:
            wait @go if {condition}
            log("met")
        serial:
            wait elapsed(1s)
            parallel:
                emit go
                increment(n)
            wait elapsed(1s)
            parallel:
                increment(n)
                emit go
            wait elapsed(1s)
            parallel:
                increment(n)
                emit go
""")
    assert ran.logs == [(when, "met")]


async def test_a_condition_may_use_actors_structs_and_methods(run_text: RunText) -> None:
    ran = await run_text("""
struct box:
    var full: bool = false
actor cart:
    var load: int = 0
    inside: box
    def heavy() -> bool is expression load > 1 and inside.full == false
scenario main:
    a: cart
    do parallel:
        serial:
            wait a.heavy()
            log("heavy")
        serial:
            increment(a.load)
            wait elapsed(2s)
            increment(a.load)
""")
    assert ran.logs == [(2.0, "heavy")]


async def test_a_condition_is_evaluated_only_after_a_change_of_its_variables(
    run_text: RunText, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []

    def counted(expression: Expression, environment: Environment) -> Value:
        seen.append(expression.span.text)
        return evaluate(expression, environment)

    monkeypatch.setattr("seoro.runtime.events.conditions.evaluate", counted)
    ran = await run_text("""
scenario main:
    var n: int = 0
    var other: int = 0
    do parallel:
        wait n == 2 and other == 3
        serial:
            increment(other)
            wait elapsed(1h)
            increment(n)
            wait elapsed(1h)
            increment(n)
            wait elapsed(1h)
            increment(other)
            increment(other)
""")
    assert ran.verdict.passed
    assert seen.count("n == 2 and other == 3") == 5, "other is read only when n is 2"


async def test_a_condition_of_unknown_inputs_is_polled_while_it_is_waited_for(
    run_text: RunText, tmp_path: Path
) -> None:
    (tmp_path / "checks.py").write_text(
        "calls = 0\n\ndef ready() -> bool:\n    global calls\n    calls += 1\n    return calls > 5\n\n"
        "def count() -> int:\n    return calls\n"
    )
    ran = await run_text("""
scenario main:
    def ready() -> bool is external checks.ready()
    def count() -> int is external checks.count()
    do serial:
        wait ready()
        log("ready")
        wait elapsed(1h)
        log(count() == 6 ? "no more" : "still polled")
""")
    assert ran.logs == [(0.1, "ready"), (3600.1, "no more")]


async def test_impossible_events_are_reported(run_text: RunText) -> None:
    verdict = (await run_text("scenario main:\n    var n: int = 0\n    do wait n == 1\n")).verdict
    assert verdict.status is RunStatus.FAILED
    assert "nothing can happen any more; still waiting for: `wait n == 1`" in verdict.reason


@pytest.mark.parametrize(
    ("waited", "place"),
    [
        ("6 / n == 0", "6 / n"),
        ("@go if 6 / n == 0", "6 / n"),
        ("elapsed(6s / n)", "6s / n"),
        ("elapsed(n * 1s - 1s)", "n * 1s - 1s"),
        ("every(0s * n)", "0s * n"),
    ],
)
async def test_a_condition_without_a_value_is_an_error(run_text: RunText, waited: str, place: str) -> None:
    ran = await run_text(f"""
scenario main:
    var n: int = 0
    event go
    do parallel:
        wait {waited}
        serial:
            emit go
            wait elapsed(1s)
""")
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.span is not None
    assert ran.verdict.span.text == place


@pytest.mark.parametrize(
    ("condition", "met"),
    [
        ("rise(g.n > m)", [2.0, 5.0]),
        ("fall(g.n > m)", [3.0]),
        ("rise(g.n > 0)", []),
        ("every(g.n * 1s)", [1.0, 2.0, 3.0, 4.0, 5.0]),
        ("every(2s, offset: g.n * 1s)", [1.0, 2.0, 3.0, 5.0]),
        ("elapsed(g.n * 1s)", [1.0, 2.0, 3.0, 4.0, 5.0]),
    ],
)
async def test_conditions_compare_occurrences_with_earlier_ones(
    run_text: RunText, condition: str, met: list[float]
) -> None:
    """Each occurrence is compared with earlier ones, and has its own deadlines."""
    ran = await run_text(f"""
scenario main:
    m: int = 1
    event go(n: int)
    event met
    on @go as g if {condition}:
        emit met
    do serial:
        wait elapsed(1s)
        emit go(1)
        wait elapsed(1s)
        emit go(2)
        wait elapsed(1s)
        emit go(1)
        wait elapsed(1s)
        emit go(1)
        wait elapsed(1s)
        emit go(5)
        wait elapsed(1s)
""")
    found = [r["t"] for r in ran.records if r["kind"] == "event" and r["name"] == "main.met"]
    assert found == met


async def test_occurrences_of_one_instant_are_compared_with_earlier_instants(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go(n: int)
    event met(n: int)
    on @go as g if rise(g.n > 1):
        emit met(g.n)
    do serial:
        parallel:
            emit go(1)
            emit go(3)
        wait elapsed(1s)
        parallel:
            emit go(2)
            emit go(4)
        wait elapsed(1s)
        emit go(5)
""")
    met = [(r["t"], r["arguments"]["n"]) for r in ran.records if r["kind"] == "event" and r["name"] == "main.met"]
    assert met == [(1.0, 2), (1.0, 4)]
