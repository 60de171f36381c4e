"""Labels in expressions: their meaning before a dot; golden messages contain the errors."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang import plan
from tests.lang.helpers import lower, messages

TEXT = """
scenario leaf:
    n: int = 1
    full: bool = true
    def total() -> int is expression n + 1

scenario inner:
    m: int = 2
    do deep: leaf()

scenario main:
    own: int = 3
    do outer: serial:
        first: inner()
        last: WHAT
"""


def last(folder: Path, what: str) -> plan.Behavior:
    body = lower(folder, TEXT.replace("WHAT", what), scenario="main").scenarios["main"].body
    assert isinstance(body, plan.Serial)
    return body.members[-1]


@pytest.mark.parametrize(
    ("path", "labels", "field"),
    [
        ("first.m", ("first",), "m"),
        ("outer.first.m", ("first",), "m"),
        ("first.deep.n", ("first", "deep"), "n"),
        ("outer.first.deep.n", ("first", "deep"), "n"),
    ],
)
def test_a_path_of_labels_leads_to_the_invocation(
    path: str, labels: tuple[str, ...], field: str, tmp_path: Path
) -> None:
    found = last(tmp_path, f"leaf({path})")
    assert isinstance(found, plan.InvokeScenario)
    ((_, value),) = found.arguments
    assert isinstance(value, plan.Member) and value.name == field
    assert isinstance(value.base, plan.Labelled) and value.base.path == labels


def test_methods_of_a_labelled_invocation_can_be_called(tmp_path: Path) -> None:
    found = last(tmp_path, "leaf(first.deep.total())")
    assert isinstance(found, plan.InvokeScenario)
    ((_, value),) = found.arguments
    assert isinstance(value, plan.Call) and isinstance(value.receiver, plan.Labelled)


def test_a_field_after_a_label_is_a_condition(tmp_path: Path) -> None:
    found = last(tmp_path, "wait first.deep.full")
    assert isinstance(found, plan.Wait) and isinstance(found.event, plan.Holds)


@pytest.mark.parametrize("hidden", ["own: leaf()", "own: inner()"])
def test_a_field_precedes_a_label_of_its_name(hidden: str, tmp_path: Path) -> None:
    text = TEXT.replace("WHAT", f"leaf(own.n)\n        {hidden}")
    assert messages(tmp_path, text) == [(15, "E0319")]


def test_a_label_of_a_wrong_invocation_causes_no_further_messages(tmp_path: Path) -> None:
    text = TEXT.replace("inner()\n        last", "gone()\n        last").replace("WHAT", "leaf(first.m)")
    assert messages(tmp_path, text) == [(14, "E0401")]
