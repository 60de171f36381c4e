"""The trace of a run: records as they happen, handed to observers."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from itertools import count
from typing import TYPE_CHECKING, Any, Final

from seoro.lang.source import Span
from seoro.runtime.contracts import Observer
from seoro.runtime.exact import Exact
from seoro.runtime.values import Value, plain

if TYPE_CHECKING:
    from seoro.runtime.events import Event

OFFSET: Final = "+00:00"  # from UTC
LOGS_KEPT: Final = 20  # of the last ones, for the verdict


class Trace:
    """Numbers and stamps records, each of which is a copy of what it tells: it does not change afterwards.

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
        self._second = -1  # since the epoch, of the last record
        self._second_text = ""
        self._logs: deque[tuple[float, str, str]] = deque(maxlen=LOGS_KEPT)
        self.exact = Exact()

    @property
    def last_logs(self) -> tuple[str, ...]:
        """The last logs, as people read them: time, level unless it is `info`, message."""
        return tuple(
            f"{time:9.3f} s  " + ("" if level == "info" else f"{level}: ") + message
            for time, level, message in self._logs
        )

    @property
    def is_observed(self) -> bool:
        """Whether anybody sees the records."""
        return bool(self._observers)

    def _wall(self) -> str:
        """The time by the machine's clock, as `datetime` has it, in a fraction of the time that takes."""
        seconds, rest = divmod(time.time_ns(), 1_000_000_000)
        if seconds != self._second:
            self._second = seconds
            self._second_text = datetime.fromtimestamp(seconds, UTC).isoformat()[: -len(OFFSET)]
        return f"{self._second_text}.{rest // 1000:06}{OFFSET}"

    def record(self, kind: str, **fields: Any) -> None:
        """Add a record."""
        if not self._observers:
            return
        record = {
            "seq": next(self._numbers),
            "t": self._now(),
            "wall": self._wall(),
            "kind": kind,
            **fields,
        }
        for observer in tuple(self._observers):
            try:
                observer.record(record)
            except Exception as error:
                self._observers.remove(observer)
                self._failed(error)

    def log(self, message: str, level: str, source: Span) -> None:
        """Record a message.

        Args:
            message: The message.
            level: `debug`, `info`, `warning` or `error`.
            source: What it comes from.
        """
        self._logs.append((self._now(), level, message))
        if self._observers:
            self.record("log", level=level, message=message, source=str(source))

    def event(self, path: str, arguments: Mapping[str, Value], **fields: Any) -> None:
        """Record that an event occurred."""
        if self._observers:
            shown = {name: plain(value) for name, value in arguments.items()}
            self.record("event", name=path, arguments=shown, **fields)

    def occurrence(self, event: Event, arguments: Mapping[str, Value], *, is_derived: bool) -> None:
        """Record that an event of an instance occurred.

        Args:
            event: The event.
            arguments: Its arguments.
            is_derived: Whether it was not emitted, but what it is declared to be has occurred.
        """
        holder = event.holder()
        if self._observers and holder is not None:
            fields: dict[str, Any] = {"of": self.exact.number(holder), "event": event.name}
            if is_derived:
                fields["derived"] = True
            if arguments:
                fields["exact"] = self.exact.fields(arguments)
            self.event(event.path, arguments, **fields)


def unwritten(error: Exception) -> str:
    """What an observer's exception means for the run, in a sentence."""
    match error:
        case OSError(filename=str() as name, strerror=str() as why):
            return f"the trace cannot be written to {name}: {why}"
        case _:
            return f"the trace cannot be written: {type(error).__name__}: {error}"
