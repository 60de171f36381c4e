"""Comparison of values in messages with expected values."""

from typing import Any

import pytest

from seoro.actions.ros_comparison import Operator, compares, difference, read_expected
from seoro.errors import ActionFailed


@pytest.mark.parametrize(
    ("actual", "operator", "expected", "outcome"),
    [
        (3, Operator.eq, 3.0, True),
        (0.10000000149, Operator.eq, 0.1, True),
        (0.1001, Operator.eq, 0.1, False),
        (2**53 + 1, Operator.eq, 2**53, False),
        ([1, 2], Operator.eq, [1, 2, 3], False),
        ({"a": {"b": 1, "c": 2}}, Operator.eq, {"a": {"b": 1}}, True),
        ({"a": 1}, Operator.ne, {"a": 2}, True),
        ({"a": 1}, Operator.eq, "", True),
        ([1], Operator.ne, [], True),
        (float("nan"), Operator.eq, float("nan"), False),
        (2, Operator.gt, 1, True),
        (0.699999988, Operator.ge, 0.7, True),
        (0.699999988, Operator.lt, 0.7, False),
        (0.10000000149, Operator.le, 0.1, True),
        (0.10000000149, Operator.gt, 0.1, False),
        ("b", Operator.ge, "c", False),
    ],
)
def test_values_are_compared_by_operators(actual: Any, operator: Operator, expected: Any, outcome: bool) -> None:
    assert compares(actual, operator, expected, "it") is outcome


@pytest.mark.parametrize("operator", [Operator.eq, Operator.ne])
@pytest.mark.parametrize(
    ("actual", "expected", "reason"),
    [
        ({"a": {"b": 1}}, {"a": {"c": 1}}, "it: unknown member `a.c`"),
        ([{"a": 1}], [{"a": "x"}], "it: `0.a` is a number and never equals a string, `x`"),
        (1, True, "it: it is a number and never equals a boolean, `true`"),
        ("3", 3, "it: it is a string and never equals a number, `3`; with `eval_expected_value: false`"),
    ],
)
def test_values_that_can_never_be_equal_are_reported(
    actual: Any, operator: Operator, expected: Any, reason: str
) -> None:
    with pytest.raises(ActionFailed, match=reason):
        compares(actual, operator, expected, "it")


def test_differences_are_shown_by_their_paths() -> None:
    actual = {"a": [1, {"b": 2}], "c": "x", **{f"n{place}": 0 for place in range(9)}}
    expected = {"a": [1, {"b": 3}], "c": "y"}
    text = difference(actual, Operator.eq, expected)
    assert text == "differs: `a.1.b`: expected `3`, got `2`; `c`: expected `y`, got `x`"
    many = difference(actual, Operator.eq, {f"n{place}": 1 for place in range(9)})
    assert many.count("expected") == 5
    assert many.endswith("; and more")


@pytest.mark.parametrize(
    ("text", "expected"),
    [("", ""), ("[1, 2]", [1, 2]), ("{a: x}", {"a": "x"}), ("True", True), ("hello", "hello")],
)
def test_expected_values_are_read_as_yaml(text: str, expected: Any) -> None:
    assert read_expected(text, is_text=False) == expected
    assert read_expected(text, is_text=True) == text


def test_what_cannot_be_read_is_reported() -> None:
    with pytest.raises(ActionFailed, match="`expected_value`: cannot read the message"):
        read_expected("[1", is_text=False)
