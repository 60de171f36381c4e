"""What is written into the audit log: what was asked, before it is done, and what came of it, after.

Both are needed: whatever happens in between, the first line stands, and without the second one it is not known
what came of it, as when the executor died. Runs have a line of their own when they are over.
"""

from __future__ import annotations

import hashlib
import logging
import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo
from seoro.bridges.serving.answering import decoded
from seoro.bridges.wire.lab import EMERGENCY_STOP, RELEASE_STOP
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import Result
from seoro.keys.roles import STOPPING
from seoro.rates import Rates

if TYPE_CHECKING:
    from seoro.keys.audit import Audit
    from seoro.keys.certificates import Identity

REFUSALS: Final = (1.0, 20.0)  # a second and at once, that are written down for each caller
RUN: Final = "run"  # what a line is about that is the end of one
LONGEST: Final = 1000  # [characters] of a reason
MOST_NAMES: Final = 50  # of robots in a line, which has to fit into the room that is reserved
LONGEST_NAME: Final = 100  # [characters] of one of them
_VERBS: Final = {verb.name: verb for verb in (*wire.EXECUTOR_VERBS, EMERGENCY_STOP, RELEASE_STOP)}

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Asked:
    """What is asked: by whom, None if that is not known, which verb, and the request."""

    who: Identity | None
    verb: str
    payload: bytes


class Ledger:
    """Writes down what is asked of an executor or a node; from any thread.

    Args:
        audit: Where.
    """

    def __init__(self, audit: Audit) -> None:
        self._audit = audit
        self._refusals = Rates()
        self._owed: list[dict[str, Any]] = []  # what came of something, while it cannot be written
        self._lock = threading.Lock()

    def take(self, asked: Asked) -> int:
        """Write down what is about to be done; returns the number of the line.

        Raises:
            OSError: It cannot be written.
        """
        entry = _entry(asked)
        with self._lock:
            self._pay()
            return self._audit.write(**entry, outcome="taken")

    def sync(self) -> None:
        """Force all lines to the disk; blocks. A failure is logged: then, only a loss of power loses them."""
        try:
            self._audit.sync()
        except OSError:
            log.exception("cannot force the audit log to the disk")

    def conclude(self, asked: Asked, number: int | None, outcome: str, reason: str = "") -> None:
        """Write down what came of what was taken; if it cannot be written, then before the next line that can.

        Args:
            asked: What was taken.
            number: Of the line that says so; None if that could not be written.
            outcome: What came of it, in a word or two.
            reason: Why, in words.
        """
        of = {} if number is None else {"of": number}
        entry = {**_entry(asked), "outcome": outcome, **of, **_reason(reason)}
        if asked.verb != EMERGENCY_STOP.name or not self._write_urgently(entry):
            self._owe(**entry)

    def _write_urgently(self, entry: dict[str, Any]) -> bool:
        """Write a line into the room that is reserved for it; returns whether that was possible."""
        with self._lock:
            try:
                self._audit.write(is_urgent=True, **entry)
            except OSError:
                log.exception("cannot write an emergency stop into the audit log yet")
                return False
        return True

    def refuse(self, asked: Asked, reason: str) -> None:
        """Write down what was refused before it was taken, unless that happens all the time."""
        with self._lock:
            may = self._refusals.take("" if asked.who is None else asked.who.name, *REFUSALS)
        if may:
            self._owe(**_entry(asked), outcome="refused", **_reason(reason))

    def end(self, info: RunInfo, role: str) -> None:
        """Write down what has become of a run; if it cannot be written, then before the next line that can."""
        trace = {"trace": info.trace} if info.trace else {}
        entry = {"run": info.run, "outcome": info.state.value, **trace, **_reason(info.reason)}
        self._owe(what=RUN, by=info.by, role=role, **entry)

    def _owe(self, **entry: Any) -> None:
        with self._lock:
            self._owed.append(entry)
            try:
                self._pay()
            except OSError:
                log.exception("cannot write into the audit log")

    def _pay(self) -> None:
        while self._owed:
            self._audit.write(**self._owed[0])
            del self._owed[0]


def take(ledger: Ledger, asked: Asked, called: str) -> int | None:
    """Write down what is about to be done; what cannot be written down is not done, but for stopping.

    Args:
        ledger: Where.
        asked: What is about to be done.
        called: What messages call whoever does it.

    Returns:
        The number of the line; None if there is none.

    Raises:
        RequestRefused: It cannot be written down.
    """
    try:
        return ledger.take(asked)
    except OSError as error:
        if asked.verb not in STOPPING:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the {called} cannot write into its audit log: {error.strerror or error}",
            ) from error
        log.exception("cannot write into the audit log")
        return None


def _entry(asked: Asked) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "what": asked.verb,
        "by": None if asked.who is None else asked.who.name,
        "role": None if asked.who is None else asked.who.role.value,
        "request": hashlib.sha256(asked.payload).hexdigest(),
    }
    return {**entry, **_subject(asked.verb, asked.payload)}


def _reason(text: str) -> dict[str, str]:
    return {"reason": text[:LONGEST]} if text else {}


def _subject(verb: str, payload: bytes) -> dict[str, Any]:
    """The run that a request is about, or the robots of an emergency stop that is not of everything."""
    known = _VERBS.get(verb)
    if known is None or not known.request.model_fields.keys() & {"run", "robots"}:
        return {}
    try:
        request = decoded(known, payload)
    except RequestRefused:
        return {}
    if run := getattr(request, "run", ""):
        return {"run": str(run)}
    robots = [robot[:LONGEST_NAME] for robot in getattr(request, "robots", ())]
    more = [f"and {len(robots) - MOST_NAMES} more"] if len(robots) > MOST_NAMES else []
    return {"robots": robots[:MOST_NAMES] + more} if robots else {}
