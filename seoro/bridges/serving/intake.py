"""Limits of requests that are checked before a request is read: its size, and how many have no answer yet.

Who sends a request with a seal is known only after its signature was checked. So here the requests of all are
counted, and those of each client that has its name beside them; who serves them counts those of each certificate.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from seoro.bridges.session import Request
from seoro.bridges.wire.keys import verb_of
from seoro.bridges.wire.lab import EMERGENCY_STOP
from seoro.bridges.wire.limits import SMALL
from seoro.bridges.wire.message import Verb, encode
from seoro.bridges.wire.proving import has_seal
from seoro.bridges.wire.results import LabResult, Refusal, Result

MOST: Final = 1024  # requests without an answer
MOST_OF_ONE: Final = 64  # of those, with the same name beside them
MOST_BYTES: Final = 32 << 20  # that they have together; one alone may have more

_STOP: Final = EMERGENCY_STOP.name


class CountedIntake:
    """Accepts requests within limits; from any thread.

    Args:
        verbs: What can be asked for.
        called: What messages call whoever serves it.
        busy: Code of the refusal of one that is too many.
        waiting: Verbs whose requests wait for something: how many of each may at a time.
        stop: Takes emergency stops, which nothing else may hold up; None to leave them in the queue.
    """

    def __init__(
        self,
        verbs: Iterable[Verb[Any, Any]],
        called: str,
        busy: int = LabResult.UNAVAILABLE,
        waiting: Mapping[str, int] | None = None,
        stop: Callable[[Request], None] | None = None,
    ) -> None:
        self._sizes = {verb.name: verb.limits.size for verb in verbs}
        self._busy = _refusal(busy, f"the {called} is busy: ask again later")
        self._waiting = dict(waiting or {})
        self._stop = stop
        self._lock = threading.Lock()
        self._count, self._bytes = 0, 0
        self._of_verb: Counter[str] = Counter()
        self._of_sender: Counter[bytes] = Counter()

    def admit(self, key: str, size: int, beside: bytes) -> bytes:
        """Count a request, and return nothing; or return the refusal of one that exceeds a limit."""
        verb, sender = verb_of(key), _sender(beside)
        largest = self._sizes.get(verb, SMALL.size)
        if size > largest:
            why = f"a request for {verb[:50]!r} has {size} bytes: at most {largest} are accepted"
            return _refusal(Result.OPERATION_FAILED, why)
        with self._lock:
            busy = verb != _STOP and self._is_busy(verb, size, sender)
            if not busy:
                self._add(verb, size, sender, 1)
        return self._busy if busy else b""

    def _is_busy(self, verb: str, size: int, sender: bytes) -> bool:
        return (
            self._count >= MOST
            or (self._bytes > 0 and self._bytes + size > MOST_BYTES)
            or self._of_verb[verb] >= self._waiting.get(verb, MOST)
            or (bool(sender) and self._of_sender[sender] >= MOST_OF_ONE)
        )

    def _add(self, verb: str, size: int, sender: bytes, by: int) -> None:
        self._count += by
        self._bytes += by * size
        if verb in self._waiting:
            self._of_verb[verb] += by
        if sender:
            self._of_sender[sender] += by
            if not self._of_sender[sender]:  # names of clients do not come again
                del self._of_sender[sender]

    def end(self, key: str, size: int, beside: bytes) -> None:
        """Note that an accepted request has its answer."""
        with self._lock:
            self._add(verb_of(key), size, _sender(beside), -1)

    def divert(self, request: Request) -> bool:
        """Pass an emergency stop on to where it is obeyed at once; False for all other requests."""
        if self._stop is None or verb_of(request.key) != _STOP:
            return False
        self._stop(request)
        return True


def _sender(beside: bytes) -> bytes:
    """The name of a client; empty where there is a seal, which anybody may have copied."""
    return b"" if has_seal(beside) else beside


def _refusal(code: int, message: str) -> bytes:
    return encode(Refusal(code=code, message=message))
