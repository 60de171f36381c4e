"""Batches of steps end soon, and their sizes do not change results."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import Any, cast

import pytest

from sim_nodes.pace import TARGET, Batches
from sim_nodes.physics import Engine

NOTHING: frozenset[tuple[str, str]] = frozenset()
PAIR = frozenset({("a", "b")})


class Slow:
    """An engine with slow steps, in which a contact begins at a step."""

    def __init__(self, each: float, touches_after: int = 1 << 30) -> None:
        self.now = 0.0
        self.made = 0
        self.batches: list[int] = []
        self.after_step: Callable[[], Any] = lambda: None
        self._each = each
        self._touches_after = touches_after

    def clock(self) -> float:
        return self.now

    def step(self, count: int = 1) -> int:
        before, begun = self.touching(), self.made
        while self.made < begun + count and self.touching() == before:
            self.made += 1
            self.now += self._each
        self.batches.append(self.made - begun)
        self.after_step()
        return self.made - begun

    def touching(self) -> frozenset[tuple[str, str]]:
        return PAIR if self.made >= self._touches_after else NOTHING


def make(engine: Slow, count: int, halted: Event | None = None) -> int:
    return Batches(engine.clock).make(cast("Engine", engine), count, halted or Event())


@pytest.mark.parametrize("each", [1e-4, 0.01, 0.2])
def test_a_batch_keeps_its_target_time_and_has_at_least_one_step(each: float) -> None:
    engine = Slow(each)
    assert make(engine, 1000) == engine.made == 1000
    assert max(engine.batches) * each <= max(TARGET, each) + 1e-9
    assert len(engine.batches) <= 1000 * each / TARGET + 10 or each > TARGET


def test_an_emergency_stop_ends_steps_after_a_batch() -> None:
    engine, halted = Slow(0.02), Event()
    engine.after_step = lambda: halted.set() if engine.made >= 3 else None
    assert make(engine, 500, halted) == 3


@pytest.mark.parametrize("touches_after", range(1, 12))
def test_steps_end_where_contacts_change_also_at_the_end_of_a_batch(touches_after: int) -> None:
    engine = Slow(0.02, touches_after)
    assert make(engine, 500) == engine.made == touches_after
