"""Lets requests in, or not: who asks is found out, held to their role, and written down.

Without keys everybody who reaches the executor may ask for everything; that is so only on its own machine.
"""

from __future__ import annotations

import hashlib
import logging
from typing import TYPE_CHECKING, Any, Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.sight import LOOK
from seoro.bridges.serving.answering import decoded
from seoro.bridges.session import Request
from seoro.bridges.wire import Message, Result, encode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.limits import Policy
from seoro.executor.rates import Rates
from seoro.executor.serving import Server
from seoro.keys.roles import READING, STOPPING, executor_verbs, least_role

if TYPE_CHECKING:
    from seoro.executor.lock import Lock
    from seoro.keys.certificates import Identity

REFUSALS: Final = (1.0, 20.0)  # a second and at once, that are written down for each caller
_UNSAID: Final = READING | {"missing_blobs", "put_blob"}  # of which only refusals are written down
_SUBMITTING: Final = frozenset({wire.SUBMIT.name, wire.DRY_RUN.name})
_VERBS: Final = {verb.name: verb for verb in wire.EXECUTOR_VERBS}

log = logging.getLogger(__name__)


class Gate:
    """Carries out what is asked for by those who may.

    Args:
        server: Carries out.
        policy: What each role may.
        lock: Its keys; None if it has none.
    """

    def __init__(self, server: Server, policy: Policy, lock: Lock | None) -> None:
        self._server = server
        self._policy = policy
        self._lock = lock
        self._rates = Rates()
        self._refusals = Rates()

    async def carry_out(self, request: Request, verb: str, payload: bytes) -> Message:
        """Carry out a verb.

        Raises:
            RequestRefused: It cannot be carried out, or not for who asks.
        """
        if self._lock is None:
            return await self._server.carry_out(verb, _stamped(verb, payload, None), request.reply_part)
        if verb == wire.CHALLENGE.name:
            return self._lock.prove(decoded(wire.CHALLENGE, payload))
        who: Identity | None = None
        try:
            who = self._lock.admit(request)
            self._check(who, verb)
            self._note_taken(who, verb, payload)
            if verb == wire.REVOKE.name:
                return self._lock.revoke(decoded(wire.REVOKE, payload))
            return await self._server.carry_out(verb, _stamped(verb, payload, who), request.reply_part)
        except RequestRefused as refused:
            self._note_refused(who, verb, payload, refused)
            raise

    def _check(self, who: Identity, verb: str) -> None:
        if verb not in executor_verbs(who.role):
            raise RequestRefused(
                wire.DENIED, f"{who} may not ask for `{verb}`, which is for one who is {least_role(verb).value}"
            )
        rate, burst = self._policy.of(who.role).rate
        if not self._rates.take(who.name, rate, burst) and verb not in STOPPING:
            raise RequestRefused(wire.UNAVAILABLE, f"{who} asks for more than {rate:g} things a second")

    def _note_taken(self, who: Identity, verb: str, payload: bytes) -> None:
        """Write down what is about to be done; what cannot be written down is not done, but for stopping."""
        if verb in _UNSAID:
            return
        try:
            self._note(who, verb, payload, "taken")
        except OSError as error:
            if verb not in STOPPING:
                raise RequestRefused(
                    Result.OPERATION_FAILED,
                    f"the executor cannot write into its audit log: {error.strerror or error}",
                ) from error
            log.exception("cannot write into the audit log")

    def _note_refused(self, who: Identity | None, verb: str, payload: bytes, refused: RequestRefused) -> None:
        if refused.code in (wire.UNAVAILABLE, wire.STALE):
            return
        if not self._refusals.take("" if who is None else who.name, *REFUSALS):
            return
        try:
            self._note(who, verb, payload, "refused", refused.message)
        except OSError:
            log.exception("cannot write into the audit log")

    def _note(self, who: Identity | None, verb: str, payload: bytes, outcome: str, reason: str = "") -> None:
        assert self._lock is not None
        entry: dict[str, Any] = {
            "what": verb,
            "by": None if who is None else who.name,
            "role": None if who is None else who.role.value,
            "outcome": outcome,
            "request": hashlib.sha256(payload).hexdigest(),
        }
        if reason:
            entry["reason"] = reason
        if run := _run_of(verb, payload):
            entry["run"] = run
        self._lock.audit.write(**entry)


def _stamped(verb: str, payload: bytes, who: Identity | None) -> bytes:
    """A request with whose it really is, of those that say it."""
    role = "" if who is None else who.role.value
    if verb == LOOK.name:
        return encode(decoded(LOOK, payload).model_copy(update={"role": role}))
    if verb not in _SUBMITTING:
        return payload
    submission = decoded(_VERBS[verb], payload)
    by = {"role": role} if who is None else {"by": who.name, "role": role}
    return encode(submission.model_copy(update=by))


def _run_of(verb: str, payload: bytes) -> str:
    """The run that a request is about, if it is about one."""
    known = _VERBS.get(verb)
    if known is None or "run" not in known.request.model_fields:
        return ""
    try:
        return str(decoded(known, payload).run)
    except RequestRefused:
        return ""
