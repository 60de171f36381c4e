"""Sampled variables of structs and actors."""

import pytest

from tests.runtime.accept.conftest import Traced, TraceText

METER = """
struct meter:
    event tick is every(1s, offset: 0.5s)
    var ticks: int = sample(ticks + 1, @tick, 0)
struct panel:
    left: meter
    right: meter
scenario worker:
    of: panel
    do wait elapsed(2s)
scenario main:
    p: panel
    do serial:
        wait elapsed(0.25s)
        worker(p)
"""


@pytest.fixture
async def traced(trace_text: TraceText) -> Traced:
    found = await trace_text(METER)
    acceptance = found.accept()
    assert (acceptance.violations, acceptance.unchecked) == ((), ())
    return found


async def test_a_struct_samples_from_the_start_of_its_first_scenario(traced: Traced) -> None:
    changes = [(record["t"], record["path"]) for record in traced.records if record["kind"] == "variable"]
    assert changes == [(t, f"p.{side}.ticks") for t in (0.5, 1.5) for side in ("left", "right")]


async def test_a_missing_sample_of_a_struct_is_rejected(traced: Traced) -> None:
    traced.drop(traced.find("variable", 2))
    assert traced.broken == {"sample"}
    assert "it reacts not at 1.5 s, but its event occurs once" in traced.messages


async def test_a_wrong_sample_of_a_struct_is_rejected(traced: Traced) -> None:
    traced.rewrite(5, 3)
    assert traced.broken == {"sample"}


async def test_a_sample_of_a_struct_at_another_time_is_rejected(traced: Traced) -> None:
    traced.move(traced.find("variable", 1), after=traced.start("worker"))
    assert "sample" in traced.broken


async def test_an_event_of_a_struct_at_another_time_is_rejected(traced: Traced) -> None:
    traced.move(traced.find("event", event="tick"), after=traced.start("worker"))
    assert traced.broken == {"event"}


async def test_an_event_of_a_struct_with_subscribers_occurs_once(traced: Traced) -> None:
    tick = traced.find("event", event="tick")
    twice = traced.copy()
    twice.insert(twice.find("event", event="tick"), **{**tick, "seq": 0})
    assert twice.broken == {"event"}
    traced.drop(tick)
    assert traced.broken == {"event"}
    assert "`tick` does not occur at 0.5 s, when a subscriber receives it" in traced.messages


async def test_a_struct_of_the_entry_scenario_samples_from_the_start_of_the_run(trace_text: TraceText) -> None:
    traced = await trace_text(METER.replace("wait elapsed(0.25s)", "log(1)"))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.drop(traced.find("variable", 2))
    assert traced.broken == {"sample"}


async def test_samples_of_a_struct_held_first_by_a_modifier_are_undecided(trace_text: TraceText) -> None:
    traced = await trace_text("""
struct meter:
    event tick is every(1s)
    var ticks: int = sample(ticks + 1, @tick, 0)
modifier careful of worker:
    with_it: meter
    keep(with_it == it.has)
    timeout(5s)
scenario worker:
    has: meter
    do wait elapsed(2s)
scenario main:
    do worker() with:
        careful()
""")
    assert traced.broken == set(), traced.messages
    assert "the trace does not show which scenario held a `meter` first" in {
        each.reason for each in traced.accept().unchecked
    }
    traced.drop(traced.find("variable"))
    assert traced.broken == set()
