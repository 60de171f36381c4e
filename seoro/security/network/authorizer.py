"""Authorizer of a node: with keys, it accepts signed requests, and authenticated ones of holders of robots."""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from seoro.bridges import wire
from seoro.bridges.session import Request
from seoro.bridges.wire.authentication import CHALLENGE, DENIED, Proof, has_signature
from seoro.bridges.wire.holds import TAKE_ROBOTS, Holder, HoldRobots, decode_sender
from seoro.bridges.wire.keys import public_holder_name, verb_of
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.refusal import RequestRefused, read_request
from seoro.bridges.wire.results import Result
from seoro.errors import UsageError
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.roles import MOVING
from seoro.security.network.audit_trail import AuditedRequest, record_request
from seoro.security.network.listener import Listener

if TYPE_CHECKING:
    from seoro.security.network.node_identity import NodeIdentity
    from seoro.security.signing.answers import AnswerSigner
    from seoro.security.signing.replay_window import HolderKey

CALLED: Final = "node"
_UNKNOWN: Final = Verb("unknown", Empty, Empty)
KeyOf: TypeAlias = "Callable[[str], HolderKey | None]"


class NodeAuthorizer:
    """Admits or rejects requests; from any thread.

    Args:
        identity: Identity of the node; None without keys, where every client may send every request.
    """

    def __init__(self, identity: NodeIdentity | None = None) -> None:
        self.identity = identity

    @property
    def attestor(self) -> AnswerSigner | None:
        """Authenticates answers; None without keys."""
        return None if self.identity is None else self.identity.answers

    def authenticate(self, request: Request, key_of: KeyOf) -> str:
        """Return the name of the client that has sent a request, if it holds robots; else an empty name.

        Args:
            request: The request.
            key_of: Returns the key of a holder of robots by its name.

        Raises:
            RequestRefused: Another client has sent the request, or it was sent before.
        """
        verb, sender = verb_of(request.key), _sender(request)
        if self.identity is None:
            return sender
        holder = key_of(sender) if sender and not _verb(verb).is_audited else None
        if holder is None:
            return ""
        try:
            if request.envelope is None:
                raise InvalidKeys("its code is invalid or missing")
            request.envelope.check(holder, request.payload)
        except InvalidKeys as error:
            refused = RequestRefused(
                DENIED,
                f"the request `{verb}` of '{public_holder_name(sender)}' is not authentic: {error}; expected a "
                "request by the client that holds the robots: check what else sends over the same routers",
            )
            self.identity.audit_trail.record_refusal(AuditedRequest(None, verb, request.payload), refused.message)
            raise refused from None
        return sender

    def check_holder(self, verb: Verb[Any, Any], sender: str, asked: Message) -> None:
        """Check that a client takes robots with a public key, and holds or releases its own robots only.

        Args:
            verb: Verb of the request.
            sender: Client that has sent the request, as `authenticate` returns it.
            asked: The request.

        Raises:
            RequestRefused: The public key is missing, or the robots are those of another client.
        """
        if self.identity is None:
            return
        if isinstance(asked, Holder) and verb is TAKE_ROBOTS and not asked.exchange:
            raise RequestRefused(
                DENIED, f"missing public key in the request `{verb.name}`: update seoro at the client"
            )
        if verb.names_holder and isinstance(asked, Holder | HoldRobots) and asked.holder != sender:
            holder = public_holder_name(asked.holder)
            why = f"the request `{verb.name}` is about '{holder}', but another client sent it"
            self.identity.audit_trail.record_refusal(AuditedRequest(None, verb.name, b""), why)
            raise RequestRefused(DENIED, why)

    @contextmanager
    def admitted(self, request: Request, key_of: KeyOf) -> Iterator[str]:
        """Admit a request and record its outcome; yields the name of the client that has sent it.

        Args:
            request: The request.
            key_of: Returns the key of a holder of robots by its name.

        Raises:
            RequestRefused: The sender may not send that request.
        """
        verb, sender = _verb(verb_of(request.key)), self.authenticate(request, key_of)
        if self.identity is None or sender or verb.is_public:
            yield sender or _sender(request)  # unauthenticated clients may send open requests
            return
        asked = AuditedRequest(None, verb_of(request.key), request.payload)
        audit_trail = self.identity.audit_trail
        with audit_trail.recorded_refusals(asked):
            if _sender(request) and not verb.is_audited:
                raise RequestRefused(DENIED, "the sender no longer holds robots here")
            asked.who = who = self.identity.authenticate(request)
            if who.role not in MOVING:
                raise RequestRefused(DENIED, f"{who} may not send `{asked.verb}` (required role: operator)")
            number = record_request(audit_trail, asked, CALLED) if verb.is_audited else None
        with audit_trail.recorded_outcome(asked, number) if verb.is_audited else nullcontext():
            yield ""

    def prove(self, payload: bytes) -> Proof:
        """Answer a challenge.

        Raises:
            RequestRefused: The node has no keys, or the challenge is invalid.
        """
        if self.identity is None:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "this node has no keys")
        return self.identity.prove(read_request(CHALLENGE, payload))


def _verb(name: str) -> Verb[Any, Any]:
    """Return a verb by name; unknown ones require a signature."""
    return wire.NODE_VERBS.get(name, _UNKNOWN)


def _sender(request: Request) -> str:
    """Return the unverified name of the client in the attachment; empty for a signature."""
    return "" if has_signature(request.attachment) else decode_sender(request.attachment)


@contextmanager
def open_authorizer(listener: Listener, log: Path | None) -> Iterator[NodeAuthorizer]:
    """Open the authorizer of a node while a block lasts.

    Args:
        listener: Listener of the node, with its keys.
        log: File of the audit log; required with keys.

    Raises:
        UsageError: The log cannot be written.
    """
    if listener.keys is None or listener.revoked is None:
        yield NodeAuthorizer()
        return
    from seoro.security.network.audit_trail import AuditTrail  # noqa: PLC0415 - only where there are keys
    from seoro.security.network.node_identity import NodeIdentity  # noqa: PLC0415 - only where there are keys
    from seoro.security.signing.audit_log import AuditLog  # noqa: PLC0415 - the same

    if log is None:
        raise UsageError("missing path of the audit log of a node with keys", help="start it by `seoro sim`")
    with ExitStack() as stack:
        try:
            log.parent.mkdir(parents=True, exist_ok=True)
            held = stack.enter_context(log.with_suffix(".lock").open("w"))
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            audit = AuditLog(log, listener.keys)
        except BlockingIOError as error:
            raise UsageError(f"another node writes {log}", help="give each node its own name") from error
        except OSError as error:
            raise UsageError(f"cannot write the audit log {log}: {error.strerror}") from error
        stack.callback(audit.close)
        yield NodeAuthorizer(NodeIdentity(listener.keys, listener.revoked, AuditTrail(audit)))
