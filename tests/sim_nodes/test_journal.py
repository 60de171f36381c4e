"""Recording and replay of the calls of an engine."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
import pytest

from sim_nodes import journal
from sim_nodes.codec import pack, unpack
from sim_nodes.journal import Journal, calls_of
from sim_nodes.physics import BodyModel, BodyState, Box, Part, UnsavableState

CUBE = BodyModel((Part(Box((0.1, 0.1, 0.1))),))


def kept(calls: list[tuple[int, str, tuple[Any, ...]]], after: int = 0) -> Any:
    """Return the saved form of calls, each after a number of steps, after encoding and decoding."""
    noted, made = Journal(), 0
    for steps, method, arguments in calls:
        noted.step(steps - made)
        made = steps
        noted.record(method, arguments)
    noted.step(after)
    return unpack(pack(noted.save()))


def bits(arguments: tuple[Any, ...]) -> list[bytes | Any]:
    return [struct.pack("d", each) if isinstance(each, float) else each for each in arguments]


def test_calls_are_restored_bit_identically_and_in_order() -> None:
    calls: list[tuple[int, str, tuple[Any, ...]]] = [
        (0, "command", ("one", 0.1, -0.0)),
        (0, "command", ("two", math.pi, 1e-310)),
        (7, "power", ("one", False)),
        (7, "power", ("one", True)),
        (5_000_000_000, "command", ("one", 0.1, 0.0)),
        (5_000_000_001, "put", ("cube", CUBE, BodyState((0.0, -0.0, 0.0)))),
        (5_000_000_001, "put", ("cube", CUBE, BodyState((0.0, 0.0, 0.0)))),
    ]
    found = list(calls_of(kept(calls)))
    assert found == calls
    assert [bits(arguments) for _, _, arguments in found] == [bits(arguments) for _, _, arguments in calls]
    assert [math.copysign(1.0, arguments[2].position[1]) for _, _, arguments in found[5:]] == [-1.0, 1.0]


def test_rows_of_numbers_are_copies() -> None:
    noted, row = Journal(), np.array([1.0, 2.0, 3.0])
    noted.record("move", ("arm", row, 5.0, row * 2.0))
    row[:] = 0.0
    [(_, method, (name, first, number, second))] = calls_of(unpack(pack(noted.save())))
    assert (method, name, first.tolist(), number, second.tolist()) == ("move", "arm", [1, 2, 3], 5.0, [2, 4, 6])
    first[0] = 9.0  # the caller may change the array later


def test_commands_need_little_memory() -> None:
    calls: list[tuple[int, str, tuple[Any, ...]]] = [
        (number, "command", ("robot", 0.1 * number, 0.2)) for number in range(1000)
    ]
    assert len(pack(kept(calls))) < 1000 * 32


def test_a_full_journal_refuses_to_save(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal, "MAX_NUMBERS", 4)
    noted = Journal()
    for _ in range(2):
        noted.record("move", (1.0, 2.0))
    noted.save()
    noted.record("move", (1.0,))
    with pytest.raises(UnsavableState, match=r"than the limit \(2000000 calls, 4 numbers\)"):
        noted.save()


def test_cutting_removes_calls_since_a_mark() -> None:
    plain, cut = Journal(), Journal()
    for each in (plain, cut):
        each.record("command", ("one", 0.1))
        each.record("put", (CUBE, 1.0))
        each.step(5)
    mark = cut.mark()
    assert mark is not None
    for _ in range(2):
        cut.record("command", ("two", 0.2))
        cut.record("put", (CUBE, 2.0))
        cut.step(3)
        cut.cut(mark)
    for each in (plain, cut):
        each.record("command", ("two", 0.3))
        each.record("command", ("one", 0.4))
        each.step(1)
    assert pack(cut.save()) == pack(plain.save())


def test_a_full_journal_can_be_cut_to_an_earlier_mark(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal, "MAX_NUMBERS", 2)
    noted = Journal()
    noted.record("command", (1.0,))
    mark = noted.mark()
    assert mark is not None
    noted.record("row", (np.array([1.0, 2.0]),))
    assert noted.mark() is None
    noted.cut(mark)
    assert [arguments for _, _, arguments in calls_of(noted.save())] == [(1.0,)]
