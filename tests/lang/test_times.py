"""Arguments of compositions, and the duration of invocations."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang import plan
from tests.lang.helpers import lower, messages

TEXT = """
import osc.types
import osc.helpers

scenario nap:
    n: int = 3
    do log("x")

scenario main:
    equal: time = 2s
    do PARALLEL:
        nap()
        nap(duration: [1s..2s], n: 2)
"""


def parallel(folder: Path, arguments: str) -> plan.Parallel:
    """Return a composition with some arguments."""
    text = TEXT.replace("PARALLEL", f"parallel{arguments}")
    body = lower(folder, text, scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Parallel)
    return body


def bounds(time: plan.Expression | None) -> tuple[object, object]:
    assert isinstance(time, plan.RangeOf)
    low, high = time.low, time.high
    return (
        low.value if isinstance(low, plan.Literal) else type(low).__name__,
        high.value if isinstance(high, plan.Literal) else type(high).__name__,
    )


@pytest.mark.parametrize(
    ("arguments", "overlap"),
    [
        ("", "start"),
        ("()", "start"),
        ("(overlap: equal)", "equal"),
        ("(full)", "full"),
        ("(any, 2s)", "any"),
        ("(start_to_start: 2s)", "any"),
        ("(end_to_end: 2s)", "start"),
        ("(duration: 2s)", "start"),
    ],
)
def test_members_start_together_by_default(arguments: str, overlap: str, tmp_path: Path) -> None:
    assert parallel(tmp_path, arguments).overlap.value == overlap


def test_single_times_become_ranges(tmp_path: Path) -> None:
    found = parallel(tmp_path, "(any, -5s, [1s..equal], duration: 3s)")
    assert bounds(found.start_to_start) == (-5.0, -5.0)
    assert bounds(found.end_to_end) == (1.0, "Field")
    assert bounds(found.duration) == (3.0, 3.0)


def test_positional_arguments_are_in_the_order_of_the_standard(tmp_path: Path) -> None:
    found = parallel(tmp_path, "(any, 1s, 2s, 3s)")
    assert bounds(found.start_to_start) == (1.0, 1.0)
    assert bounds(found.end_to_end) == (2.0, 2.0)
    assert bounds(found.duration) == (3.0, 3.0)


@pytest.mark.parametrize("operator", ["serial", "one_of"])
def test_each_composition_has_a_duration(operator: str, tmp_path: Path) -> None:
    text = TEXT.replace("PARALLEL", f"{operator}(2s)")
    body = lower(tmp_path, text, scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Serial | plan.OneOf)
    assert bounds(body.duration) == (2.0, 2.0)


def test_invocations_have_a_duration_and_arguments(tmp_path: Path) -> None:
    plain, timed = parallel(tmp_path, "").members
    assert isinstance(plain, plan.InvokeScenario) and isinstance(timed, plan.InvokeScenario)
    assert plain.duration is None
    assert bounds(timed.duration) == (1.0, 2.0)
    assert [name for name, _ in timed.arguments] == ["n"]


def test_a_parameter_named_duration_receives_the_argument(tmp_path: Path) -> None:
    text = TEXT.replace("PARALLEL", "serial").replace("    n: int = 3", "    n: int = 3\n    duration: time = 1s")
    text = text.replace("[1s..2s]", "2s")
    body = lower(tmp_path, text, scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Serial)
    timed = body.members[1]
    assert isinstance(timed, plan.InvokeScenario) and timed.duration is None
    assert [name for name, _ in timed.arguments] == ["n", "duration"]


def test_only_behaviors_have_a_duration(tmp_path: Path) -> None:
    text = "import osc.types\nscenario main:\n    p: pose_3d = pose_3d(duration: 3s)\n    event go\n"
    text += "    do emit go(duration: 3s)\n"
    assert messages(tmp_path, text) == [(3, "E0403"), (5, "E0403")]


def constraints(folder: Path, operator: str, *lines: str) -> list[plan.Expression]:
    """Return the conditions in the `with:` block of a composition."""
    block = "".join(f"        {line}\n" for line in lines)
    text = f"{TEXT.replace('PARALLEL', operator)}    with:\n{block}"
    body = lower(folder, text, scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Serial | plan.Parallel | plan.OneOf)
    return [each.condition if isinstance(each, plan.Constraint) else each.parameter for each in body.constraints]


@pytest.mark.parametrize("operator", ["serial", "parallel", "one_of"])
def test_constraints_on_a_composition_apply_to_its_parameters(operator: str, tmp_path: Path) -> None:
    found = constraints(tmp_path, operator, "keep(default it.duration == 2s)", "remove_default(it.duration)")
    equal, removed = found
    assert isinstance(equal, plan.Compare) and isinstance(equal.right, plan.RangeOf), "a time is a range, too"
    assert isinstance(removed, plan.Member) and removed.name == "duration"
    assert isinstance(removed.base, plan.Binding) and removed.base.name == "it"


@pytest.mark.parametrize(
    ("condition", "operator", "side"),
    [
        ("it.duration < 5s", "<", plan.Side.UPPER),
        ("it.duration >= 5s", ">=", plan.Side.LOWER),
        ("5s > it.duration", ">", plan.Side.UPPER),
        ("5s <= it.duration", "<=", plan.Side.LOWER),
    ],
)
def test_comparing_a_range_with_a_number_bounds_the_whole_range(
    condition: str, operator: str, side: plan.Side, tmp_path: Path
) -> None:
    (found,) = constraints(tmp_path, "serial", f"keep({condition})")
    assert isinstance(found, plan.Compare) and found.operator == operator
    (bound,) = (each for each in (found.left, found.right) if isinstance(each, plan.Bound))
    assert bound.side is side


def test_kinds_of_overlap_precede_other_members_of_their_name(tmp_path: Path) -> None:
    found = constraints(tmp_path, "parallel", "keep(it.overlap == equal)", "keep(it.overlap in [start, any])")
    values = [each for condition in found for each in literals(condition)]
    assert [each.member for each in values if isinstance(each, plan.EnumValue)] == ["equal", "start", "any"]


def literals(expression: plan.Expression) -> list[object]:
    if isinstance(expression, plan.Literal):
        return [expression.value]
    return [value for part in plan.parts(expression) for value in literals(part)]


def test_an_invocation_has_a_duration_unless_it_declares_one(tmp_path: Path) -> None:
    text = TEXT.replace(
        "n: 2)", "n: 2) with:\n            keep(it.duration < 3s)\n            keep(it.DURATION > 1s)"
    )
    assert messages(tmp_path, text.replace("PARALLEL", "serial")) == [(15, "E0215")]
    text = text.replace("n: int = 3", "duration: int = 3").replace(", n: 2", "").replace("[1s..2s]", "2")
    assert messages(tmp_path, text.replace("PARALLEL", "serial")) == [(14, "E0313"), (15, "E0215")]


def test_parameters_of_compositions_belong_to_no_namespace(tmp_path: Path) -> None:
    text = "import osc.standard.types\nnamespace own\nscenario main:\n    do serial:\n"
    block = "    with:\n        keep(it.duration == [1s..2s])\n"
    inner = "        call_it() with:\n            keep(it.duration == [1s..2s])\n"
    assert messages(tmp_path, f"{text}{inner}{block}scenario call_it\n") == []
