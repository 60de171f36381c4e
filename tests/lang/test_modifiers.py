"""Modifiers in the plan: declarations, applications in every place, `override`, and `it`."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang import plan
from tests.lang.helpers import lower, messages

TEXT = """
import osc.types
import osc.helpers

actor cat:
    name: string = "tom"

actor kitten inherits cat

scenario cat.nap:
    n: int = 1
    event dreaming
    do inner: wait elapsed(1s)

modifier cat.gently:
    who: string = actor.name
    event late is elapsed(1s)
    on @late:
        emit fail

modifier cat.briefly of nap:
    limit: time
    start_of: int = it.n
    timeout(limit)
    on @it.dreaming:
        emit end

scenario main:
    k: kitten
    do WHAT
"""


def body_of(folder: Path, what: str, text: str = TEXT) -> plan.Behavior:
    body = lower(folder, text.replace("WHAT", what), scenario="main").scenarios["main"].body
    assert body is not None
    return body


def block(folder: Path, *lines: str, invocation: str = "k.nap()") -> tuple[plan.Modification, ...]:
    """Return the modifications of an invocation."""
    members = "".join(f"        {line}\n" for line in lines)
    found = body_of(folder, f"{invocation} with:\n{members}")
    assert isinstance(found, plan.InvokeScenario | plan.InvokeAction)
    return found.modifications


def application(modification: plan.Modification) -> plan.ModifierApplication:
    assert isinstance(modification, plan.ModifierApplication)
    return modification


def test_modifiers_keep_the_order_of_the_text(tmp_path: Path) -> None:
    found = block(tmp_path, "timeout(3s)", "until elapsed(2s)", "repeat(count: 2)", "inverter()")
    assert [type(each).__name__ for each in found] == [
        "ModifierApplication",
        "Until",
        "ModifierApplication",
        "ModifierApplication",
    ]
    repeat = application(found[2])
    assert (repeat.modifier, [name for name, _ in repeat.arguments]) == ("repeat", ["count"])


@pytest.mark.parametrize(
    ("line", "actor"),
    [
        ("gently()", plan.Field),
        ("k.gently()", plan.Field),
        ("briefly(2s)", plan.Field),
        ("inverter()", type(None)),
    ],
)
def test_a_modifier_may_omit_the_actor_of_the_invocation(line: str, actor: type, tmp_path: Path) -> None:
    (found,) = block(tmp_path, line)
    assert isinstance(application(found).actor, actor)


def test_a_modifier_may_omit_the_actor_of_the_scenario(tmp_path: Path) -> None:
    text = TEXT.replace("do WHAT", "do k.rest()")
    text += "\nscenario cat.rest:\n    gently()\n    do log('x') with:\n        gently()\n"
    rest = lower(tmp_path, text, scenario="main").scenarios["cat.rest"]
    (member,) = rest.modifiers
    assert isinstance(rest.body, plan.InvokeAction)
    (inner,) = rest.body.modifications
    for found in (member, inner):
        assert isinstance(application(found).actor, plan.Binding)


def test_it_in_the_block_of_an_invocation_is_the_invoked_behavior(tmp_path: Path) -> None:
    (found,) = block(tmp_path, "repeat(it.n)")
    ((_, count),) = application(found).arguments
    assert isinstance(count, plan.Member) and isinstance(count.base, plan.Binding)
    (until,) = block(tmp_path, "until @it.dreaming")
    assert isinstance(until, plan.Until) and isinstance(until.event, plan.OnEvent)
    assert isinstance(until.event.event, plan.MemberEvent)
    (until,) = block(tmp_path, "until @it.end")
    assert isinstance(until, plan.Until) and isinstance(until.event, plan.OnEvent)
    assert isinstance(until.event.event, plan.MemberEvent)
    assert isinstance(until.event.event.event, plan.PhaseEvent)


def test_the_plan_contains_reachable_modifiers_only(tmp_path: Path) -> None:
    text = TEXT.replace("WHAT", "k.nap() with:\n        briefly(2s)\n") + "modifier unused\n"
    made = lower(tmp_path, text, scenario="main").modifiers
    assert list(made) == ["cat.briefly", "timeout"]
    briefly, timeout = made["cat.briefly"], made["timeout"]
    assert (briefly.of, briefly.library) == ("cat.nap", None)
    assert briefly.actor is not None and briefly.actor.name == "cat"
    defaults = {name: field.default for name, field in briefly.structure.fields.items()}
    assert defaults["limit"] is None and isinstance(defaults["start_of"], plan.Member)
    (on,) = briefly.on
    assert isinstance(on.event, plan.OnEvent) and isinstance(on.event.event, plan.MemberEvent)
    (inner,) = briefly.modifiers
    assert application(inner).modifier == "timeout"
    assert (timeout.library, timeout.of, timeout.actor) == ("osc.helpers", None, None)


def test_an_empty_modifier_of_a_user_is_compound(tmp_path: Path) -> None:
    text = TEXT.replace("WHAT", "k.nap() with:\n        calmly()\n") + "modifier calmly\n"
    assert lower(tmp_path, text, scenario="main").modifiers["calmly"].library is None


def test_members_of_scenarios_are_inherited_and_extended(tmp_path: Path) -> None:
    text = """
import osc.types
import osc.helpers

scenario base:
    timeout(3s)
    do a: wait elapsed(1s)

scenario main inherits base:
    inverter()

extend base:
    repeat(2)
"""
    made = lower(tmp_path, text, scenario="main")
    assert [application(found).modifier for found in made.scenarios["main"].modifiers] == [
        "timeout",
        "repeat",
        "inverter",
    ]


def test_actors_and_structs_have_modifiers(tmp_path: Path) -> None:
    text = (
        TEXT.replace("WHAT", "emit end")
        + "\nextend kitten:\n    gently(name)\nstruct bag:\n    c: cat\n    c.gently()\n"
    )
    made = lower(tmp_path, text, scenario="main")
    (found,) = made.objects["kitten"].modifiers
    assert isinstance(application(found).actor, plan.Self)
    (found,) = made.objects["bag"].modifiers
    assert isinstance(application(found).actor, plan.Field)
    assert "cat.gently" in made.modifiers


def test_actions_have_modifiers_and_directives(tmp_path: Path) -> None:
    text = """
import osc.types
import osc.helpers

action jump:
    event landed
    timeout(2s)
    on @landed:
        emit end

scenario main:
    do parallel:
        j: jump()
        wait @j.landed
"""
    action = lower(tmp_path, text).actions["jump"]
    assert [application(found).modifier for found in action.modifiers] == ["timeout"]
    assert len(action.on) == len(action.events) == 1


@pytest.mark.parametrize(
    ("arguments", "overridden", "by", "mode"),
    [
        ("a, b", ("a",), ("b",), "on_start"),
        ("a, b, when_active", ("a",), ("b",), "when_active"),
        ("outer.a, b, on_start", ("a",), ("b",), "on_start"),
        ("a.inner, outer.b", ("a", "inner"), ("b",), "on_start"),
    ],
)
def test_override_accepts_paths_of_labels(
    arguments: str, overridden: tuple[str, ...], by: tuple[str, ...], mode: str, tmp_path: Path
) -> None:
    what = "outer: parallel:\n        a: k.nap()\n        b: k.nap()\n    with:\n        override(ARGS)\n"
    body = body_of(tmp_path, what.replace("ARGS", arguments))
    assert isinstance(body, plan.Parallel)
    (found,) = body.modifications
    assert isinstance(found, plan.Override)
    assert (found.overridden, found.by, found.mode.value) == (overridden, by, mode)


def test_override_may_be_a_member_of_the_scenario(tmp_path: Path) -> None:
    text = TEXT.replace(
        "    do WHAT", "    override(a, b)\n    do parallel:\n        a: k.nap()\n        b: k.nap()\n"
    )
    (found,) = lower(tmp_path, text, scenario="main").scenarios["main"].modifiers
    assert isinstance(found, plan.Override)


def test_a_modifier_of_a_base_applies_to_derived_scenarios(tmp_path: Path) -> None:
    text = (
        TEXT.replace("WHAT", "k.deep_nap() with:\n        briefly(2s)\n")
        + "scenario cat.deep_nap inherits cat.nap\n"
    )
    assert messages(tmp_path, text) == []


def test_a_wrong_invocation_causes_no_messages_about_its_modifiers(tmp_path: Path) -> None:
    text = TEXT.replace(
        "WHAT", "k.gone() with:\n        briefly(2s)\n        until it.n > 3\n        timeout(2s)\n"
    )
    assert [code for _, code in messages(tmp_path, text)] == ["E0401"]


def test_a_modifier_and_a_scenario_of_one_name_have_separate_methods(tmp_path: Path) -> None:
    text = """
modifier calm:
    def size() -> int is expression 1
    m: int = size()

scenario calm:
    def size() -> int is expression 2
    n: int = size()
    do emit end

scenario main:
    do calm() with:
        calm()
"""
    made = lower(tmp_path, text, scenario="main")
    size = made.modifiers["calm"].structure.fields["m"].default
    assert isinstance(size, plan.Call)
    first = made.methods.find([plan.modifier_type("calm")], size.method)
    second = made.methods.find([plan.behavior_type("calm")], size.method)
    assert first is not None and second is not None and first is not second


def test_it_in_a_modifier_without_of_has_the_parameters_of_its_application(tmp_path: Path) -> None:
    modifier = "modifier paced:\n    longest: time = it.duration.upper()\n    on @it.fail:\n        emit end\n"
    modifier += "modifier joint:\n    paced()\n    keep(it.overlap == equal)\n\nscenario main:"
    text = TEXT.replace("scenario main:", modifier)
    used = "parallel:\n        k.nap() with:\n            paced()\n    with:\n        joint()"
    (field,) = lower(tmp_path, text.replace("WHAT", used), scenario="main").modifiers["paced"].structure.members
    assert isinstance(field, plan.FieldDeclaration) and isinstance(field.default, plan.Bound)
    assert messages(tmp_path, text.replace("WHAT", used.replace("parallel", "serial"))) == [(42, "E0471")]


def test_a_cycle_of_modifiers_is_an_error(tmp_path: Path) -> None:
    text = "modifier one:\n    two()\n    keep(it.overlap == any)\nmodifier two:\n    one()\nactor a:\n    two()\n"
    assert [code for _, code in messages(tmp_path, text)] == ["E0219", "E0471"]
