"""Events in the plan: paths, conditions, derived events, and the directives that use them."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang import plan
from tests.lang.helpers import lower, messages

TEXT = """
import osc.types

struct bell:
    period: time = 2s
    event rung(volume: int)
    event due is elapsed(period)

actor cat:
    bell: bell
    event woken

scenario cat.nap:
    event dreaming
    do inner: wait elapsed(1s)

global loud: bell

scenario main:
    c: cat
    event go(level: int = 3)
    do parallel:
        phase: serial:
            w: c.nap()
            pause: wait elapsed(1s)
        wait @EVENT
"""


def event_of(folder: Path, path: str, text: str = TEXT) -> plan.EventSpecification:
    """Return the event of the last `wait` in a scenario."""
    body = lower(folder, text.replace("EVENT", path)).scenarios["main"].body
    assert isinstance(body, plan.Parallel)
    last = body.members[-1]
    assert isinstance(last, plan.Wait)
    return last.event


def reference_of(folder: Path, path: str) -> plan.EventReference:
    event = event_of(folder, path)
    assert isinstance(event, plan.OnEvent)
    return event.event


def shown(reference: plan.EventReference) -> object:
    """Return a reference without its spans."""
    match reference:
        case plan.DeclaredEvent(name):
            return name
        case plan.PhaseEvent(label, phase):
            return (label, phase.value)
        case plan.MemberEvent(base, event):
            return (type(base).__name__, base.span.text, shown(event))
        case plan.LabelEvent(label, event):
            return {label: shown(event)}


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("go", "go"),
        ("it.go", "go"),
        ("end", (None, "end")),
        ("pause.end", ("pause", "end")),
        ("w.start", ("w", "start")),
        ("phase.pause.fail", ("pause", "fail")),
        ("phase.w.dreaming", {"w": "dreaming"}),
        ("w.dreaming", {"w": "dreaming"}),
        ("w.inner.end", {"w": ("inner", "end")}),
        ("w.actor.woken", {"w": ("Binding", "actor", "woken")}),
        ("c.woken", ("Field", "c", "woken")),
        ("c.bell.due", ("Member", "c.bell", "due")),
        ("loud.due", ("Global", "loud", "due")),
    ],
)
def test_paths_lead_to_events(path: str, expected: object, tmp_path: Path) -> None:
    assert shown(reference_of(tmp_path, path)) == expected


def test_labels_are_resolved_in_the_invoked_scenario(tmp_path: Path) -> None:
    text = TEXT.replace("do inner:", "do other:")
    assert messages(tmp_path, text.replace("EVENT", "w.inner.end")) == [(26, "E0409")]


@pytest.mark.parametrize(
    ("condition", "kind"),
    [
        ("c.bell.period > 1s", plan.Holds),
        ("rise(c.bell.period > 1s)", plan.Rise),
        ("fall(c.bell.period > 1s)", plan.Fall),
        ("elapsed([1s..2s])", plan.Elapsed),
        ("every(2s, offset: 500ms)", plan.Every),
    ],
)
def test_each_condition_is_accepted_alone_and_after_an_event(condition: str, kind: type, tmp_path: Path) -> None:
    assert isinstance(event_of(tmp_path, "", TEXT.replace("@EVENT", condition)), kind)
    behind = event_of(tmp_path, f"go as g if {condition}")
    assert isinstance(behind, plan.OnEvent) and isinstance(behind.condition, kind)
    assert behind.name == "g"


def test_an_every_condition_may_omit_its_offset(tmp_path: Path) -> None:
    found = event_of(tmp_path, "", TEXT.replace("@EVENT", "every(2s)"))
    assert isinstance(found, plan.Every) and found.offset is None


def test_derived_events_have_their_specification(tmp_path: Path) -> None:
    text = """
import osc.types

struct bell:
    period: time = 2s
    event due is elapsed(period)

scenario base:
    event late is @end
    event plain

scenario main inherits base:
    n: int = 1
    event late is n > 3
    do emit plain
"""
    made = lower(tmp_path, text, scenario="main")
    late, plain = made.scenarios["main"].events
    assert isinstance(late.specification, plan.Holds) and plain.specification is None
    (due,) = made.objects["bell"].events
    assert isinstance(due.specification, plan.Elapsed)
    assert isinstance(due.specification.duration, plan.Field)


def test_on_directives_are_inherited_first_and_extended_last(tmp_path: Path) -> None:
    text = """
import osc.types

scenario base:
    event one
    event two(n: int)
    def note(n: int) is undefined
    on @one:
        emit end

scenario main inherits base:
    on @two as t if t.n > 1:
        emit two(t.n - 1)
        call note(t.n)
    do wait elapsed(1s)

extend main:
    on every(1s):
        emit one
"""
    first, second, third = lower(tmp_path, text, scenario="main").scenarios["main"].on
    (end,) = first.members
    assert isinstance(end, plan.Emit) and isinstance(end.event, plan.PhaseEvent)
    emitted, called = second.members
    assert isinstance(emitted, plan.Emit) and isinstance(called, plan.CallMethod)
    assert called.call.receiver is None
    assert isinstance(third.event, plan.Every)


def test_a_called_method_may_have_a_result(tmp_path: Path) -> None:
    text = """
struct tool:
    def note(n: int = 2) is undefined
    def size() -> int is expression 3

scenario main:
    t: tool
    do serial:
        noted: call t.note()
        call t.size()
"""
    body = lower(tmp_path, text).scenarios["main"].body
    assert isinstance(body, plan.Serial)
    noted, sized = body.members
    assert isinstance(noted, plan.CallMethod) and isinstance(sized, plan.CallMethod)
    assert noted.label == "noted" and isinstance(noted.call.receiver, plan.Field)
    assert messages(tmp_path, text.replace("call t.size()", "wait t.note() > 1")) == [(10, "E0343")]


def test_defaults_of_emitted_events_are_those_of_their_declaration(tmp_path: Path) -> None:
    text = "scenario main:\n    n: int = 1\n    event go(n: int, m: int = n + 1)\n    do emit go(7)\n"
    main = lower(tmp_path, text).scenarios["main"]
    assert isinstance(main.body, plan.Emit)
    m = main.events[0].all_arguments(main.body.arguments)["m"]
    assert isinstance(m, plan.Arithmetic) and isinstance(m.left, plan.Field)


def test_until_is_accepted_in_blocks_of_compositions_and_invocations(tmp_path: Path) -> None:
    text = """
import osc.types

scenario nap:
    do wait elapsed(1s)

scenario main:
    event stop(n: int)
    do serial:
        nap() with:
            until elapsed(3s)
            until @stop as s if s.n > 2
        last: nap()
    with:
        until @last.end
"""
    body = lower(tmp_path, text, scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Serial)
    (until,) = body.modifications
    assert isinstance(until, plan.Until) and isinstance(until.event, plan.OnEvent)
    invoked = body.members[0]
    assert isinstance(invoked, plan.InvokeScenario)
    untils = [found for found in invoked.modifications if isinstance(found, plan.Until)]
    assert [type(found.event) for found in untils] == [plan.Elapsed, plan.OnEvent]


def test_an_unknown_event_causes_no_further_messages(tmp_path: Path) -> None:
    text = "scenario main:\n    on @gone as g if g.n > 1:\n        emit end(g.m)\n"
    assert messages(tmp_path, text) == [(2, "E0408"), (3, "E0404")]


def test_a_sampled_variable_takes_the_value_of_its_expression(tmp_path: Path) -> None:
    text = """
import osc.types
actor car:
    var speed: speed
    event bumped(force: float)
scenario main:
    c: car
    var force: float = sample(b.force, @c.bumped as b if b.force > 1.0, 2.0)
    var at_end: speed = sample(c.speed, @slow.end)
    do serial:
        slow: wait elapsed(1s)
"""
    made = lower(tmp_path, text).scenarios["main"]
    assert [sample.field for sample in made.samples] == ["force", "at_end"]
    assert isinstance(made.samples[0].value, plan.Member)
    assert isinstance(made.samples[1].event, plan.OnEvent)
    first = made.structure.fields["force"].default
    assert isinstance(first, plan.Literal) and first.value == 2.0


@pytest.mark.parametrize(
    ("value", "code"),
    [
        ("sample(3m, every(1s))", "E0301"),
        ("sample(1.0, @nothing)", "E0408"),
        ("sample(1.0, every(1s), 'none')", "E0301"),
        ("sample(1.0, every(1m))", "E0301"),
    ],
)
def test_wrong_samples_are_errors(value: str, code: str, tmp_path: Path) -> None:
    text = f"import osc.types\nscenario main:\n    var n: float = {value}\n    do emit end\n"
    assert [found for _, found in messages(tmp_path, text)] == [code]
