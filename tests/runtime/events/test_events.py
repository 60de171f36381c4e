"""Events: occurrences, instants and causal pasts."""

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


@pytest.mark.parametrize("members", [("emit go", "wait @go"), ("wait @go", "emit go")])
async def test_emitting_and_waiting_meet_in_either_order(run_text: RunText, members: tuple[str, str]) -> None:
    text = "\n".join(f"        {member}" for member in members)
    ran = await run_text(f"scenario main:\n    event go\n    do parallel:\n{text}\n")
    assert ran.verdict.passed
    assert ran.verdict.duration == 0.0


async def test_a_wait_later_in_the_instant_receives_the_event(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        emit go
        serial:
            wait elapsed(0s)
            wait elapsed(0s)
            wait @go
            log("met")
""")
    assert ran.logs == [(0.0, "met")]


async def test_emissions_of_a_task_are_past_for_itself(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            emit go
            wait @go
            log("the next one")
        serial:
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(1.0, "the next one")]


async def test_two_waits_in_a_row_need_two_instants(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            wait @go
            wait @go
            log("twice")
        emit go
        emit go
        serial:
            wait elapsed(3s)
            emit go
""")
    assert ran.logs == [(3.0, "twice")]


async def test_occurrences_of_one_instant_have_no_order(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event one
    event two
    do parallel:
        serial:
            emit one
            emit two
        serial:
            wait @two
            wait @one
            log("both")
""")
    assert ran.logs == [(0.0, "both")]


async def test_a_task_that_joins_others_has_their_past(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            parallel:
                emit go
                wait elapsed(0s)
            wait @go
            log("the next one")
        serial:
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(1.0, "the next one")]


async def test_events_are_not_latched(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do serial:
        emit go
        wait elapsed(1s)
        wait @go
""")
    assert ran.verdict.status is RunStatus.FAILED
    assert "nothing can happen any more" in ran.verdict.reason
    assert "`wait @go`" in ran.verdict.reason


async def test_occurrences_differ_by_arguments_and_conditions_select_them(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event done(part: int)
    do parallel:
        serial:
            wait @done as which if which.part == 2
            log("two")
        serial:
            emit done(1)
            wait elapsed(1s)
            emit done(2)
""")
    assert ran.logs == [(1.0, "two")]
    assert [(r["t"], r["arguments"]) for r in ran.records if r["kind"] == "event" and r["arguments"]] == [
        (0.0, {"part": 1}),
        (1.0, {"part": 2}),
    ]


async def test_labels_have_start_and_end(run_text: RunText) -> None:
    ran = await run_text("""
scenario worker:
    do wait elapsed(2s)

scenario main:
    do parallel:
        serial:
            wait elapsed(1s)
            w: worker()
        serial:
            wait @w.start
            log("started")
            wait @w.end
            log("ended")
""")
    assert ran.logs == [(1.0, "started"), (3.0, "ended")]


async def test_a_failing_label_has_fail(run_text: RunText) -> None:
    ran = await run_text("""
scenario broken:
    do emit fail

scenario main:
    do parallel:
        one_of:
            b: broken()
            serial:
                wait elapsed(1s)
                log("other")
        serial:
            wait @b.fail
            log("it failed")
""")
    assert ran.logs == [(0.0, "it failed"), (1.0, "other")]


async def test_a_condition_without_a_value_is_an_error_with_its_position(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event done(part: int)
    do parallel:
        serial:
            wait @done as which if 6 / which.part == 2
            log("never")
        serial:
            wait elapsed(1s)
            emit done(0)
            wait elapsed(9s)
""")
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.duration == 1.0
    assert ran.verdict.span is not None
    assert ran.verdict.span.text == "6 / which.part"


async def test_events_of_successive_instances_in_an_instant_are_distinct(
    run_text: RunText,
) -> None:
    ran = await run_text("""
scenario inner:
    event done
    do emit done

scenario main:
    do serial:
        inner()
    with:
        repeat(50)
""")
    occurred = [record["name"].rpartition(".")[2] for record in ran.records if record["kind"] == "event"]
    assert {name: occurred.count(name) for name in ("start", "done", "end")} == {
        "start": 51,
        "done": 50,
        "end": 51,
    }


async def test_occurrences_of_one_delta_cycle_are_consumed_in_the_order_of_arguments(run_text: RunText) -> None:
    for emissions in ((1, 2), (2, 1)):
        ran = await run_text(f"""
scenario main:
    event reported(level: int)
    do parallel:
        emit reported({emissions[0]})
        emit reported({emissions[1]})
        serial:
            wait @reported
            wait @reported as it_was if it_was.level == 2
            log("two")
""")
        assert ran.logs == [(0.0, "two")]


async def test_an_emission_of_a_base_uses_the_defaults_of_the_derived_type(
    run_text: RunText,
) -> None:
    ran = await run_text("""
scenario base:
    level: int = 4
    event reported(n: int, level: int = level, note: string = "base")
    do serial:
        wait elapsed(1s)
        emit reported(1)

scenario derived inherits base:
    event reported(n: int, level: int, note: string = "derived")

scenario main:
    do parallel:
        x: base()
        y: derived(level: 5)
        serial:
            wait @x.reported as e if e.note == "base" and e.level == 4
            log("base")
        serial:
            wait @y.reported as e if e.note == "derived" and e.level == 5
            log("derived")
""")
    assert sorted(message for _, message in ran.logs) == ["base", "derived"]
