"""Slices of playing simulators: short enough for requests, but not shorter."""

from __future__ import annotations

import math

import pytest

from sim_nodes.pace import FULL_SPEED_SLICES, Pace


def slices(seconds: float, rate: float = math.inf) -> list[float]:
    """Return the lengths of consecutive slices [s]; `seconds` is their wall time per simulated second."""
    pace, clock, now, found = Pace(rate), 100.0, 0.0, []
    for _ in range(20):
        until = pace.until(clock, now)
        found.append(until - now)
        clock += (until - now) * seconds
        now = until
    return found


@pytest.mark.parametrize(("seconds", "wanted"), [(0.003, 1.0), (0.05, 0.25), (5.0, FULL_SPEED_SLICES[0])])
def test_slices_at_full_speed_adapt_to_the_wall_time(seconds: float, wanted: float) -> None:
    found = slices(seconds)
    assert found[0] == FULL_SPEED_SLICES[0]
    assert found[-1] == wanted


def test_slices_at_full_speed_end_at_multiples_of_their_length() -> None:
    pace = Pace(math.inf)
    pace.until(0.0, 0.1)
    assert pace.until(1e-4, 0.15) == 0.1875
    assert pace.until(2e-4, 0.1875) == 0.25
    assert pace.until(3e-4, 0.25) == 0.5
