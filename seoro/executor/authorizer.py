"""Authorizer of an executor: authenticates requests, checks the role of the sender and records them.

Without keys every client may send every request; such executors are reachable on their own machine only.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import anyio.to_thread

from seoro import __version__
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.verbs import EXECUTOR_VERBS
from seoro.bridges.session import Request
from seoro.bridges.wire import Message, Result, Verb
from seoro.bridges.wire.authentication import CHALLENGE, DENIED
from seoro.bridges.wire.refusal import RequestRefused, name_list, read_request
from seoro.executor.handlers import RequestHandlers
from seoro.executor.limits import Policy
from seoro.security.keys.errors import InvalidKeys
from seoro.security.network.audit_trail import AuditedRequest, record_request
from seoro.security.network.rate_limiter import RateLimiter

if TYPE_CHECKING:
    from seoro.security.keys.certificates import Identity
    from seoro.security.network.node_identity import NodeIdentity

MAX_FOLLOWING: Final = 200  # waiting requests for records of one identity


class Authorizer:
    """Carries out the requests that their senders may make.

    Args:
        server: Handlers of requests.
        policy: Limits of each role.
        identity: Identity of the executor; None without keys.
    """

    def __init__(self, server: RequestHandlers, policy: Policy, identity: NodeIdentity | None) -> None:
        self._server = server
        self._policy = policy
        self._identity = identity
        self._rates = RateLimiter()
        self._following: Counter[str] = Counter()

    async def carry_out(self, request: Request, name: str, payload: bytes) -> Message | None:
        """Carry out a request.

        Args:
            request: The request.
            name: Name of its verb.
            payload: Its payload.

        Raises:
            RequestRefused: The request failed, or the sender may not send it.
        """
        if self._identity is None:
            return await self._handle(request, _find(name), payload, None)
        if name == CHALLENGE.name:
            return self._identity.prove(read_request(CHALLENGE, payload))
        asked, audit_trail = AuditedRequest(None, name, payload), self._identity.audit_trail
        with audit_trail.recorded_refusals(asked):
            asked.who = who = self._identity.authenticate(request)
            verb = _find(name)
            self._check(who, verb)
            number = record_request(audit_trail, asked, "executor") if verb.is_audited else None
            if verb.is_audited and not verb.is_stop:  # requests to stop do not wait for the disk
                await anyio.to_thread.run_sync(audit_trail.sync)
        recorded = (
            audit_trail.recorded_outcome(asked, number)
            if verb.is_audited
            else audit_trail.recorded_refusals(asked)
        )
        with recorded, self._counted(who, verb):
            reply = await self._handle(request, verb, payload, who)
        if verb.is_stop:
            await anyio.to_thread.run_sync(audit_trail.sync)
        return reply

    @contextmanager
    def _counted(self, who: Identity, verb: Verb[Any, Any]) -> Iterator[None]:
        """Count a request that may wait, while the block lasts.

        Raises:
            RequestRefused: Too many requests of this identity wait.
        """
        if not verb.waits:
            yield
            return
        if self._following[who.name] >= MAX_FOLLOWING:
            why = f"{who} already follows {MAX_FOLLOWING} runs, which is the limit: try again later"
            raise RequestRefused(wire.UNAVAILABLE, why)
        self._following[who.name] += 1
        try:
            yield
        finally:
            self._following[who.name] -= 1
            if not self._following[who.name]:
                del self._following[who.name]

    async def _handle(
        self, request: Request, verb: Verb[Any, Any], payload: bytes, who: Identity | None
    ) -> Message | None:
        message = _stamped(read_request(verb, payload), who)
        if self._identity is not None and isinstance(message, wire.Revoke):
            _revoke(self._identity, message)
            return None
        return await self._server.carry_out(verb, message, request.reply_part)

    def _check(self, who: Identity, verb: Verb[Any, Any]) -> None:
        if not who.role.includes(verb.role):
            raise RequestRefused(DENIED, f"{who} may not send `{verb.name}` (required role: {verb.role.value})")
        rate, burst = self._policy.of(who.role).rate
        if not self._rates.acquire(who.name, rate, burst) and not verb.is_stop:
            raise RequestRefused(wire.UNAVAILABLE, f"{who} sends more than {rate:g} requests per second")


def _find(name: str) -> Verb[Any, Any]:
    if name not in EXECUTOR_VERBS:
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED,
            f"unknown request {name!r} to an executor of seoro {__version__} "
            f"(requests: {name_list(EXECUTOR_VERBS)})",
        )
    return EXECUTOR_VERBS[name]


def _revoke(identity: NodeIdentity, request: wire.Revoke) -> None:
    """Install a newer list of revoked keys.

    Raises:
        RequestRefused: The list is invalid or outdated.
    """
    try:
        identity.revoked.install(request.data)
    except InvalidKeys as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


def _stamped(request: Message, who: Identity | None) -> Message:
    """Set the verified sender and role in a request with such fields."""
    if "role" not in type(request).model_fields:
        return request
    known = {"role": ""} if who is None else {"role": who.role.value, "by": who.name}
    return request.model_copy(
        update={name: text for name, text in known.items() if name in type(request).model_fields}
    )
