"""The trace of a run: records as they happen, handed to observers; JSON Lines is one of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from itertools import count
from typing import IO, Any

from seoro.runtime.contracts import Observer
from seoro.runtime.values import Value, plain


class Trace:
    """Numbers and stamps records.

    Args:
        observers: Who sees them.
        now: The run's clock [s].
        failed: Called when an observer raises; it sees no more records.
    """

    def __init__(
        self, observers: Sequence[Observer], now: Callable[[], float], failed: Callable[[Exception], None]
    ) -> None:
        self._observers = list(observers)
        self._now = now
        self._failed = failed
        self._numbers = count()

    def record(self, kind: str, **fields: Any) -> None:
        """Add a record."""
        record = {
            "seq": next(self._numbers),
            "t": self._now(),
            "wall": datetime.now(UTC).isoformat(timespec="microseconds"),
            "kind": kind,
            **fields,
        }
        for observer in tuple(self._observers):
            try:
                observer.record(record)
            except Exception as error:
                self._observers.remove(observer)
                self._failed(error)

    def event(self, path: str, arguments: Mapping[str, Value]) -> None:
        """Record that an event occurred."""
        self.record("event", name=path, arguments={name: plain(value) for name, value in arguments.items()})


class JsonLines:
    """Writes records to a text file, one JSON object a line."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def record(self, record: dict[str, Any]) -> None:
        """Write a record; at the end of the run, all of them are in the file."""
        self._file.write(json.dumps(record, ensure_ascii=False) + "\n")
        if record["kind"] == "run.end":
            self._file.flush()
