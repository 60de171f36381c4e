"""Lets requests in, or not: who asks is found out, held to their role, and written down.

Without keys everybody who reaches the executor may ask for everything; that is so only on its own machine.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import anyio.to_thread

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.sight import LOOK
from seoro.bridges.ledger import Asked, take
from seoro.bridges.serving.answering import decoded
from seoro.bridges.session import Request
from seoro.bridges.wire import Empty, Message, Result, encode
from seoro.bridges.wire.proving import CHALLENGE, DENIED, STALE
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.limits import Policy
from seoro.executor.serving import Server
from seoro.keys.errors import InvalidKeys
from seoro.keys.roles import READING, STOPPING, executor_verbs, least_role
from seoro.rates import Rates

if TYPE_CHECKING:
    from seoro.bridges.lock import Lock
    from seoro.keys.certificates import Identity

_UNSAID: Final = READING | {"missing_blobs", "put_blob"}  # of which only refusals are written down
FOLLOWED_BY_ONE: Final = 200  # requests for records of one identity that wait at the same time
FOLLOWED: Final = 500  # of all
_SUBMITTING: Final = {verb.name: verb for verb in (wire.SUBMIT, wire.DRY_RUN, wire.PUT_BLOB)}


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
        self._following: Counter[str] = Counter()

    async def carry_out(self, request: Request, verb: str, payload: bytes) -> Message:
        """Carry out a verb.

        Raises:
            RequestRefused: It cannot be carried out, or not for who asks.
        """
        if self._lock is None:
            return await self._server.carry_out(verb, _stamped(verb, payload, None), request.reply_part)
        if verb == CHALLENGE.name:
            return self._lock.prove(decoded(CHALLENGE, payload))
        return await self._carry_out_noted(request, Asked(None, verb, payload), self._lock)

    async def _carry_out_noted(self, request: Request, asked: Asked, lock: Lock) -> Message:
        """Carry out a verb for somebody with keys; what is asked and what comes of it stand in the log."""
        ledger, verb = lock.ledger, asked.verb
        try:
            who = lock.admit(request)
            asked = replace(asked, who=who)
            self._check(who, verb)
            number = None if verb in _UNSAID else take(ledger, asked, "executor")
            if verb not in _UNSAID and verb not in STOPPING:  # nothing holds up what stops something
                await anyio.to_thread.run_sync(ledger.sync)
        except RequestRefused as refused:
            if refused.code not in (wire.UNAVAILABLE, STALE):
                ledger.refuse(asked, refused.message)
            raise
        try:
            with self._counted(who, verb):
                answer = await self._carry_out_for(who, request, asked, lock)
        except RequestRefused as refused:
            if verb not in _UNSAID:
                ledger.conclude(asked, number, "refused", refused.message)
            elif refused.code not in (wire.UNAVAILABLE, STALE):
                ledger.refuse(asked, refused.message)
            raise
        except BaseException as error:  # a fault, or the executor ends
            if verb not in _UNSAID:
                ledger.conclude(asked, number, "broken off", f"{type(error).__name__}: {error}")
            raise
        if verb not in _UNSAID:
            ledger.conclude(asked, number, "done")
            if verb in STOPPING:
                await anyio.to_thread.run_sync(ledger.sync)
        return answer

    @contextmanager
    def _counted(self, who: Identity, verb: str) -> Iterator[None]:
        """Count a request that may wait, before it is read.

        Raises:
            RequestRefused: Too many of this identity wait.
        """
        if verb != wire.RECORDS.name:
            yield
            return
        if self._following[who.name] >= FOLLOWED_BY_ONE:
            why = f"{who} follows {FOLLOWED_BY_ONE} runs at once, which is as many as may be: ask again later"
            raise RequestRefused(wire.UNAVAILABLE, why)
        self._following[who.name] += 1
        try:
            yield
        finally:
            self._following[who.name] -= 1
            if not self._following[who.name]:
                del self._following[who.name]

    async def _carry_out_for(self, who: Identity, request: Request, asked: Asked, lock: Lock) -> Message:
        if asked.verb == wire.REVOKE.name:
            return _revoke(lock, decoded(wire.REVOKE, asked.payload))
        said = _stamped(asked.verb, asked.payload, who)
        return await self._server.carry_out(asked.verb, said, request.reply_part)

    def _check(self, who: Identity, verb: str) -> None:
        if verb not in executor_verbs(who.role):
            raise RequestRefused(
                DENIED, f"{who} may not ask for `{verb}`, which is for one who is {least_role(verb).value}"
            )
        rate, burst = self._policy.of(who.role).rate
        if not self._rates.take(who.name, rate, burst) and verb not in STOPPING:
            raise RequestRefused(wire.UNAVAILABLE, f"{who} asks for more than {rate:g} things a second")


def _revoke(lock: Lock, request: wire.Revoke) -> Empty:
    """Have a newer list of those who are revoked.

    Raises:
        RequestRefused: The authority has not signed it, or it is older.
    """
    try:
        lock.revoked.take(request.data)
    except InvalidKeys as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
    return Empty()


def _stamped(verb: str, payload: bytes, who: Identity | None) -> bytes:
    """A request with whose it really is, of those that say it."""
    role = "" if who is None else who.role.value
    if verb == LOOK.name:
        return encode(decoded(LOOK, payload).model_copy(update={"role": role}))
    if verb not in _SUBMITTING:
        return payload
    submission = decoded(_SUBMITTING[verb], payload)
    by = {"role": role} if who is None else {"by": who.name, "role": role}
    return encode(submission.model_copy(update=by))
