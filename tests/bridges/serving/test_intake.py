"""What is accepted, before a request is read."""

from __future__ import annotations

from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.serving.intake import MOST, MOST_BYTES, MOST_OF_ONE, CountedIntake
from seoro.bridges.wire.refusal import said_in

VERBS: tuple[wire.Verb[Any, Any], ...] = (
    wire.GET_LAB_STATE,
    wire.RESTORE_STATE,
    wire.HOLD_ROBOTS,
    wire.EMERGENCY_STOP,
)
SEAL = b"\x95a seal"


def key(verb: wire.Verb[Any, Any]) -> str:
    return wire.node_command("default", "hall", verb.name)


STATE, RESTORE = key(wire.GET_LAB_STATE), key(wire.RESTORE_STATE)
HOLD, STOP = key(wire.HOLD_ROBOTS), key(wire.EMERGENCY_STOP)


@pytest.fixture
def intake() -> CountedIntake:
    return CountedIntake(VERBS, "node", 7, {wire.HOLD_ROBOTS.name: 5})


def fill(intake: CountedIntake, key: str, count: int, size: int = 10, beside: bytes = b"") -> list[int]:
    """Codes of the refusals of some requests."""
    answers = [intake.admit(key, size, beside) for _ in range(count)]
    return [said_in(answer).code for answer in answers if answer]


def test_a_request_that_is_too_large_is_refused_by_its_verb(intake: CountedIntake) -> None:
    refusal = said_in(intake.admit(STATE, 15_000_000, b""))
    assert refusal.message == "a request for 'get_lab_state' has 15000000 bytes: at most 65536 are accepted"
    assert said_in(intake.admit("seoro/1/default/node/hall/cmd/no_verb", 65_537, b"")).code != 0
    assert not intake.admit(RESTORE, 15_000_000, b"")


def test_no_more_than_so_many_have_no_answer(intake: CountedIntake) -> None:
    assert fill(intake, STATE, MOST + 2) == [7, 7]
    intake.end(STATE, 10, b"")
    assert fill(intake, STATE, 2) == [7]


def test_no_more_than_so_many_wait(intake: CountedIntake) -> None:
    assert fill(intake, HOLD, 7) == [7, 7]
    assert not intake.admit(STATE, 10, b"")
    intake.end(HOLD, 10, b"")
    assert fill(intake, HOLD, 2) == [7]


def test_a_client_leaves_room_for_others(intake: CountedIntake) -> None:
    assert fill(intake, STATE, MOST_OF_ONE + 3, beside=b"a run") == [7] * 3
    assert not intake.admit(STATE, 10, b"another run")
    intake.end(STATE, 10, b"a run")
    assert fill(intake, STATE, 2, beside=b"a run") == [7]


def test_a_seal_that_was_copied_takes_room_from_nobody(intake: CountedIntake) -> None:
    assert fill(intake, STATE, MOST_OF_ONE + 3, beside=SEAL) == []


def test_what_waits_has_no_more_bytes_than_so_many(intake: CountedIntake) -> None:
    large = MOST_BYTES // 2
    assert fill(intake, RESTORE, 3, size=large) == [7]
    intake.end(RESTORE, large, b"")
    assert fill(intake, RESTORE, 1, size=large) == []


def test_an_emergency_stop_is_never_too_many(intake: CountedIntake) -> None:
    fill(intake, STATE, MOST + 1)
    assert not intake.admit(STOP, 100, b"")
    assert intake.admit(STOP, 100_000, b"")
