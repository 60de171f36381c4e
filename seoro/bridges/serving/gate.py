"""Whom a node answers: with keys, those who seal what they ask for, and those who hold robots there."""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bridges.door import Door
from seoro.bridges.ledger import Asked, take
from seoro.bridges.session import Attestor, Request
from seoro.bridges.wire.holding import sender_of
from seoro.bridges.wire.message import WireError
from seoro.bridges.wire.proving import CHALLENGE, DENIED, STALE, Proof, has_seal, is_open, is_sealed
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import Result
from seoro.errors import InvalidUse
from seoro.keys.roles import MOVING

if TYPE_CHECKING:
    from seoro.bridges.lock import Lock
    from seoro.keys.certificates import Identity

CALLED: Final = "node"


class NodeGate:
    """Lets requests in, or not; from any thread.

    Args:
        lock: The keys of the node; None if it has none, and everybody who reaches it may ask for everything.
    """

    def __init__(self, lock: Lock | None = None) -> None:
        self._lock = lock

    @property
    def lock(self) -> Lock | None:
        """The keys of the node; None if it has none."""
        return self._lock

    @property
    def attestor(self) -> Attestor | None:
        """Makes the answers of a node with keys authentic."""
        return None if self._lock is None else self._lock.answers

    @contextmanager
    def admitted(self, request: Request, holds: Callable[[str], bool]) -> Iterator[str]:
        """Let a request in, and write down what came of it; gives the client that has sent it.

        Args:
            request: The request.
            holds: Whether there is a client of a name that holds robots.

        Raises:
            RequestRefused: Whoever has sent it may not ask for that.
        """
        verb = request.key.rsplit("/", 1)[-1]
        sender = "" if has_seal(request.attachment) else sender_of(request.attachment)
        if self._lock is None or is_open(verb) or (not is_sealed(verb) and sender and holds(sender)):
            yield sender
            return
        asked = Asked(None, verb, request.payload)
        try:
            if sender and not is_sealed(verb):
                raise RequestRefused(DENIED, "whoever asks for that holds no robots here any more")
            asked = replace(asked, who=(who := self._lock.admit(request)))
            _check(who, verb)
            number = take(self._lock.ledger, asked, CALLED) if is_sealed(verb) else None
        except RequestRefused as refused:
            if refused.code != STALE:
                self._lock.ledger.refuse(asked, refused.message)
            raise
        outcome, reason = "broken off", ""
        try:
            yield ""
            outcome = "done"
        except RequestRefused as refused:
            outcome, reason = "refused", refused.message
            raise
        finally:
            if is_sealed(verb):
                self._lock.ledger.conclude(asked, number, outcome, reason)

    def prove(self, payload: bytes) -> Proof:
        """Answer a challenge.

        Raises:
            RequestRefused: The node has no keys, or it is none.
        """
        if self._lock is None:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "this node has no keys")
        try:
            return self._lock.prove(CHALLENGE.read(payload))
        except WireError as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


def _check(who: Identity, verb: str) -> None:
    if who.role not in MOVING:
        raise RequestRefused(DENIED, f"{who} may not ask for `{verb}`, which is for one who is operator")


@contextmanager
def opened_gate(door: Door, log: Path | None) -> Iterator[NodeGate]:
    """The gate of a node for as long as a block lasts.

    Args:
        door: Where the node is reached, with its keys.
        log: File of the log of a node with keys.

    Raises:
        InvalidUse: The log cannot be written.
    """
    if door.keys is None or door.revoked is None:
        yield NodeGate()
        return
    from seoro.bridges.ledger import Ledger  # noqa: PLC0415 - only where there are keys
    from seoro.bridges.lock import Lock  # noqa: PLC0415 - only where there are keys
    from seoro.keys.audit import Audit  # noqa: PLC0415 - the same

    if log is None:
        raise InvalidUse("it is not said where the log of a node with keys is", help="`seoro sim` says so")
    with ExitStack() as stack:
        try:
            log.parent.mkdir(parents=True, exist_ok=True)
            held = stack.enter_context(log.with_suffix(".lock").open("w"))
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            audit = Audit(log, door.keys)
        except BlockingIOError as error:
            raise InvalidUse(f"another node writes {log}", help="give each node a name of its own") from error
        except OSError as error:
            raise InvalidUse(f"cannot write the log {log}: {error.strerror}") from error
        stack.callback(audit.close)
        yield NodeGate(Lock(door.keys, door.revoked, Ledger(audit)))
