"""How a request is refused."""

from __future__ import annotations

import math
from collections.abc import Iterable

from seoro.bridges.wire import Result

MAX_ID = 200  # [characters]


class RequestRefused(Exception):
    """A request cannot be carried out.

    Args:
        code: One of the result codes of the wire.
        message: The reason, for people.
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message


def listed(names: Iterable[str]) -> str:
    """Names for a sentence."""
    return ", ".join(sorted(names)) or "none"


def check_id(identifier: str) -> None:
    """Refuse ids that are empty or too long."""
    if not 1 <= len(identifier) <= MAX_ID:
        raise RequestRefused(Result.OPERATION_FAILED, f"an id has 1 to {MAX_ID} characters, not {len(identifier)}")


def check_finite(what: str, *values: float) -> None:
    """Refuse values that are no finite numbers; `what` names them."""
    if not all(math.isfinite(value) for value in values):
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} {values} has a part that is no finite number")


def check_positive(what: str, value: float) -> None:
    """Refuse values that are not above zero; `what` names it."""
    if not (math.isfinite(value) and value > 0.0):
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} is {value}: it has to be more than 0")
