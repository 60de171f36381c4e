"""Clock that follows `/clock`."""

import pytest

from seoro.bridges.ros2.clock import HISTORY, SECOND, SimClock


class Reported:
    """A clock with times [s] at times of this machine [s], and its notes."""

    def __init__(self, *times: tuple[float, float]) -> None:
        self.notes: list[str] = []
        self.set_back = 0
        self.clock = SimClock(self.notes.append, self._count)
        for now, here in times:
            self.clock.set(round(now * SECOND), round(here * SECOND))

    def _count(self) -> None:
        self.set_back += 1


def test_a_message_has_the_last_clock_time_before_its_arrival() -> None:
    reported = Reported((5.0, 100.0), (5.02, 100.04), (5.04, 100.08))
    assert reported.clock.now == round(5.04 * SECOND)
    for here, now in ((100.0, 5.0), (100.05, 5.02), (100.079, 5.02), (200.0, 5.04), (99.0, 5.0)):
        assert reported.clock.at(round(here * SECOND)) == round(now * SECOND)
    assert not reported.notes


def test_the_clock_history_is_bounded() -> None:
    reported = Reported(*((float(number), float(number)) for number in range(2 * HISTORY)))
    assert reported.clock.at(0) == HISTORY * SECOND


def test_a_jump_back_is_logged_with_both_times_and_drops_the_history() -> None:
    reported = Reported((7.5, 100.0), (7.0, 100.02), (7.02, 100.04))
    assert reported.notes == ["/clock jumped back from 7.500 s to 7.000 s"]
    assert (reported.set_back, reported.clock.jumps) == (1, 1)
    assert reported.clock.at(100 * SECOND) == 7 * SECOND


def test_a_jump_ahead_is_logged_and_does_not_reset() -> None:
    reported = Reported((7.5, 100.0), (3600.0, 100.02))
    assert reported.notes == ["/clock jumped ahead from 7.500 s to 3600.000 s"]
    assert (reported.set_back, reported.clock.jumps) == (0, 1)


@pytest.mark.parametrize(
    ("step", "here"), [(0.0, 5.0), (9.9, 0.001), (60.0, 60.0), (60.0, 0.61)], ids=["pause", "few", "gap", "fast"]
)
def test_fast_and_paused_simulations_log_no_jump(step: float, here: float) -> None:
    reported = Reported((7.5, 100.0), (7.5 + step, 100.0 + here))
    assert reported.notes == []
