"""Limits of requests that are checked before a request is decoded: its size, and the number of pending requests.

The sender of a signed request is known only after its signature was checked. So this module counts all requests,
and those with the same client name beside them. The authorizer counts those of each certificate.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, Final

from seoro.bridges.session import AdmissionPolicy, Request
from seoro.bridges.wire.authentication import has_signature
from seoro.bridges.wire.keys import verb_of
from seoro.bridges.wire.lab import EMERGENCY_STOP
from seoro.bridges.wire.message import MAX_PENDING, Empty, Verb, encode
from seoro.bridges.wire.results import LabResult, Refusal, Result

MOST: Final = MAX_PENDING  # requests without a reply
MOST_OF_ONE: Final = 64  # requests without a reply with the same client name
MOST_BYTES: Final = 32 << 20  # [bytes] of all requests without a reply; a single request may be larger

_UNKNOWN: Final = Verb("unknown", Empty, Empty)  # stands for all unknown verbs


class AdmissionLimits(AdmissionPolicy):
    """Counts pending requests, and refuses those above the limits; from any thread.

    Args:
        verbs: Accepted verbs.
        server: Kind of the server, for messages.
        busy: Code of the refusal of a request above the limits.
        stop: Handler of emergency stops, which bypass the queue; None to leave them in the queue.

    Attributes:
        busy: Encoded refusal of requests above the limits.
    """

    def __init__(
        self,
        verbs: Iterable[Verb[Any, Any]],
        server: str,
        busy: int = LabResult.UNAVAILABLE,
        stop: Callable[[Request], None] | None = None,
    ) -> None:
        self._verbs = {verb.name: verb for verb in verbs}
        self.busy = _refusal(busy, f"the {server} is busy; try again later")
        self._stop = stop
        self._lock = threading.Lock()
        self._count, self._bytes = 0, 0
        self._of_verb: Counter[str] = Counter()
        self._of_sender: Counter[bytes] = Counter()

    def admit(self, key: str, size: int, attachment: bytes) -> bytes:
        """Count a request that is within the limits and return nothing, or return its refusal."""
        name, sender = verb_of(key), _sender(attachment)
        verb = self._verbs.get(name, _UNKNOWN)
        if size > verb.limits.size:
            reason = f"a request for {name[:50]!r} has {size} bytes; expected at most {verb.limits.size}"
            return _refusal(Result.OPERATION_FAILED, reason)
        with self._lock:
            if verb is not EMERGENCY_STOP and self._is_busy(verb, size, sender):
                return self.busy
            self._add(verb, size, sender, 1)
        return b""

    def _is_busy(self, verb: Verb[Any, Any], size: int, sender: bytes) -> bool:
        return (
            self._count >= MOST
            or (self._bytes > 0 and self._bytes + size > MOST_BYTES)
            or self._of_verb[verb.name] >= verb.max_pending
            or (bool(sender) and self._of_sender[sender] >= MOST_OF_ONE)
        )

    def _add(self, verb: Verb[Any, Any], size: int, sender: bytes, by: int) -> None:
        self._count += by
        self._bytes += by * size
        self._of_verb[verb.name] += by
        if sender:
            self._of_sender[sender] += by
            if not self._of_sender[sender]:  # each run has a new name
                del self._of_sender[sender]

    def end(self, key: str, size: int, attachment: bytes) -> None:
        """Uncount an accepted request, after its reply."""
        with self._lock:
            self._add(self._verbs.get(verb_of(key), _UNKNOWN), size, _sender(attachment), -1)

    def divert(self, request: Request) -> bool:
        """Pass an emergency stop to its handler; returns False for all other requests."""
        if self._stop is None or verb_of(request.key) != EMERGENCY_STOP.name:
            return False
        self._stop(request)
        return True


def _sender(attachment: bytes) -> bytes:
    """Return the name of a client; empty beside a signature, which may be copied."""
    return b"" if has_signature(attachment) else attachment


def _refusal(code: int, message: str) -> bytes:
    return encode(Refusal(code=code, message=message))
