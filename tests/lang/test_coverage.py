"""`cover` and `record` in the plan; golden messages contain the errors."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.lang import plan

from .helpers import lower, messages

HEADER = "import osc.types\n\nenum light: [red, amber, green]\n\n"


def items(folder: Path, members: str, before: str = "", after: str = "") -> list[plan.AnyCoverageItem]:
    """Return the items of a scenario with given members."""
    indented = "".join(f"    {line}\n" for line in members.splitlines())
    found = lower(folder, f"{HEADER}{before}\nscenario main:\n{indented}{after}").coverage
    return list(found.get("main()", ()))


def single(folder: Path, members: str, before: str = "", after: str = "") -> plan.CoverageItem:
    found = items(folder, members, before, after)
    assert len(found) == 1
    assert isinstance(found[0], plan.CoverageItem)
    return found[0]


def test_a_coverage_item_samples_the_field_of_its_name_at_the_end(tmp_path: Path) -> None:
    item = single(tmp_path, 'v: speed = 50kph\ncover(v, unit: kph, text: "speed", target: 5)')
    assert (item.name, item.owner, item.kind, item.text, item.target) == (
        "v",
        "main",
        plan.CoverageKind.COVER,
        "speed",
        5,
    )
    assert isinstance(item.expression, plan.Field)
    assert isinstance(item.event, plan.PhaseEvent) and item.event.phase is plan.Phase.END
    assert item.unit is not None and (item.unit.name, item.unit.offset) == ("kph", 0)


def test_an_item_may_use_an_event_of_a_base(tmp_path: Path) -> None:
    before = "scenario base:\n    event sampled\n    n: int = 3\n"
    text = f"{HEADER}{before}\nscenario main inherits base:\n    record(n, event: sampled)\n"
    (item,) = lower(tmp_path, text, scenario="main").coverage["main()"]
    assert isinstance(item.event, plan.DeclaredEvent) and item.event.name == "sampled"
    assert item.kind is plan.CoverageKind.RECORD


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("expression: true", plan.EachValue((False, True))),
        ("expression: 3, range: [2..4]", plan.EachValue((2, 3, 4))),
        ("expression: 3, range: [0..1000]", plan.Levels(0, 1000)),
        ("expression: 1.5, range: [1..2]", plan.Levels(1, 2)),
        ("expression: 3, range: [1..20], every: 5", plan.Edges((1, 6, 11, 16, 20))),
        ("expression: 3, range: [20..1], every: 5", plan.Edges((1, 6, 11, 16, 20))),
        ("expression: 3, range: [0..9], every: 1", plan.EachValue(tuple(range(10)))),
        ("expression: 3, range: [0..9], every: 2", plan.Edges((0, 2, 4, 6, 8, 9))),
        ("expression: 3.0, range: [0..3], every: 1", plan.Edges((0, 1, 2, 3))),
        ("expression: 1.5, range: [0..0.3], every: 0.1", plan.Edges((0, 0.1, 0.2, 0.3))),
        ("expression: 3, every: 5", plan.Slices(5)),
        ("expression: 3, buckets: [1, 2, 2, 6.5, inf]", plan.Edges((1, 2, 2, 6.5, float("inf")))),
        ('expression: "a"', plan.Distinct()),
        ("expression: -3", plan.Levels(-(2**63), 2**63 - 1)),
    ],
)
def test_buckets_come_from_arguments_or_from_the_type(
    tmp_path: Path, arguments: str, expected: plan.Buckets
) -> None:
    assert single(tmp_path, f"cover(item, {arguments})").buckets == expected


@pytest.mark.parametrize(
    ("members", "expected"),
    [
        ("n: int with:\n    keep(it in [0, 2, 1 + 0, 4])\n    cover(n)", plan.Levels(-(2**63), 2**63 - 1)),
        ("n: int with:\n    keep(it in [0, 2, 4])\n    cover(n)", plan.EachValue((0, 2, 4))),
        ("n: int\nkeep(n in [1..3])\ncover(n)", plan.EachValue((1, 2, 3))),
        ("n: int\nkeep(n in [1..900] and n >= 7)\nkeep(300 > n)\ncover(n)", plan.Levels(7, 300)),
        ("n: int\nkeep(default n in [1..3])\ncover(n)", plan.Levels(-(2**63), 2**63 - 1)),
        ("x: float\nkeep(x in [-0.5..1])\ncover(x)", plan.Levels(-0.5, 1.0)),
        ("x: float\nkeep(x in [-1, 0.5, 3])\nkeep(x < 2)\ncover(x)", plan.EachValue((-1.0, 0.5))),
        ("v: speed\nkeep(v in [10kph, 50kph, 20kph])\ncover(v, unit: kph)", plan.EachValue((10.0, 50.0, 20.0))),
        ("v: speed\nkeep(v in [10kph..50kph])\ncover(v, unit: kph)", plan.Levels(10.0, 50.0)),
        ("s: string\nkeep(s in ['a', 'b'])\ncover(s)", plan.EachValue(("a", "b"))),
        ("n: int\nkeep(n in [1..3])\ncover(n, range: [0..9], every: 5)", plan.Edges((0, 5, 9))),
        ("n: int\nkeep(n in [1..3])\ncover(twice, expression: 2 * n)", plan.Levels(-(2**63), 2**63 - 1)),
    ],
)
def test_default_buckets_are_those_that_constraints_leave(
    tmp_path: Path, members: str, expected: plan.Buckets
) -> None:
    assert single(tmp_path, members).buckets == expected


def test_constraints_of_a_struct_bound_its_fields(tmp_path: Path) -> None:
    before = "struct storm:\n    wind: float\n    keep(wind in [0.0..20.0])\n"
    members = "now: storm with:\n    keep(it.wind >= 5)\ncover(wind, expression: now.wind)"
    assert single(tmp_path, members, before).buckets == plan.Levels(5.0, 20.0)


def test_constraints_of_an_enumeration_leave_some_buckets(tmp_path: Path) -> None:
    members = "now: light with:\n    keep(it in [light!red, light!green])\n    cover(now)"
    buckets = single(tmp_path, members).buckets
    assert isinstance(buckets, plan.EachValue)
    assert [value.member for value in buckets.values if isinstance(value, plan.EnumValue)] == ["red", "green"]


def test_an_enumeration_has_a_bucket_for_each_value(tmp_path: Path) -> None:
    buckets = single(tmp_path, "ahead: light = red\ncover(ahead)").buckets
    assert isinstance(buckets, plan.EachValue)
    assert [value.member for value in buckets.values if isinstance(value, plan.EnumValue)] == [
        "red",
        "amber",
        "green",
    ]


def test_an_override_changes_its_arguments_only(tmp_path: Path) -> None:
    members = 'n: int = 3\ncover(n, text: "lanes", range: [0..10], every: 5)\ncover(override: n, every: 2)'
    item = single(tmp_path, members, after="\nextend main:\n    cover(override: n, ignore: n > 8, target: 2)\n")
    assert item.buckets == plan.Edges((0, 2, 4, 6, 8, 10))
    assert (item.text, item.target, item.ignore is not None) == ("lanes", 2, True)


def test_disabling_an_item_removes_its_crosses(tmp_path: Path) -> None:
    members = "a, b, c: int = 3\ncover(a)\ncover(b)\ncover(c)\ncover(ab, items: [a, b])\ncover(bc, items: [b, c])"
    found = items(tmp_path, f"{members}\ncover(override: a, disable: true)")
    assert [item.name for item in found] == ["b", "c", "bc"]


def test_a_cross_of_a_cross_combines_the_items_of_both(tmp_path: Path) -> None:
    members = (
        "a, b, c: int = 3\ncover(a)\ncover(b)\nrecord(c)\ncover(ab, items: [a, b])\ncover(abc, items: [ab, c])"
    )
    *_, cross = items(tmp_path, members)
    assert isinstance(cross, plan.CrossItem)
    assert (cross.items, cross.kind) == (("a", "b", "c"), plan.CoverageKind.RECORD)


def test_coverage_in_the_block_of_a_field_belongs_to_the_enclosing_type(tmp_path: Path) -> None:
    before = "struct storm:\n    wind: speed = 30kph\n"
    members = "now: storm with:\n    cover(wind, expression: it.wind, unit: kmph)\ngap: length = 1m with:\n"
    wind, gap = items(tmp_path, members + "    cover(gap, unit: m)", before)
    assert isinstance(wind, plan.CoverageItem) and wind.it == "now"
    assert isinstance(gap, plan.CoverageItem) and isinstance(gap.expression, plan.Field)


def test_items_of_structs_and_actors_are_listed_by_type(tmp_path: Path) -> None:
    crate, courier = (
        "struct crate:\n    n: int = 3\n    cover(n)\n",
        "actor courier:\n    record(seven, expression: 7)\n",
    )
    text = f"{crate}{courier}scenario main\n"
    coverage = lower(tmp_path, text).coverage
    assert {type_: [item.name for item in found] for type_, found in coverage.items()} == {
        "crate": ["n"],
        "courier": ["seven"],
    }


def test_names_from_broken_statements_are_not_reported_as_missing(tmp_path: Path) -> None:
    text = "scenario main:\n    n int\n    cover(n)\n    record(k, expression: k)\n"
    assert messages(tmp_path, text) == [(2, "E0120"), (4, "E0216")]  # `k` is declared nowhere, `n` in line 2


ARGUMENTS = [
    "name",
    "override",
    "expression",
    "unit",
    "range",
    "every",
    "buckets",
    "event",
    "items",
    "text",
    "ignore",
    "illegal",
    "disable",
    "target",
    "units",
]
VALUES = [
    "n",
    "gap",
    "m",
    "[0..3]",
    "[n,gap]",
    "[1,2.5,inf]",
    "0",
    "-1",
    "1e-300",
    "2m",
    "true",
    '"text"',
    "it",
    "n>3",
    "main.end",
    "end",
    "nan",
    "range(3,1)",
    "crate(1)",
    "18446744073709551615",
]
DECLARATIONS = """type length is SI(m: 1)
unit m of length is SI(m: 1)
struct crate:
    n: int
scenario main:
    n: int = 3
    gap: length = 1m
"""
ITEM = st.tuples(
    st.sampled_from(["cover", "record"]),
    st.sampled_from(VALUES),
    st.lists(st.tuples(st.sampled_from(ARGUMENTS), st.sampled_from(VALUES)), max_size=4),
)


@settings(deadline=None, derandomize=True)
@given(st.lists(ITEM, min_size=1, max_size=4))
def test_each_coverage_item_is_reported_or_sampled(
    tmp_path_factory: pytest.TempPathFactory, written: list[tuple[str, str, list[tuple[str, str]]]]
) -> None:
    folder, text = tmp_path_factory.getbasetemp(), DECLARATIONS
    for kind, first, arguments in written:
        text += f"    {kind}({', '.join([first, *(f'{name}: {value}' for name, value in arguments)])})\n"
    if not messages(folder, text):
        found = [item.name for item in lower(folder, text).coverage.get("main()", ())]
        assert len(found) == len(set(found)) <= len(written)


def test_actions_modifiers_and_actors_have_items_with_events_of_their_own(tmp_path: Path) -> None:
    text = """
actor robot:
    event bumped
    cover(bumps, expression: 3, event: bumped)

action robot.lift:
    height: length = 1m
    event swayed
    cover(height, unit: m, event: start)
    record(sway, expression: 2 * height, unit: m, event: swayed)

modifier gently of robot.lift:
    cover(gentle, expression: it.height, unit: cm)

scenario main:
    r: robot
    do r.lift() with:
        gently()
"""
    found = lower(tmp_path, HEADER + text).coverage
    events = {key: [item.event for item in items] for key, items in found.items()}
    assert [type(event) for each in events.values() for event in each] == [
        plan.DeclaredEvent,
        plan.PhaseEvent,
        plan.DeclaredEvent,
        plan.PhaseEvent,
    ]
    assert list(events) == ["robot", "robot.lift()", "modifier gently"]


@pytest.mark.parametrize(
    ("declared", "event"), [("struct a", "end"), ("action a", "ends"), ("modifier a", "gone")]
)
def test_unknown_events_of_items_are_reported(declared: str, event: str, tmp_path: Path) -> None:
    text = f"{declared}:\n    cover(n, expression: 3, event: {event})\n"
    assert messages(tmp_path, text) == [(2, "E0408")]
