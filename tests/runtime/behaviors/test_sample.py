"""`sample`: a variable takes a value whenever an event occurs (7.3.6.1.2)."""

from __future__ import annotations

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Ran, RunText


def changes(ran: Ran, path: str) -> list[tuple[float, object]]:
    """Return the times and values of changes of a variable."""
    return [(r["t"], r["value"]) for r in ran.records if r["kind"] == "variable" and r["path"] == path]


@pytest.mark.parametrize(
    ("specification", "values"),
    [
        ("sample(n, @go, 7)", [(0.0, 0), (2.0, 1)]),
        ("sample(n, @go if n > 0)", [(2.0, 1)]),
        ("sample(g.k, @go as g if g.k == 5)", [(0.0, 5)]),
        ("sample(n, rise(n == 1), 0)", [(1.0, 1)]),
        ("sample(seen + 1, every(1s, offset: 1s), 0)", [(1.0, 1), (2.0, 2), (3.0, 3)]),
        ("sample(n, elapsed(1.5s), 0)", [(1.5, 1)]),
    ],
)
async def test_a_sample_has_the_value_of_its_instant(
    run_text: RunText, specification: str, values: list[tuple[float, object]]
) -> None:
    ran = await run_text(f"""
scenario main:
    var n: int = 0
    event go(k: int)
    var seen: int = {specification}
    do serial:
        emit go(5)
        wait elapsed(1s)
        increment(n)
        wait elapsed(1s)
        emit go(6)
        wait elapsed(1s)
""")
    assert ran.verdict.passed
    assert changes(ran, "seen") == values


async def test_a_sampled_variable_resumes_waits_in_the_same_instant(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    var count: int = sample(count + 1, @go, 0)
    var double: int = sample(count * 2, rise(count > 1), 0)
    do parallel:
        serial:
            wait double == 4
            log("four")
        serial:
            wait elapsed(1s)
            emit go
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(2.0, "four")]
    assert changes(ran, "count") == [(1.0, 1), (2.0, 2)]


async def test_variables_of_structs_and_actors_start_with_their_first_scenario(
    run_text: RunText,
) -> None:
    ran = await run_text("""
struct meter:
    step: int = 2
    event tick is every(1s, offset: 1s)
    var ticks: int = sample(ticks + step, @tick, 0)
actor cart:
    gauge: meter
    var seconds: int = sample(seconds + 1, every(1s), 0)
scenario inner:
    c: cart
    do serial:
        wait c.gauge.ticks == 4
        log("inner")
scenario main:
    a: cart
    gauges: list of meter = [meter(step: 3)]
    do serial:
        wait elapsed(0.5s)
        inner(a)
        wait gauges[0].ticks == 9
        log(a.seconds == 4 ? "four" : "other")
""")
    assert ran.logs == [(2.0, "inner"), (3.0, "four")]
    assert changes(ran, "gauges[0].ticks") == [(1.0, 3), (2.0, 6), (3.0, 9)]


async def test_sampling_ends_with_its_scenario(run_text: RunText) -> None:
    ran = await run_text("""
scenario inner:
    var ticks: int = sample(ticks + 1, every(1s), 0)
    do wait elapsed(1.5s)
scenario main:
    do serial:
        inner()
        inner()
        wait elapsed(5s)
""")
    assert changes(ran, "ticks") == [(0.0, 1), (1.0, 2), (1.5, 1), (2.5, 2)]


async def test_a_value_that_cannot_be_computed_is_an_error(run_text: RunText) -> None:
    verdict = (
        await run_text("""
scenario main:
    var n: int = 0
    var seen: int = sample(6 / n, elapsed(1s), 0)
    do wait elapsed(2s)
""")
    ).verdict
    assert verdict.status is RunStatus.ERROR
    assert verdict.duration == 1.0
