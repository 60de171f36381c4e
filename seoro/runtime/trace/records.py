"""The trace of a run: records, sent to observers as they are made.

Exact values in the trace identify instances, also equal ones. JSON has neither enumerations nor references. Each
instance of a struct, an actor, a scenario or an action has a number here; its fields are written where it first
occurs in a trace. Numbers start at 0 in that order, so that equal runs have equal numbers.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from itertools import count
from typing import TYPE_CHECKING, Any, Final, Protocol
from weakref import WeakKeyDictionary, WeakSet

from seoro.deferred import dataclass
from seoro.lang.plan import EnumValue
from seoro.lang.source import Span
from seoro.runtime.values.values import Actor, HasFields, Range, Struct, Value, Variable, plain

if TYPE_CHECKING:
    from seoro.runtime.contracts.observers import Observer


@dataclass(eq=False)
class Exact:
    """Numbers instances, and encodes values."""

    _numbers: WeakKeyDictionary[object, int] = field(default_factory=WeakKeyDictionary)
    _written: WeakSet[object] = field(default_factory=WeakSet)
    _next: count[int] = field(default_factory=count)

    def number(self, holder: object) -> int:
        """Return the number of an instance."""
        found = self._numbers.get(holder)
        if found is None:
            found = self._numbers[holder] = next(self._next)
        return found

    def fields(self, fields: Mapping[str, Value]) -> dict[str, Any]:
        """Encode values by name."""
        return {name: self.value(value) for name, value in fields.items()}

    def value(self, value: Value) -> object:
        """Encode a value for JSON."""
        match value:
            case EnumValue(type_name, member, number):
                return {"enum": type_name, "member": member, "number": number}
            case Struct() | Actor():
                return self._object(value)
            case Variable(holder=holder, name=name):
                return {"variable": name, "of": self._holder(holder)}
            case Range(low, high):
                return {"low": low, "high": high}
            case float() if not math.isfinite(value):
                return {"float": str(value)}
            case tuple():
                return [self.value(item) for item in value]
            case _:
                return value

    def _object(self, value: Struct | Actor) -> dict[str, Any]:
        if value in self._written:
            return {"object": self.number(value)}
        self._written.add(value)
        encoded: dict[str, Any] = {"object": self.number(value), "types": list(value.types)}
        if isinstance(value, Actor):
            encoded["actor"] = value.name
        return {**encoded, "fields": self.fields(value.fields)}

    def _holder(self, holder: HasFields) -> object:
        return self._object(holder) if isinstance(holder, Struct | Actor) else {"object": self.number(holder)}


OFFSET: Final = "+00:00"  # UTC
LOGS_KEPT: Final = 20  # number of last logs in the verdict


class RecordedEvent(Protocol):
    """An event as seen by trace records."""

    @property
    def name(self) -> str:
        """Name in the trace."""

    @property
    def short_name(self) -> str:
        """Name within the holder."""

    @property
    def holder(self) -> Callable[[], object]:
        """Weak reference to the holder."""


class Trace:
    """Numbers and stamps records. Each is a copy of its data, and does not change afterwards.

    Args:
        observers: Receivers of the records.
        now: Returns the time on the run's clock [s].
        failed: Called when an observer raises; that observer is then removed.
    """

    def __init__(
        self, observers: Sequence[Observer], now: Callable[[], float], failed: Callable[[Exception], None]
    ) -> None:
        self._observers = list(observers)
        self._now = now
        self._failed = failed
        self._numbers = count()
        self._last = 0.0  # time of the last record [s]
        self._second = -1  # of the last record, since the epoch
        self._second_text = ""
        self._logs: deque[tuple[float, str, str]] = deque(maxlen=LOGS_KEPT)
        self.exact = Exact()
        self.is_observed = bool(observers)  # whether any observer is left

    @property
    def last_logs(self) -> tuple[str, ...]:
        """The last logs, formatted: time, level unless it is `info`, message."""
        return tuple(
            f"{time:9.3f} s  " + ("" if level == "info" else f"{level}: ") + message
            for time, level, message in self._logs
        )

    def _wall(self) -> str:
        """Return the machine's time in the format of `datetime`, several times faster."""
        seconds, rest = divmod(time.time_ns(), 1_000_000_000)
        if seconds != self._second:
            self._second = seconds
            self._second_text = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(seconds))
        return f"{self._second_text}.{rest // 1000:06}{OFFSET}"

    def record(self, kind: str, cause: int | None = None, /, **fields: Any) -> int | None:
        """Add a record, and return its number; None without observers.

        Args:
            kind: Its kind.
            cause: Number of the record that brought it about, if known.
            fields: Its fields.
        """
        if cause is not None:
            fields["cause"] = cause
        return self._record(self._now(), kind, fields)

    def record_at(self, time: float, kind: str, /, **fields: Any) -> int | None:
        """Add a record of an earlier time, but not before the last record; return its number.

        Args:
            time: Its time on the run's clock [s].
            kind: Its kind.
            fields: Its fields.
        """
        return self._record(max(self._last, min(time, self._now())), kind, fields)

    def _record(self, time: float, kind: str, fields: Mapping[str, Any]) -> int | None:
        if not self._observers:
            return None
        self._last = time
        number = next(self._numbers)
        record = {
            "seq": number,
            "t": time,
            "wall": self._wall(),
            "kind": kind,
            **fields,
        }
        for observer in tuple(self._observers):
            try:
                observer.record(record)
            except Exception as error:
                self._observers.remove(observer)
                self.is_observed = bool(self._observers)
                self._failed(error)
        return number

    def log(self, message: str, level: str, source: Span) -> None:
        """Record a log message.

        Args:
            message: The message.
            level: `debug`, `info`, `warning` or `error`.
            source: Its origin in the scenario.
        """
        self._logs.append((self._now(), level, message))
        if self._observers:
            self.record("log", level=level, message=message, source=str(source))

    def event(
        self, path: str, arguments: Mapping[str, Value], cause: int | None = None, /, **fields: Any
    ) -> int | None:
        """Record an event; return the number of the record."""
        if not self._observers:
            return None
        shown = {name: plain(value) for name, value in arguments.items()}
        return self.record("event", cause, name=path, arguments=shown, **fields)

    def occurrence(
        self,
        event: RecordedEvent,
        arguments: Mapping[str, Value],
        cause: int | None,
        *,
        is_derived: bool = False,
        origin: str = "",
    ) -> int | None:
        """Record an event of an instance; return the number of the record.

        Args:
            event: The event.
            arguments: Its arguments.
            cause: Number of the record that brought it about.
            is_derived: Whether its specification occurred, without an `emit`.
            origin: Emitter other than the scenario.
        """
        holder = event.holder()
        if not self._observers or holder is None:
            return None
        fields: dict[str, Any] = {"of": self.exact.number(holder), "event": event.short_name}
        if is_derived:
            fields["derived"] = True
        if arguments:
            fields["exact"] = self.exact.fields(arguments)
        if origin:
            fields["origin"] = origin
        return self.event(event.name, arguments, cause, **fields)


def write_error_text(error: Exception) -> str:
    """Describe the failure of an observer."""
    match error:
        case OSError(filename=str() as name, strerror=str() as why):
            return f"cannot write the trace to {name}: {why}"
        case _:
            return f"cannot write the trace: {type(error).__name__}: {error}"
