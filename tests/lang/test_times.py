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
    """A composition with some arguments."""
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
def test_members_start_together_unless_something_else_is_said(
    arguments: str, overlap: str, tmp_path: Path
) -> None:
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


def test_invocations_have_a_duration_beside_their_arguments(tmp_path: Path) -> None:
    plain, timed = parallel(tmp_path, "").members
    assert isinstance(plain, plan.InvokeScenario) and isinstance(timed, plan.InvokeScenario)
    assert plain.duration is None
    assert bounds(timed.duration) == (1.0, 2.0)
    assert [name for name, _ in timed.arguments] == ["n"]


def test_a_parameter_called_duration_is_given_the_argument(tmp_path: Path) -> None:
    text = TEXT.replace("PARALLEL", "serial").replace("    n: int = 3", "    n: int = 3\n    duration: time = 1s")
    text = text.replace("[1s..2s]", "2s")
    body = lower(tmp_path, text, scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Serial)
    timed = body.members[1]
    assert isinstance(timed, plan.InvokeScenario) and timed.duration is None
    assert [name for name, _ in timed.arguments] == ["n", "duration"]


def test_only_what_takes_time_has_a_duration(tmp_path: Path) -> None:
    text = "import osc.types\nscenario main:\n    p: pose_3d = pose_3d(duration: 3s)\n    event go\n"
    text += "    do emit go(duration: 3s)\n"
    assert messages(tmp_path, text) == [(3, "E0403"), (5, "E0403")]
