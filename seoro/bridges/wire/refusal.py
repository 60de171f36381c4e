"""Refusals of requests: raising and decoding them, and common checks of the values of requests."""

from __future__ import annotations

import math
from collections.abc import Iterable

from seoro.bridges.wire.limits import ANSWER
from seoro.bridges.wire.message import A, Q, Verb, WireError, decode
from seoro.bridges.wire.results import Refusal, Result

MAX_ID = 200  # [characters]
MAX_LISTED = 20  # names in a message
LONGEST_DRIVE = 86_400.0  # [s] maximum duration of driving


class RequestRefused(Exception):
    """A request cannot be carried out.

    Args:
        code: One of the result codes of the wire.
        message: Error message: the problem, and the expected value.
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = int(code)
        self.message = message


def read_request(verb: Verb[Q, A], payload: bytes) -> Q:
    """Decode a request.

    Raises:
        RequestRefused: The request is invalid.
    """
    try:
        return verb.read(payload)
    except WireError as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


def read_refusal(payload: bytes) -> Refusal:
    """Decode a refusal; an undecodable payload is used as the message."""
    try:
        return decode(Refusal, payload, ANSWER)
    except WireError:
        return Refusal(code=Result.OPERATION_FAILED, message=payload[:200].decode(errors="replace"))


def name_list(names: Iterable[str]) -> str:
    """Return the first `MAX_LISTED` names in alphabetical order, as text."""
    known = sorted(names)
    shown = ", ".join(known[:MAX_LISTED]) or "none"
    return shown if len(known) <= MAX_LISTED else f"{shown} and {len(known) - MAX_LISTED} more"


def check_id(identifier: str) -> None:
    """Refuse ids that are empty or too long."""
    if not 1 <= len(identifier) <= MAX_ID:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"the id has {len(identifier)} characters; expected 1 to {MAX_ID}"
        )


def check_finite(what: str, *values: float) -> None:
    """Refuse values that are not finite; `what` names them."""
    if not all(math.isfinite(value) for value in values):
        raise RequestRefused(Result.OPERATION_FAILED, f"invalid {what} {values}; expected finite numbers")


def check_positive(what: str, value: float, unit: str = "") -> None:
    """Refuse values that are not above zero; `what` names the value, `unit` is its unit in the message."""
    if not (math.isfinite(value) and value > 0.0):
        least = f"0 {unit}".rstrip()
        raise RequestRefused(Result.OPERATION_FAILED, f"invalid {what} {value}; expected more than {least}")


def check_drive_duration(duration: float) -> None:
    """Refuse durations [s] that are not above zero, or longer than `LONGEST_DRIVE`."""
    if not 0.0 < duration <= LONGEST_DRIVE:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid duration {duration} s; expected more than 0 and at most {LONGEST_DRIVE:g} s",
        )
