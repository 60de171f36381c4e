"""Buckets of values."""

import math
import sys
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.lang.plan import Buckets, Distinct, EachValue, Edges, EnumValue, Levels, Slices
from seoro.runtime.coverage.buckets import bucket_of, number_of
from seoro.runtime.values.values import Value

EVERY_TEN = Edges((10, 20, 30))
UNEVEN = Edges((1, 2, 2, 6.5))
WHOLE = Levels(0, 90)
ALL_FLOATS = Levels(-sys.float_info.max, sys.float_info.max)
AMBER = EnumValue("light", "amber", 1)


@pytest.mark.parametrize(
    ("buckets", "value", "expected"),
    [
        (EVERY_TEN, 9.9, None),
        (EVERY_TEN, 10, "10..20"),
        (EVERY_TEN, 20, "20..30"),
        (EVERY_TEN, 30, "20..30"),
        (EVERY_TEN, 30.1, None),
        (UNEVEN, 1.5, "1..2"),
        (UNEVEN, 2, "2..2"),
        (UNEVEN, 2.1, "2..6.5"),
        (UNEVEN, 6.5, "2..6.5"),
        (Edges((2, 2)), 2, "2..2"),
        (Edges((0, math.inf)), math.inf, "0..inf"),
        (Slices(5), 7, "5..10"),
        (Slices(5), -1, "-5..0"),
        (Slices(5), math.inf, None),
        (Slices(0.1), 0.3, "0.3..0.4"),
        (Slices(1e-300), 1e300, None),
        (WHOLE, 0, "min"),
        (WHOLE, 29, "low"),
        (WHOLE, 30, "medium"),
        (WHOLE, 89, "high"),
        (WHOLE, 90, "max"),
        (WHOLE, 91, None),
        (Levels(3, 3), 3, "min"),
        (Levels(-30, 30), 0, "medium"),
        (ALL_FLOATS, 1.5, "medium"),
        (ALL_FLOATS, math.inf, None),
        (EachValue((False, True)), True, "true"),
        (EachValue((1, 2)), 3, None),
        (EachValue((AMBER,)), EnumValue("light", "yellow", 1), "light!amber"),
        (Distinct(), "1.2.3", "1.2.3"),
    ],
)
def test_a_value_is_in_its_bucket(buckets: Buckets, value: Value, expected: str | None) -> None:
    assert bucket_of(buckets, value) == expected


def test_the_number_of_buckets_is_known() -> None:
    assert number_of(EachValue((1, 2, 3))) == 3
    assert number_of(EVERY_TEN) == 2
    assert number_of(WHOLE) == 5
    assert number_of(Slices(5)) is None
    assert number_of(Distinct()) is None


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(st.lists(FINITE, min_size=2, max_size=8), FINITE)
def test_a_value_between_the_outer_edges_is_in_a_bucket_that_contains_it(found: list[float], value: float) -> None:
    edges = tuple(sorted(found))
    bucket = bucket_of(Edges(edges), value)
    if not edges[0] <= value <= edges[-1]:
        assert bucket is None
        return
    containing = [(a, b) for a, b in pairwise(edges) if a <= value <= b]
    assert bucket in [f"{a:.12g}..{b:.12g}" for a, b in containing]


@given(FINITE, FINITE, FINITE)
def test_every_value_of_a_range_has_a_level(first: float, second: float, value: float) -> None:
    low, high = sorted((first, second))
    assert (bucket_of(Levels(low, high), value) is None) == (not low <= value <= high)


@given(FINITE, st.floats(min_value=1e-300, allow_nan=False, allow_infinity=False))
def test_every_value_is_in_a_slice_unless_the_quotient_overflows(value: float, width: float) -> None:
    assert bucket_of(Slices(width), value) is not None or abs(value / width) > 1e300
