"""The calls of an engine, as they are kept and made again."""

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
    """What is saved of some calls, each after a number of steps, as it comes out of a file."""
    noted, made = Journal(), 0
    for steps, method, arguments in calls:
        noted.step(steps - made)
        made = steps
        noted.note(method, arguments)
    noted.step(after)
    return unpack(pack(noted.save()))


def bits(arguments: tuple[Any, ...]) -> list[bytes | Any]:
    return [struct.pack("d", each) if isinstance(each, float) else each for each in arguments]


def test_calls_come_back_to_the_bit_and_in_their_order() -> None:
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
    noted.note("move", ("arm", row, 5.0, row * 2.0))
    row[:] = 0.0
    [(_, method, (name, first, number, second))] = calls_of(unpack(pack(noted.save())))
    assert (method, name, first.tolist(), number, second.tolist()) == ("move", "arm", [1, 2, 3], 5.0, [2, 4, 6])
    first[0] = 9.0  # whoever is told it may change it


def test_commands_take_little_room() -> None:
    calls: list[tuple[int, str, tuple[Any, ...]]] = [
        (number, "command", ("robot", 0.1 * number, 0.2)) for number in range(1000)
    ]
    assert len(pack(kept(calls))) < 1000 * 32


def test_a_journal_with_too_much_in_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal, "MAX_NUMBERS", 4)
    noted = Journal()
    for _ in range(2):
        noted.note("move", (1.0, 2.0))
    noted.save()
    noted.note("move", (1.0,))
    with pytest.raises(UnsavableState, match=r"more than is kept \(2000000 things, 4 numbers\)"):
        noted.save()


def test_what_was_noted_since_a_mark_is_cut_off() -> None:
    plain, cut = Journal(), Journal()
    for each in (plain, cut):
        each.note("command", ("one", 0.1))
        each.note("put", (CUBE, 1.0))
        each.step(5)
    mark = cut.mark()
    assert mark is not None
    for _ in range(2):
        cut.note("command", ("two", 0.2))
        cut.note("put", (CUBE, 2.0))
        cut.step(3)
        cut.cut(mark)
    for each in (plain, cut):
        each.note("command", ("two", 0.3))
        each.note("command", ("one", 0.4))
        each.step(1)
    assert pack(cut.save()) == pack(plain.save())


def test_a_full_journal_has_no_mark_but_goes_back_to_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal, "MAX_NUMBERS", 2)
    noted = Journal()
    noted.note("command", (1.0,))
    mark = noted.mark()
    assert mark is not None
    noted.note("row", (np.array([1.0, 2.0]),))
    assert noted.mark() is None
    noted.cut(mark)
    assert [arguments for _, _, arguments in calls_of(noted.save())] == [(1.0,)]
