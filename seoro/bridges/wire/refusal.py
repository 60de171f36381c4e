"""How those who serve the wire refuse requests, what is read of that at the other end, and the checks that several
verbs make of what requests hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from seoro.bridges.wire.limits import ANSWER
from seoro.bridges.wire.message import WireError, decode
from seoro.bridges.wire.results import Refusal, Result

MAX_ID = 200  # [characters]
MAX_LISTED = 20  # names in a message
LONGEST_DRIVE = 86_400.0  # [s] that a robot may be asked to drive


class RequestRefused(Exception):
    """A request cannot be carried out.

    Args:
        code: One of the result codes of the wire.
        message: A sentence that says what is wrong and what would be right.
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = int(code)
        self.message = message


def said_in(payload: bytes) -> Refusal:
    """What was said with a refusal; words that are no message are taken as they are."""
    try:
        return decode(Refusal, payload, ANSWER)
    except WireError:
        return Refusal(code=Result.OPERATION_FAILED, message=payload[:200].decode(errors="replace"))


def listed(names: Iterable[str]) -> str:
    """Names for a message, sorted; the first `MAX_LISTED` of them."""
    known = sorted(names)
    shown = ", ".join(known[:MAX_LISTED]) or "none"
    return shown if len(known) <= MAX_LISTED else f"{shown} and {len(known) - MAX_LISTED} more"


def check_id(identifier: str) -> None:
    """Refuse ids that are empty or too long."""
    if not 1 <= len(identifier) <= MAX_ID:
        raise RequestRefused(Result.OPERATION_FAILED, f"an id has 1 to {MAX_ID} characters, not {len(identifier)}")


def check_finite(what: str, *values: float) -> None:
    """Refuse values that are no finite numbers; `what` names them."""
    if not all(math.isfinite(value) for value in values):
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} {values} has a part that is no finite number")


def check_positive(what: str, value: float, unit: str = "") -> None:
    """Refuse values that are not above zero, which `unit` follows in the message; `what` names them."""
    if not (math.isfinite(value) and value > 0.0):
        least = f"0 {unit}".rstrip()
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} is {value}: it has to be more than {least}")


def check_drive_duration(duration: float) -> None:
    """Refuse to drive for no time, or for longer than `LONGEST_DRIVE`; in seconds."""
    if not 0.0 < duration <= LONGEST_DRIVE:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the duration is {duration} s: it has to be more than 0 and at most {LONGEST_DRIVE:g} s",
        )
