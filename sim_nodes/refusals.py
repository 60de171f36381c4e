"""Refusals of requests with the common result codes."""

from __future__ import annotations

from collections.abc import Iterable

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, name_list


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
