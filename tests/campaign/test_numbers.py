"""Sets of the numbers of runs."""

import tracemalloc

from hypothesis import given
from hypothesis import strategies as st

from seoro.campaign.numbers import Numbers


@given(st.lists(st.integers(0, 10**18) | st.integers(0, 20_000)), st.integers(0, 20_000))
def test_numbers_are_a_set(numbers: list[int], other: int) -> None:
    found, expected = Numbers(), set[int]()
    for number in numbers:
        assert found.add(number) is (number not in expected)
        expected.add(number)
        assert number in found
    assert (other in found) is (other in expected)


def test_a_million_numbers_take_less_than_a_megabyte() -> None:
    tracemalloc.start()
    found = Numbers()
    found.update(range(1, 1_000_001))
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert size < 1_000_000
    assert 1_000_000 in found
