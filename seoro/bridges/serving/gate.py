"""Authorizer of a node: with keys, it accepts sealed requests, and authentic ones of clients that hold robots."""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from seoro.bridges.door import Door
from seoro.bridges.ledger import Asked, take
from seoro.bridges.session import Attestor, Request
from seoro.bridges.wire.holding import (
    HOLD_ROBOTS,
    RELEASE_ROBOTS,
    TAKE_ROBOTS,
    Holder,
    HoldRobots,
    sender_of,
)
from seoro.bridges.wire.keys import shown_holder, verb_of
from seoro.bridges.wire.message import Message, WireError
from seoro.bridges.wire.proving import CHALLENGE, DENIED, STALE, Proof, has_seal, is_open, is_sealed
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import Result
from seoro.errors import InvalidUse
from seoro.keys.errors import InvalidKeys
from seoro.keys.roles import MOVING

if TYPE_CHECKING:
    from seoro.bridges.lock import Lock
    from seoro.keys.certificates import Identity
    from seoro.keys.window import HolderKey

CALLED: Final = "node"
KeyOf: TypeAlias = "Callable[[str], HolderKey | None]"
_OWN: Final = frozenset({HOLD_ROBOTS.name, RELEASE_ROBOTS.name})


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

    def authenticate(self, request: Request, key_of: KeyOf) -> str:
        """Return the name of the client that has sent a request, if it holds robots; else nothing.

        Args:
            request: The request.
            key_of: Returns the key of a client that holds robots, by its name.

        Raises:
            RequestRefused: Another client has sent the request, or it was sent before.
        """
        verb, sender = verb_of(request.key), _sender(request)
        if self._lock is None:
            return sender
        holder = key_of(sender) if sender and not is_sealed(verb) else None
        if holder is None:
            return ""
        try:
            if request.envelope is None:
                raise InvalidKeys("its code is wrong or missing")
            request.envelope.check(holder, request.payload)
        except InvalidKeys as error:
            refused = RequestRefused(
                DENIED,
                f"the request `{verb}` of '{shown_holder(sender)}' is not authentic: {error}; expected a request "
                "by the client that holds the robots: find out what else sends on the routers in between",
            )
            self._lock.ledger.refuse(Asked(None, verb, request.payload), refused.message)
            raise refused from None
        return sender

    def check_holder(self, verb: str, sender: str, asked: Message) -> None:
        """Check that a client takes robots with a key, and holds or releases its own robots only.

        Args:
            verb: Name of the verb.
            sender: Client that has sent the request, as `authenticate` returns it.
            asked: The request.

        Raises:
            RequestRefused: It does not.
        """
        if self._lock is None:
            return
        if isinstance(asked, Holder) and verb == TAKE_ROBOTS.name and not asked.exchange:
            raise RequestRefused(DENIED, f"the request `{verb}` has no public key: update the seoro of the client")
        if verb in _OWN and isinstance(asked, Holder | HoldRobots) and asked.holder != sender:
            why = f"the request `{verb}` is about '{shown_holder(asked.holder)}', which has not sent it"
            self._lock.ledger.refuse(Asked(None, verb, b""), why)
            raise RequestRefused(DENIED, why)

    @contextmanager
    def admitted(self, request: Request, key_of: KeyOf) -> Iterator[str]:
        """Let a request in, and write down what came of it; gives the client that has sent it.

        Args:
            request: The request.
            key_of: Returns the key of a client that holds robots, by its name.

        Raises:
            RequestRefused: Whoever has sent it may not ask for that.
        """
        verb, sender = verb_of(request.key), self.authenticate(request, key_of)
        if self._lock is None or sender or is_open(verb):
            yield sender or _sender(request)  # who is unknown here may ask for what anybody may
            return
        asked = Asked(None, verb, request.payload)
        try:
            if _sender(request) and not is_sealed(verb):
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


def _sender(request: Request) -> str:
    """The name of a client beside a request, which anybody may have put there; empty for a seal."""
    return "" if has_seal(request.attachment) else sender_of(request.attachment)


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
