"""`CausalPast` alone."""

from seoro.runtime.kernel.task import CausalPast


def past_of(instant: int, *numbers: int) -> CausalPast:
    past = CausalPast()
    for number in numbers:
        past.add(number, instant)
    return past


def test_a_past_contains_the_occurrences_of_its_instant() -> None:
    past = past_of(3, 7, 8)
    assert past.contains(7, 3) and past.contains(8, 3)
    assert not past.contains(9, 3)
    assert not past.contains(7, 4)


def test_a_past_keeps_one_instant_only() -> None:
    past = past_of(3, 7)
    past.add(8, 4)
    assert not past.contains(7, 3)
    assert past.contains(8, 4)


def test_an_empty_past_contains_no_occurrence() -> None:
    assert not CausalPast().contains(0, -1)


def test_a_fork_of_a_past_is_independent() -> None:
    past = past_of(3, 7)
    fork = past.fork()
    fork.add(8, 3)
    past.add(9, 3)
    assert fork.contains(7, 3) and not fork.contains(9, 3)
    assert not past.contains(8, 3)


def test_joining_adds_occurrences_of_the_same_instant() -> None:
    past = past_of(3, 7)
    past.join(past_of(3, 8))
    assert past.contains(7, 3) and past.contains(8, 3)


def test_joining_a_later_instant_replaces_an_earlier_one() -> None:
    past, later = past_of(3, 7), past_of(4, 8)
    past.join(later)
    later.add(9, 4)
    assert past.contains(8, 4) and not past.contains(7, 3)
    assert not past.contains(9, 4)


def test_joining_an_earlier_instant_changes_nothing() -> None:
    past = past_of(4, 8)
    past.join(past_of(3, 7))
    past.join(CausalPast())
    assert past.contains(8, 4) and not past.contains(7, 3)
