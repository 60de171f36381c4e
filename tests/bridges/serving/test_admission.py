"""Limits of requests before their decoding."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.serving.admission import MOST, MOST_BYTES, MOST_OF_ONE, AdmissionLimits
from seoro.bridges.wire.refusal import read_refusal

HOLD_ROBOTS = replace(wire.HOLD_ROBOTS, max_pending=5)
VERBS: tuple[wire.Verb[Any, Any], ...] = (
    wire.GET_LAB_STATE,
    wire.RESTORE_STATE,
    HOLD_ROBOTS,
    wire.EMERGENCY_STOP,
)
SEAL = b"\x95a seal"


def key(verb: wire.Verb[Any, Any]) -> str:
    return wire.node_command("default", "hall", verb.name)


STATE, RESTORE = key(wire.GET_LAB_STATE), key(wire.RESTORE_STATE)
HOLD, STOP = key(wire.HOLD_ROBOTS), key(wire.EMERGENCY_STOP)


@pytest.fixture
def intake() -> AdmissionLimits:
    return AdmissionLimits(VERBS, "node", 7)


def fill(intake: AdmissionLimits, key: str, count: int, size: int = 10, attachment: bytes = b"") -> list[int]:
    """Send some requests, and return the codes of refusals."""
    answers = [intake.admit(key, size, attachment) for _ in range(count)]
    return [read_refusal(answer).code for answer in answers if answer]


def test_too_large_requests_are_refused_by_the_limit_of_their_verb(intake: AdmissionLimits) -> None:
    refusal = read_refusal(intake.admit(STATE, 15_000_000, b""))
    assert refusal.message == "a request for 'get_lab_state' has 15000000 bytes; expected at most 65536"
    assert read_refusal(intake.admit("seoro/1/default/node/hall/cmd/no_verb", 65_537, b"")).code != 0
    assert not intake.admit(RESTORE, 15_000_000, b"")


def test_the_number_of_unanswered_requests_is_limited(intake: AdmissionLimits) -> None:
    assert fill(intake, STATE, MOST + 2) == [7, 7]
    intake.end(STATE, 10, b"")
    assert fill(intake, STATE, 2) == [7]


def test_the_number_of_waiting_requests_is_limited(intake: AdmissionLimits) -> None:
    assert fill(intake, HOLD, 7) == [7, 7]
    assert not intake.admit(STATE, 10, b"")
    intake.end(HOLD, 10, b"")
    assert fill(intake, HOLD, 2) == [7]


def test_the_number_of_requests_of_a_client_is_limited(intake: AdmissionLimits) -> None:
    assert fill(intake, STATE, MOST_OF_ONE + 3, attachment=b"a run") == [7] * 3
    assert not intake.admit(STATE, 10, b"another run")
    intake.end(STATE, 10, b"a run")
    assert fill(intake, STATE, 2, attachment=b"a run") == [7]


def test_copied_signatures_do_not_use_the_share_of_their_signer(intake: AdmissionLimits) -> None:
    assert fill(intake, STATE, MOST_OF_ONE + 3, attachment=SEAL) == []


def test_the_size_of_waiting_requests_is_limited(intake: AdmissionLimits) -> None:
    large = MOST_BYTES // 2
    assert fill(intake, RESTORE, 3, size=large) == [7]
    intake.end(RESTORE, large, b"")
    assert fill(intake, RESTORE, 1, size=large) == []


def test_emergency_stops_are_admitted_beyond_the_limits(intake: AdmissionLimits) -> None:
    fill(intake, STATE, MOST + 1)
    assert not intake.admit(STOP, 100, b"")
    assert intake.admit(STOP, 100_000, b"")
