"""Audit trail: each request is written into the audit log before it is carried out, and its outcome after that.

Both lines are needed: if the process dies in between, the request without an outcome remains in the log. Each run
gets a line of its own when it is over.
"""

from __future__ import annotations

import hashlib
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from seoro.bridges.wire.authentication import STALE, UNAVAILABLE
from seoro.bridges.wire.lab import EMERGENCY_STOP
from seoro.bridges.wire.refusal import RequestRefused, read_request
from seoro.bridges.wire.results import Result
from seoro.deferred import dataclass
from seoro.security.network.rate_limiter import RateLimiter

if TYPE_CHECKING:
    from seoro.bridges.executor.messages import RunInfo
    from seoro.bridges.wire.message import Verb
    from seoro.security.keys.certificates import Identity
    from seoro.security.signing.audit_log import AuditLog

REFUSALS: Final = (1.0, 20.0)  # refusals recorded for each caller: rate [1/s] and burst
RUN: Final = "run"  # subject of a line about the end of a run
LONGEST: Final = 1000  # [characters] of a reason
MOST_NAMES: Final = 50  # robots in a line, which has to fit into the reserved disk space
LONGEST_NAME: Final = 100  # [characters] of one of them

log = logging.getLogger(__name__)


@dataclass
class AuditedRequest:
    """A request for the audit log: its sender (None if unknown), verb and payload."""

    who: Identity | None
    verb: str
    payload: bytes

    @property
    def is_stop(self) -> bool:
        """Whether it stops something, so that a failure of the log must not prevent it."""
        known = _executor_verb(self.verb)
        return known is not None and known.is_stop


class AuditTrail:
    """Records the requests to an executor or a node; from any thread.

    Args:
        audit: Log that it writes.
    """

    def __init__(self, audit: AuditLog) -> None:
        self._audit = audit
        self._refusals = RateLimiter()
        self._pending: list[dict[str, Any]] = []  # outcomes that could not be written yet
        self._lock = threading.Lock()

    def record(self, asked: AuditedRequest) -> int:
        """Record a request before it is carried out; returns the number of its line.

        Raises:
            OSError: The log cannot be written.
        """
        entry = _entry(asked)
        with self._lock:
            self._write_pending()
            return self._audit.write(**entry, outcome="taken")

    def sync(self) -> None:
        """Force all lines to the disk; blocks. A failure is logged: then only a loss of power loses lines."""
        try:
            self._audit.sync()
        except OSError:
            log.exception("cannot force the audit log to the disk")

    def record_outcome(self, asked: AuditedRequest, number: int | None, outcome: str, reason: str = "") -> None:
        """Record the outcome of a request; if the log cannot be written, before the next line.

        Args:
            asked: The request.
            number: Number of its line; None if that could not be written.
            outcome: The outcome, in a word or two.
            reason: Reason of the outcome.
        """
        of = {} if number is None else {"of": number}
        entry = {**_entry(asked), "outcome": outcome, **of, **_reason(reason)}
        if asked.verb != EMERGENCY_STOP.name or not self._write_urgently(entry):
            self._write_or_keep(**entry)

    def _write_urgently(self, entry: dict[str, Any]) -> bool:
        """Write a line into the reserved disk space; False if that fails."""
        with self._lock:
            try:
                self._audit.write(is_urgent=True, **entry)
            except OSError:
                log.exception("cannot write an emergency stop into the audit log yet")
                return False
        return True

    def record_refusal(self, asked: AuditedRequest, reason: str) -> None:
        """Record a request that was rejected, up to a rate for each caller."""
        with self._lock:
            is_recorded = self._refusals.acquire("" if asked.who is None else asked.who.name, *REFUSALS)
        if is_recorded:
            self._write_or_keep(**_entry(asked), outcome="refused", **_reason(reason))

    @contextmanager
    def recorded_refusals(self, asked: AuditedRequest) -> Iterator[None]:
        """Record a refusal of a request in the block, unless the client is asked to retry."""
        try:
            yield
        except RequestRefused as refused:
            if refused.code not in (UNAVAILABLE, STALE):
                self.record_refusal(asked, refused.message)
            raise

    @contextmanager
    def recorded_outcome(self, asked: AuditedRequest, number: int | None) -> Iterator[None]:
        """Record the outcome of a request at the end of the block; `number` is that of its line."""
        outcome, reason = "done", ""
        try:
            yield
        except RequestRefused as refused:
            outcome, reason = "refused", refused.message
            raise
        except BaseException as error:  # a fault, or the server ends
            outcome, reason = "broken off", f"{type(error).__name__}: {error}"
            raise
        finally:
            self.record_outcome(asked, number, outcome, reason)

    def record_run(self, info: RunInfo, role: str) -> None:
        """Record the end of a run; if the log cannot be written, before the next line."""
        trace = {"trace": info.trace} if info.trace else {}
        entry = {"run": info.run, "outcome": info.state.value, **trace, **_reason(info.reason)}
        self._write_or_keep(what=RUN, by=info.by, role=role, **entry)

    def _write_or_keep(self, **entry: Any) -> None:
        with self._lock:
            self._pending.append(entry)
            try:
                self._write_pending()
            except OSError:
                log.exception("cannot write into the audit log")

    def _write_pending(self) -> None:
        while self._pending:
            self._audit.write(**self._pending[0])
            del self._pending[0]


def record_request(audit_trail: AuditTrail, asked: AuditedRequest, called: str) -> int | None:
    """Record a request before it is carried out. Requests that stop something need no record.

    Args:
        audit_trail: The audit trail.
        asked: The request.
        called: Name of the server in messages, such as `node`.

    Returns:
        The number of its line; None if a request to stop could not be recorded.

    Raises:
        RequestRefused: The log cannot be written.
    """
    try:
        return audit_trail.record(asked)
    except OSError as error:
        if not asked.is_stop:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the {called} cannot write into its audit log: {error.strerror or error}",
            ) from error
        log.exception("cannot write into the audit log")
        return None


def _entry(asked: AuditedRequest) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "what": asked.verb,
        "by": None if asked.who is None else asked.who.name,
        "role": None if asked.who is None else asked.who.role.value,
        "request": hashlib.sha256(asked.payload).hexdigest(),
    }
    return {**entry, **_subject(asked.verb, asked.payload)}


def _executor_verb(name: str) -> Verb[Any, Any] | None:
    # Nodes without keys have no use for the messages of executors, which take long to load.
    from seoro.bridges.executor.verbs import EXECUTOR_VERBS  # noqa: PLC0415

    return EXECUTOR_VERBS.get(name)


def _reason(text: str) -> dict[str, str]:
    return {"reason": text[:LONGEST]} if text else {}


def _subject(verb: str, payload: bytes) -> dict[str, Any]:
    """Return the run of a request, or the robots of an emergency stop of some robots."""
    known = _executor_verb(verb)
    if known is None or not known.request.model_fields.keys() & {"run", "robots"}:
        return {}
    try:
        request = read_request(known, payload)
    except RequestRefused:
        return {}
    if run := getattr(request, "run", ""):
        return {"run": str(run)}
    robots = [robot[:LONGEST_NAME] for robot in getattr(request, "robots", ())]
    more = [f"and {len(robots) - MOST_NAMES} more"] if len(robots) > MOST_NAMES else []
    return {"robots": robots[:MOST_NAMES] + more} if robots else {}
