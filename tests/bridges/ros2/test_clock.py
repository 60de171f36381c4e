"""What `/clock` tells."""

import pytest

from seoro.bridges.ros2.clock import KEPT, SECOND, SimClock


class Told:
    """A clock that has told times [s] at times of this machine [s], and what was noted."""

    def __init__(self, *times: tuple[float, float]) -> None:
        self.notes: list[str] = []
        self.set_back = 0
        self.clock = SimClock(self.notes.append, self._count)
        for now, here in times:
            self.clock.take(round(now * SECOND), round(here * SECOND))

    def _count(self) -> None:
        self.set_back += 1


def test_the_time_is_the_last_one_before_something_arrived() -> None:
    told = Told((5.0, 100.0), (5.02, 100.04), (5.04, 100.08))
    assert told.clock.now == round(5.04 * SECOND)
    for here, now in ((100.0, 5.0), (100.05, 5.02), (100.079, 5.02), (200.0, 5.04), (99.0, 5.0)):
        assert told.clock.at(round(here * SECOND)) == round(now * SECOND)
    assert not told.notes


def test_what_is_kept_is_bounded() -> None:
    told = Told(*((float(number), float(number)) for number in range(2 * KEPT)))
    assert told.clock.at(0) == KEPT * SECOND


def test_a_jump_back_is_noted_with_both_times_and_forgets_what_was_before() -> None:
    told = Told((7.5, 100.0), (7.0, 100.02), (7.02, 100.04))
    assert told.notes == ["/clock jumped back from 7.500 s to 7.000 s"]
    assert (told.set_back, told.clock.jumps) == (1, 1)
    assert told.clock.at(100 * SECOND) == 7 * SECOND


def test_a_jump_ahead_is_noted_and_nothing_is_set_back() -> None:
    told = Told((7.5, 100.0), (3600.0, 100.02))
    assert told.notes == ["/clock jumped ahead from 7.500 s to 3600.000 s"]
    assert (told.set_back, told.clock.jumps) == (0, 1)


@pytest.mark.parametrize(
    ("step", "here"), [(0.0, 5.0), (9.9, 0.001), (60.0, 60.0), (60.0, 0.61)], ids=["pause", "few", "gap", "fast"]
)
def test_what_a_fast_or_a_paused_simulation_does_is_no_jump(step: float, here: float) -> None:
    told = Told((7.5, 100.0), (7.5 + step, 100.0 + here))
    assert told.notes == []
