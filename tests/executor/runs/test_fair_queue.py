"""Order of the fair queue."""

from collections.abc import Iterable

from hypothesis import given
from hypothesis import strategies as st

from seoro.executor.runs.fair_queue import FairQueue


def waiting(*runs: tuple[str, int, str]) -> FairQueue:
    made = FairQueue()
    for run in runs:
        made.add(*run)
    return made


def taken(made: FairQueue) -> str:
    return " ".join(made.take() for _ in range(len(made)))


def many(count: int, submitter: str, priority: int = 0) -> Iterable[tuple[str, int, str]]:
    return ((f"{submitter}{number}", priority, submitter) for number in range(count))


def test_runs_of_a_user_keep_their_order() -> None:
    assert taken(waiting(*many(4, "a"))) == "a0 a1 a2 a3"


def test_users_take_turns() -> None:
    assert taken(waiting(*many(4, "a"), *many(2, "b"), *many(1, "c"))) == "a0 b0 c0 a1 b1 a2 a3"


def test_a_later_user_waits_for_one_run_of_each_other_user() -> None:
    made = waiting(*many(200, "a"))
    assert [made.take(), made.take()] == ["a0", "a1"]
    for run in many(2, "b"):
        made.add(*run)
    assert [made.take() for _ in range(4)] == ["b0", "a2", "b1", "a3"]


def test_a_returning_user_has_no_turn_before_others() -> None:
    made = waiting(*many(3, "a"), ("b0", 0, "b"))
    assert [made.take(), made.take()] == ["a0", "b0"]
    made.add("b1", 0, "b")
    assert taken(made) == "a1 b1 a2"


def test_a_higher_priority_goes_first() -> None:
    made = waiting(*many(2, "a"), ("b0", -1, "b"), ("a9", 5, "a"), ("c0", 5, "c"))
    assert taken(made) == "a9 c0 a0 a1 b0"


def test_a_discarded_run_is_not_taken() -> None:
    made = waiting(*many(3, "a"))
    made.discard("a0")
    assert "a0" not in made
    assert taken(made) == "a1 a2"
    assert not made


@given(st.lists(st.tuples(st.integers(-2, 2), st.sampled_from("abcd")), max_size=40), st.integers(0, 20))
def test_places_equal_the_order_of_runs(runs: list[tuple[int, str]], first: int) -> None:
    made = FairQueue()
    for number, (priority, submitter) in enumerate(runs):
        made.add(str(number), priority, submitter)
        if number < first and number % 3 == 2:
            made.take()
    places = dict(made.places)
    assert sorted(places.values()) == list(range(1, len(made) + 1))
    order = [made.take() for _ in range(len(made))]
    assert [places[run] for run in order] == sorted(places.values())
