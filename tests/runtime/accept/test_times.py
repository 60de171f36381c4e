"""Constraints on times, and what modifiers, structs and actors do by themselves."""

import pytest

from tests.runtime.accept.conftest import Traced, TraceText

NAP = "scenario nap:\n    length: time\n    do wait elapsed(length)\n\n"
WITHIN = NAP + "scenario main:\n    do {behavior}\n    with:\n        keep({condition})\n"


def end_at(traced: Traced, behaviors: list[tuple[str, int]], by: float) -> None:
    """Let behaviors, and the run, end later by some seconds."""
    first = min((traced.end(*each) for each in behaviors), key=lambda record: record["seq"])
    traced.shift(first, by)


def start_of(behavior: str) -> str:
    return f"{behavior}:\n        nap(2s)"


@pytest.mark.parametrize(
    "condition", ["it.duration >= 5s", "it.duration in [5s..9s]", "it.duration.lower() == 5s"]
)
@pytest.mark.parametrize("behavior", ["serial", "one_of"])
async def test_what_is_to_last_longer_ends_in_time(trace_text: TraceText, behavior: str, condition: str) -> None:
    traced = await trace_text(WITHIN.format(behavior=start_of(behavior), condition=condition))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    end_at(traced, [(behavior, 0)], -1)
    assert traced.broken == {"duration"}
    assert "it lasts 4 s, and should at least 5 s" in traced.messages


@pytest.mark.parametrize(
    ("condition", "most"),
    [("it.duration <= 1.5s", 1.5), ("it.duration < 1.5s", 1.499999999), ("not (it.duration.upper() > 1.5s)", 1.5)],
)
async def test_what_lasts_too_long_fails_in_time(trace_text: TraceText, condition: str, most: float) -> None:
    traced = await trace_text(WITHIN.format(behavior=start_of("serial"), condition=condition))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    assert traced.end("serial")["t"] == most
    late = traced.copy()
    late.shift(late.end("wait"), 0.25)
    assert "it lasts 1.75 s, and should at most 1.5 s" in late.messages
    early = traced.copy()
    early.shift(early.end("wait"), -0.25)
    assert "duration" in early.broken
    assert "it failed at 1.25 s, with nothing that has failed, and may last until 1.5 s" in early.messages


async def test_constraints_of_modifiers_with_values_of_theirs_and_of_what_they_modify(
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
    assert "it lasts 2.5 s, and should at least 3 s" in traced.messages


async def test_constraints_that_compute_with_times_are_told_as_not_checked(trace_text: TraceText) -> None:
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
    assert "it did not go on at 2 s" in traced.messages, "all else is checked"


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("it.start_to_start == 1s", "`b` starts 1.5 s after the primary member"),
        ("it.start_to_start in [0.5s..1s]", "`b` starts"),
        ("it.overlap == start", "`b` starts at 0.5 s, and not at 0 s"),
    ],
)
async def test_constraints_on_how_members_lie(trace_text: TraceText, condition: str, message: str) -> None:
    members = "parallel:\n        a: nap(4s)\n        b: nap(2s)"
    traced = await trace_text(WITHIN.format(behavior=members, condition=condition))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.shift(traced.start("b"), 0.5)
    assert "parallel" in traced.broken
    assert message in traced.messages


async def test_an_offset_of_ends_that_is_not_kept(trace_text: TraceText) -> None:
    members = "parallel:\n        a: nap(4s)\n        b: nap(3s)"
    traced = await trace_text(WITHIN.format(behavior=members, condition="it.end_to_end in [-1s..1s]"))
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.shift(traced.end("a"), 0.5)
    assert "`b` ended before the primary member, which ran on" in traced.messages


# ---------------------------------------------------------------- reactions at an end


async def test_a_reaction_to_an_end_that_comes_from_around(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario watched:
    event told
    on @end:
        emit told
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
    silent.drop(silent.find("event", event="told"))
    assert "does not occur when it is emitted" in silent.messages
    alone = traced.copy()
    alone.drop_behavior("emit")
    assert "`told` occurs at 1 s, and nothing emits it" in alone.messages
    traced.shift(traced.end("wait", 1), 0.5)
    assert "wait" in traced.broken, "all else is checked"


async def test_the_end_of_what_an_until_ends_occurs(trace_text: TraceText) -> None:
    traced = await trace_text(f"{NAP}scenario main:\n    do nap(5s) with:\n        until elapsed(1s)\n")
    assert (traced.accept().violations, traced.accept().unchecked) == ((), ())
    traced.drop(traced.find("event", event="end"))
    assert "it succeeded, and neither `end` nor `fail` occurs" in traced.messages


@pytest.mark.parametrize("condition", ["level > 1", "rise(level > 1)", "fall(level < 2)"])
async def test_an_event_that_is_a_condition_occurs_when_that_holds(trace_text: TraceText, condition: str) -> None:
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
    assert "`full` occurs at 1 s, and its condition has another value" in traced.messages


@pytest.mark.parametrize(
    "listener", ["wait @r.close", "until @r.close", "on @r.close:\n        call r.size()", "@shown"]
)
@pytest.mark.parametrize("condition", ["elapsed(2s)", "every(5s, offset: 2s)", "elapsed([1.5s..2.5s])"])
async def test_a_derived_event_occurs_when_someone_hears_it(
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
    assert "`close` occurs at 0 s, and nobody who listens hears it then" in traced.messages


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
async def test_a_modifier_ends_what_it_modifies_only_when_it_says_so(
    trace_text: TraceText, phase: str, other: str
) -> None:
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
    assert "before all of it was carried out" in early.messages
    traced.end("guard")["status"] = other
    traced.end("serial")["status"] = other
    assert f"`guard` {other}, and ends itself otherwise" in traced.messages


async def test_what_a_modifier_of_an_actor_modifies_is_checked(trace_text: TraceText) -> None:
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
    assert "before all of it was carried out" in traced.messages


async def test_a_limit_that_an_actor_sets_is_checked(trace_text: TraceText) -> None:
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
    assert "what it modifies lasts longer than 2 s" in traced.messages
