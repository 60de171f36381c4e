"""Values: types, arguments, constraints, variables."""

import pytest

from tests.runtime.accept.conftest import Traced, TraceText


async def accepted(trace_text: TraceText, text: str) -> Traced:
    traced = await trace_text(text)
    assert traced.broken == set(), traced.messages
    return traced


INVOKED = """
enum color: [red, green]

struct point:
    x: int
    keep(x in [0..9])

scenario inner:
    c: color
    n: int
    limit: int = 7
    p: point
    keep(n < limit)
    do log("inner")

scenario main:
    n: int
    keep(n in [1..3])
    do inner(n: n) with:
        keep(it.c == color!green)
"""


async def test_arguments_equal_those_of_the_invocation(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("instance", of="inner")["values"]["n"] = 0
    assert traced.broken == {"value"}
    assert "`n` has the value 0; expected" in traced.messages


async def test_constraints_of_the_invoked_scenario_hold(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("instance", of="inner")["values"]["limit"] = 1
    assert traced.broken == {"constraint"}
    assert "`keep(n < limit)` does not hold" in traced.messages


async def test_constraints_of_the_invocation_hold(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("instance", of="inner")["values"]["c"] = {"enum": "color", "member": "red", "number": 0}
    assert traced.broken == {"constraint"}
    assert "`keep(it.c == color!green)`" in traced.messages


async def test_constraints_of_structs_hold(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("instance", of="inner")["values"]["p"]["fields"]["x"] = 12
    assert traced.broken == {"constraint"}


async def test_constraints_of_the_run_hold(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    for values in (traced.find("instance", of="main")["values"], traced.find("run.start")["parameters"]):
        values["n"] = 4
    traced.find("instance", of="inner")["values"]["n"] = 4
    assert traced.broken == {"constraint"}


async def test_the_run_has_the_values_of_its_start_record(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("run.start")["parameters"]["n"] = 9
    assert traced.broken == {"value"}


async def test_overrides_of_the_run_hold(trace_text: TraceText) -> None:
    traced = await trace_text("scenario main:\n    n: int = 3\n    do log('x')\n", overrides={"n": "5"})
    assert traced.broken == set()
    assert traced.find("run.start")["overrides"] == {"n": "5"}
    traced.find("instance", of="main")["values"]["n"] = 3
    traced.find("run.start")["parameters"]["n"] = 3
    assert traced.broken == {"constraint"}


@pytest.mark.parametrize(
    ("name", "value"),
    [("n", "one"), ("n", True), ("n", 1 << 70), ("c", 1), ("c", {"enum": "color", "member": "blue", "number": 5})],
)
async def test_values_are_of_their_types(trace_text: TraceText, name: str, value: object) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("instance", of="inner")["values"][name] = value
    assert "value" in traced.broken


async def test_a_missing_value_is_rejected(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    del traced.find("instance", of="inner")["values"]["c"]
    assert "`c` has no value" in traced.messages


async def test_a_value_that_differs_from_its_default_is_rejected(trace_text: TraceText) -> None:
    text = "scenario inner:\n    n: int = 3\n    do log('x')\n\nscenario main:\n    do inner()\n"
    traced = await accepted(trace_text, text)
    traced.find("instance", of="inner")["values"]["n"] = 4
    assert traced.broken == {"value"}


async def test_invalid_values_are_rejected(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, INVOKED)
    traced.find("instance", of="inner")["values"]["p"] = {"object": 999}
    assert "structure" in traced.broken


async def test_a_violated_default_constraint_is_undecided(trace_text: TraceText) -> None:
    text = """
scenario inner:
    n: int
    keep(default n == 3)
    do log("x")

scenario main:
    do inner(n: 5)
"""
    traced = await accepted(trace_text, text)
    [unchecked] = traced.accept().unchecked
    assert unchecked.rule.title == "constraint"
    assert "overridden" in unchecked.reason


# ---------------------------------------------------------------- variables

VARIABLES = """
struct box:
    fixed: int = 1
    var inside: int = 0

scenario main:
    b: box
    var n: int = 0
    var other: int = 0
    do serial:
        increment(n)
        increment(b.inside)
        wait n > 0
        wait elapsed(1s)
"""


async def test_variables_change_while_their_action_runs(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, VARIABLES)
    traced.move(traced.find("variable", field="n"), after=traced.end("wait", 1))
    assert "variable" in traced.broken


async def test_variables_are_changed_by_actions_with_them_as_arguments_only(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, VARIABLES)
    traced.find("variable", field="n")["field"] = "other"
    assert "`other` is changed by `increment`, which does not have it as an argument" in traced.messages


async def test_parameters_do_not_change(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, VARIABLES)
    traced.find("variable", field="inside")["field"] = "fixed"
    assert "`fixed` changes, but is not a variable" in traced.messages


async def test_variables_hold_values_of_their_types(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, VARIABLES)
    traced.rewrite(1.5, field="inside")
    assert traced.broken == {"variable", "action"}


async def test_a_condition_uses_the_changes_of_its_variables(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, VARIABLES)
    traced.rewrite(0, field="n")
    assert traced.broken == {"wait", "action"}
