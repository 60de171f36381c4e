"""Constraints on times, and reactions of modifiers, structs and actors."""

import pytest

from tests.runtime.accept.conftest import Traced, TraceText

NAP = "scenario nap:\n    length: time\n    do wait elapsed(length)\n\n"
WITHIN = NAP + "scenario main:\n    do {behavior}\n    with:\n        keep({condition})\n"


def end_at(traced: Traced, behaviors: list[tuple[str, int]], by: float) -> None:
    """Delay the ends of behaviors and of the run by some seconds."""
    first = min((traced.end(*each) for each in behaviors), key=lambda record: record["seq"])
    traced.shift(first, by)


def start_of(behavior: str) -> str:
    return f"{behavior}:\n        nap(2s)"


@pytest.mark.parametrize(
    "condition", ["it.duration >= 5s", "it.duration in [5s..9s]", "it.duration.lower() == 5s"]
)
@pytest.mark.parametrize("behavior", ["serial", "one_of"])
async def test_a_behavior_with_a_lower_bound_that_ends_early_is_rejected(
    trace_text: TraceText, behavior: str, condition: str
) -> None:
    traced = await trace_text(WITHIN.format(behavior=start_of(behavior), condition=condition))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    end_at(traced, [(behavior, 0)], -1)
    assert traced.broken == {"duration"}
    assert "it lasts 4 s; expected at least 5 s" in traced.messages


@pytest.mark.parametrize(
    ("condition", "most"),
    [("it.duration <= 1.5s", 1.5), ("it.duration < 1.5s", 1.499999999), ("not (it.duration.upper() > 1.5s)", 1.5)],
)
async def test_a_behavior_that_lasts_too_long_must_fail_in_time(
    trace_text: TraceText, condition: str, most: float
) -> None:
    traced = await trace_text(WITHIN.format(behavior=start_of("serial"), condition=condition))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    assert traced.end("serial")["t"] == most
    late = traced.copy()
    late.shift(late.end("wait"), 0.25)
    assert "it lasts 1.75 s; expected at most 1.5 s" in late.messages
    early = traced.copy()
    early.shift(early.end("wait"), -0.25)
    assert "duration" in early.broken
    assert (
        "it failed at 1.25 s, but none of its content has failed; expected to last until 1.5 s" in early.messages
    )


async def test_constraints_of_modifiers_with_own_values_and_the_duration_are_checked(
    trace_text: TraceText,
) -> None:
    traced = await trace_text(f"""{NAP}
modifier longer of nap:
    most: time
    keep(it.duration >= most)
    keep(it.duration > it.length)

scenario main:
    do nap(2s) with:
        longer(3s)
""")
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.shift(traced.end("longer"), -0.5)
    assert "it lasts 2.5 s; expected at least 3 s" in traced.messages


async def test_constraints_that_compute_with_times_are_reported_as_unchecked(trace_text: TraceText) -> None:
    traced = await trace_text(
        WITHIN.format(
            behavior="serial:\n        nap(2s)\n        nap(1s)", condition="it.duration.lower() - 1s > 3s"
        )
    )
    assert traced.broken == set(), traced.messages
    [unchecked] = traced.accept().unchecked
    assert unchecked.reason == "a constraint computes with times"
    traced.shift(traced.end("serial"), -0.5)
    assert traced.broken == set()
    traced.drop_behavior("nap", 1)
    assert "it stopped at 2 s" in traced.messages, "all else is checked"


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("it.start_to_start == 1s", "`b` starts 1.5 s after the primary member"),
        ("it.start_to_start in [0.5s..1s]", "`b` starts"),
        ("it.overlap == start", "`b` starts at 0.5 s; expected 0 s"),
    ],
)
async def test_violated_constraints_on_overlaps_are_rejected(
    trace_text: TraceText, condition: str, message: str
) -> None:
    members = "parallel:\n        a: nap(4s)\n        b: nap(2s)"
    traced = await trace_text(WITHIN.format(behavior=members, condition=condition))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.shift(traced.start("b"), 0.5)
    assert "parallel" in traced.broken
    assert message in traced.messages


async def test_a_violated_offset_of_ends_is_rejected(trace_text: TraceText) -> None:
    members = "parallel:\n        a: nap(4s)\n        b: nap(3s)"
    traced = await trace_text(WITHIN.format(behavior=members, condition="it.end_to_end in [-1s..1s]"))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.shift(traced.end("a"), 0.5)
    assert "`b` ended before the primary member, which was still running" in traced.messages


# ---------------------------------------------------------------- reactions at an end


async def test_a_reaction_to_an_end_from_an_outer_behavior_is_checked(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario watched:
    event reported
    on @end:
        emit reported
    do wait elapsed(5s)

scenario main:
    do serial:
        watched() with:
            failure_is_success()
            until elapsed(1s)
        wait elapsed(1s)
""")
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    silent = traced.copy()
    silent.drop(silent.find("event", event="reported"))
    assert "does not occur when it is emitted" in silent.messages
    alone = traced.copy()
    alone.drop_behavior("emit")
    assert "`reported` occurs at 1 s without an `emit`" in alone.messages
    traced.shift(traced.end("wait", 1), 0.5)
    assert "wait" in traced.broken, "all else is checked"


async def test_a_behavior_ended_by_until_has_an_end_event(trace_text: TraceText) -> None:
    traced = await trace_text(f"{NAP}scenario main:\n    do nap(5s) with:\n        until elapsed(1s)\n")
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.drop(traced.find("event", event="end"))
    assert "it succeeded, but neither `end` nor `fail` occurs" in traced.messages


@pytest.mark.parametrize("condition", ["level > 1", "rise(level > 1)", "fall(level < 2)"])
async def test_an_event_of_a_condition_occurs_when_it_holds(trace_text: TraceText, condition: str) -> None:
    traced = await trace_text(f"""
actor tank:
    var level: int = 0
    event full is {condition}

scenario main:
    t: tank
    do parallel:
        wait @t.full
        serial:
            wait elapsed(1s)
            increment(t.level)
            wait elapsed(1s)
            increment(t.level)
""")
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.move(traced.find("event", event="full"), traced.end("wait", 1))
    assert "`full` occurs at 1 s, but its condition does not hold" in traced.messages


@pytest.mark.parametrize(
    "listener", ["wait @r.close", "until @r.close", "on @r.close:\n        call r.size()", "@shown"]
)
@pytest.mark.parametrize("condition", ["elapsed(2s)", "every(5s, offset: 2s)", "elapsed([1.5s..2.5s])"])
async def test_a_derived_event_occurs_with_a_subscriber_only(
    trace_text: TraceText, condition: str, listener: str
) -> None:
    text = f"""
actor robot:
    event close is {condition}
    def size() -> int is expression 1

scenario main:
    r: robot
    event shown is @r.close if true
"""
    text += f"    {listener}\n" if listener.startswith("on") else ""
    text += "    do parallel:\n        wait elapsed(3s)\n"
    if listener.startswith("wait"):
        text += f"        {listener}\n"
    elif listener.startswith("until"):
        text += f"        serial:\n            wait elapsed(9s)\n        with:\n            {listener}\n"
    elif listener.startswith("@"):
        text += f"        wait {listener}\n"
    traced = await trace_text(text)
    assert traced.broken == set(), traced.messages
    event = traced.find("event", event="close")
    assert event["derived"]
    traced.move(event, traced.find("behavior.start", 1))
    assert traced.broken == {"event"}
    assert "`close` occurs at 0 s, but no subscriber receives it then" in traced.messages


# ---------------------------------------------------------------- modifiers that react, and those of actors

GUARD = """
modifier {of}guard:
    event seen
    on @start:
        emit seen
    on elapsed(2s):
        emit {phase}

"""


@pytest.mark.parametrize(("phase", "other"), [("end", "failed"), ("fail", "succeeded")])
async def test_an_end_by_a_modifier_needs_its_emit(trace_text: TraceText, phase: str, other: str) -> None:
    traced = await trace_text(f"""{GUARD.format(of="", phase=phase)}
scenario main:
    do serial:
        wait elapsed(3s)
    with:
        guard()
""")
    assert traced.broken == set(), traced.messages
    assert {each.rule.title for each in traced.accept().unchecked} == {"modifier"}
    early = traced.copy()
    early.drop_behavior("emit", 1)
    assert "before its content has ended" in early.messages
    traced.end("guard")["status"] = other
    traced.end("serial")["status"] = other
    assert f"`guard` {other}, but its own `emit` ends it otherwise" in traced.messages


async def test_behaviors_with_a_modifier_of_an_actor_are_checked(trace_text: TraceText) -> None:
    traced = await trace_text(f"""{GUARD.format(of="cat.", phase="end")}
actor cat:
    guard()

scenario cat.rest:
    do serial:
        wait elapsed(1s)
        wait elapsed(4s)

scenario main:
    c: cat
    do c.rest()
""")
    assert traced.broken == set(), traced.messages
    assert {each.rule.title for each in traced.accept().unchecked} == {"modifier", "value"}
    late = traced.copy()
    late.shift(late.end("wait"), 0.5)
    assert "wait" in late.broken
    traced.drop_behavior("emit", 1)
    assert "before its content has ended" in traced.messages


async def test_a_limit_of_an_actor_is_checked(trace_text: TraceText) -> None:
    traced = await trace_text("""
struct battery:
    life: time
    timeout(life)

scenario main:
    b: battery
    keep(b.life == 2s)
    do wait elapsed(5s)
""")
    assert traced.broken == set(), traced.messages
    traced.shift(traced.end("wait"), 1)
    assert "the behavior lasts longer than 2 s" in traced.messages
