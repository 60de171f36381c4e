"""Outcomes of requests: refusals with the common result codes, and results of goals, each of which ends once."""

from __future__ import annotations

from collections.abc import Iterable

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.deferred import dataclass


def operation_failed(message: str) -> RequestRefused:
    """Return a refusal because of an invalid value."""
    return RequestRefused(Result.OPERATION_FAILED, message)


def incorrect_state(message: str) -> RequestRefused:
    """Return a refusal because of the present state."""
    return RequestRefused(Result.INCORRECT_STATE, message)


def feature_unsupported(message: str) -> RequestRefused:
    """Return a refusal because of a missing feature."""
    return RequestRefused(Result.FEATURE_UNSUPPORTED, message)


def unknown(what: str, listed: str, known: Iterable[str]) -> RequestRefused:
    """Return a refusal because of an unknown name; `listed` is the plural for the list of the known ones."""
    return RequestRefused(Result.NOT_FOUND, f"unknown {what}; {listed}: {name_list(known)}")


NO_CLIENT = ""  # id of a goal whose client is gone; clients cannot use it


@dataclass(frozen=True)
class GoalResult:
    """Result of a goal or watch, with the id given by its client; other fields as in `Occurrence`."""

    id: str
    outcome: Outcome
    message: str = ""
    interrupted: bool = False
    margin: float | None = None
