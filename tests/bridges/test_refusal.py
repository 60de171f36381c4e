"""Checks of what requests hold, and the names that their messages list."""

from __future__ import annotations

import math

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
    listed,
)


def test_names_are_listed_sorted() -> None:
    assert listed({"odom", "base", "map"}) == "base, map, odom"
    assert listed(()) == "none"


def test_of_many_names_the_first_are_listed_and_the_rest_counted() -> None:
    names = [f"frame_{number:02}" for number in range(MAX_LISTED + 3)]
    assert listed(names[:MAX_LISTED]).endswith("frame_19")
    assert listed(names).endswith("frame_19 and 3 more")


@pytest.mark.parametrize("identifier", ["", "i" * (MAX_ID + 1)])
def test_an_id_that_is_empty_or_too_long_is_refused(identifier: str) -> None:
    said = f"an id has 1 to {MAX_ID} characters, not {len(identifier)}"
    with pytest.raises(RequestRefused, match=said) as refused:
        check_id(identifier)
    assert refused.value.code == Result.OPERATION_FAILED


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_what_is_not_above_zero_is_refused_with_its_unit(value: float) -> None:
    with pytest.raises(RequestRefused, match=rf"the distance is {value}: it has to be more than 0 m$"):
        check_positive("distance", value, "m")
    with pytest.raises(RequestRefused, match=rf"the tolerance is {value}: it has to be more than 0$"):
        check_positive("tolerance", value)


def test_values_of_which_one_is_no_finite_number_are_refused() -> None:
    with pytest.raises(RequestRefused, match=r"the velocity \(0.5, nan\) has a part that is no finite number"):
        check_finite("velocity", 0.5, math.nan)


@pytest.mark.parametrize("duration", [0.0, -1.0, LONGEST_DRIVE + 1.0, math.nan])
def test_driving_for_no_time_or_for_days_is_refused(duration: float) -> None:
    with pytest.raises(RequestRefused, match=f"the duration is {duration} s: it has to be more than 0 and at "):
        check_drive_duration(duration)


def test_what_is_right_passes() -> None:
    check_id("goal_1")
    check_finite("velocity", 0.5, 0.0)
    check_positive("distance", 0.1, "m")
    check_drive_duration(LONGEST_DRIVE)
