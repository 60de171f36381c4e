from __future__ import annotations

import numpy as np

from sim_nodes.noise import Noise


def test_a_draw_does_not_depend_on_draws_before_it() -> None:
    quiet, busy = Noise(3, "odometry"), Noise(3, "odometry")
    for tick in range(10):
        busy.at(tick).normal(size=100)
    assert quiet.at(7).normal() == busy.at(7).normal()


def test_seed_purpose_and_tick_change_the_numbers() -> None:
    draws = {Noise(*source).at(tick).normal() for source in ((1, "a"), (2, "a"), (1, "b")) for tick in (1, 2)}
    assert len(draws) == 6


def test_a_tick_starts_over_after_an_unfinished_draw() -> None:
    noise = Noise(1, "lidar")
    noise.at(3).random(dtype=np.float32)  # keeps half of a number of 64 bits
    fresh = Noise(1, "lidar").at(4)
    assert noise.at(4).random(3, dtype=np.float32).tolist() == fresh.random(3, dtype=np.float32).tolist()
