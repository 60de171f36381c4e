"""Checks of request fields, and name lists in messages."""

from __future__ import annotations

import math
from contextlib import suppress

import pytest

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import (
    LONGEST_DRIVE,
    MAX_ID,
    MAX_LISTED,
    RequestRefused,
    check_drive_duration,
    check_finite,
    check_id,
    check_positive,
    name_list,
)


def test_name_lists_are_sorted() -> None:
    assert name_list({"odom", "base", "map"}) == "base, map, odom"
    assert name_list(()) == "none"


def test_long_name_lists_show_the_first_names_and_count_the_rest() -> None:
    names = [f"frame_{number:02}" for number in range(MAX_LISTED + 3)]
    assert name_list(names[:MAX_LISTED]).endswith("frame_19")
    assert name_list(names).endswith("frame_19 and 3 more")


@pytest.mark.parametrize("identifier", ["", "i" * (MAX_ID + 1)])
def test_empty_and_too_long_ids_are_refused(identifier: str) -> None:
    message = f"the id has {len(identifier)} characters; expected 1 to {MAX_ID}"
    with pytest.raises(RequestRefused, match=message) as refused:
        check_id(identifier)
    assert refused.value.code == Result.OPERATION_FAILED


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_values_of_zero_and_below_are_refused_with_their_unit(value: float) -> None:
    with pytest.raises(RequestRefused, match=rf"invalid distance {value}; expected more than 0 m$"):
        check_positive("distance", value, "m")
    with pytest.raises(RequestRefused, match=rf"invalid tolerance {value}; expected more than 0$"):
        check_positive("tolerance", value)


def test_values_that_are_not_finite_are_refused() -> None:
    with pytest.raises(RequestRefused, match=r"invalid velocity \(0.5, nan\); expected finite"):
        check_finite("velocity", 0.5, math.nan)


@pytest.mark.parametrize("duration", [0.0, -1.0, LONGEST_DRIVE + 1.0, math.nan])
def test_too_short_and_too_long_drive_durations_are_refused(duration: float) -> None:
    with pytest.raises(RequestRefused, match=f"invalid duration {duration} s; expected more than 0 and at "):
        check_drive_duration(duration)


def test_the_largest_and_smallest_valid_values_pass() -> None:
    passed = []
    for value in (LONGEST_DRIVE, math.nextafter(LONGEST_DRIVE, math.inf)):
        with suppress(RequestRefused):
            check_id("i" * MAX_ID)
            check_finite("velocity", value, 0.0)
            check_positive("distance", 5e-324, "m")
            check_drive_duration(value)
            passed.append(value)
    assert passed == [LONGEST_DRIVE]
