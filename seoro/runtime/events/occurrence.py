"""`Occurrence`: an event for applications, read from a trace record."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

APPLICATION: Final = "application"  # origin of events emitted by an application

_ATTEMPT: Final = re.compile(r"#\d+")


class Occurrence(NamedTuple):
    """One occurrence of an event.

    Args:
        time: Time of the occurrence, on the run's clock [s].
        name: Name of the event in the trace.
        arguments: Its arguments as plain values: numbers in SI base units, enumerations as `color!red`.
    """

    time: float
    name: str
    arguments: Mapping[str, Any]


def occurrence_in(record: Mapping[str, Any]) -> Occurrence:
    """Return the occurrence of an `event` record."""
    return Occurrence(record["t"], record["name"], record["arguments"])


def is_emitted_outside(record: Mapping[str, Any]) -> bool:
    """Whether a record is an event emitted by an application."""
    return record.get("kind") == "event" and record.get("origin") == APPLICATION


def without_attempts(name: str) -> str:
    """Return the trace name of an event without attempts of modifiers: `main.go` for `main#2.go`."""
    return _ATTEMPT.sub("", name) if "#" in name else name
