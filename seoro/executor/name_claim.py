"""Claim of a name: only one executor of a name answers requests.

A liveliness token of the name is only a hint of another executor. Its owner has to answer with a claim: its
running time by a steady clock, with keys in a statement signed together with a nonce. So neither a token, a
recorded answer nor a wrong clock takes the name from an executor. Of two executors with the same name, the one
that has run longer keeps it.

Without keys, claims are not signed: every client of such an executor could stop it anyway.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.executor.messages import MINOR
from seoro.bridges.naming import LIST_TIMEOUT, wait_until_free
from seoro.bridges.session import AsyncSession, SessionError
from seoro.bridges.wire.authentication import CLAIM, Challenge, Claim
from seoro.bridges.wire.keys import NAMESPACE, executor_command, executor_token, executor_tokens_of, token_node
from seoro.bridges.wire.message import WireError, decode, encode
from seoro.concurrency.steady_clock import steady_ns
from seoro.errors import UsageError

if TYPE_CHECKING:
    from seoro.security.network.node_identity import NodeIdentity

CLAIM_TIMEOUT: Final = 2.0  # [s]
RETRY_PERIOD: Final = 5.0  # [s] until the owner of an unproven token is queried again
_KIND: Final = "seoro claim 1"

log = logging.getLogger(__name__)


class NameClaim:
    """Name of an executor, which it loses to an older executor with the same name.

    Args:
        name: The name.
        identity: Identity of the executor; None without keys.
        clock: Steady clock [ns].
    """

    def __init__(
        self, name: str, identity: NodeIdentity | None = None, clock: Callable[[], int] = steady_ns
    ) -> None:
        self._name = name
        self._identity = identity
        self._clock = clock
        self._began = clock()
        self._boot = secrets.token_hex(8) if identity is None else identity.boot
        self.token: Final = executor_token(NAMESPACE, name, f"{MINOR}-{self._boot}")

    def claim(self, challenge: Challenge) -> Claim:
        """Answer the challenge of another executor."""
        age = self._age()
        statement = (_KIND, self._name, challenge.nonce, self._boot, age)
        signature = b"" if self._identity is None else self._identity.sign(*statement)
        return Claim(boot=self._boot, age=age, signature=signature)

    async def wait_until_free(self, session: AsyncSession) -> None:
        """Wait briefly until the name is free; called before the executor serves under it.

        Raises:
            UsageError: Another executor has the name.
        """
        if await wait_until_free(session, self._tokens):
            return
        if await self._claims(session):
            raise self._taken()
        log.warning("%s", self._unproven)

    async def check_first(self, session: AsyncSession) -> None:
        """Check that no older executor has claimed the name at the same time, once the token is declared.

        Raises:
            UsageError: An older executor has the name.
        """
        if not await session.list_tokens(self._tokens, LIST_TIMEOUT) - {self.token}:
            return
        elders, _ = await self._others(session)
        if elders:
            raise self._taken()

    async def wait_for_elder(self, session: AsyncSession) -> None:
        """Wait until an older executor with the same name becomes reachable, if it was unreachable at the
        start."""
        doubtful: set[str] = set()  # tokens without a proven claim
        async with session.tokens(self._tokens) as changes:
            while True:
                with anyio.move_on_after(RETRY_PERIOD if doubtful else None) as waited:
                    token, is_alive = await changes.get()
                    if token == self.token or not is_alive:
                        doubtful.discard(token)
                        continue
                    doubtful.add(token)
                elders, younger = await self._others(session)
                if elders:
                    return
                for each in sorted(doubtful):
                    if _boot(each) in younger:
                        doubtful.discard(each)
                        log.warning("a younger executor '%s' stops", self._name)
                    elif not waited.cancelled_caught:
                        log.warning("%s", self._unproven)

    async def _others(self, session: AsyncSession) -> tuple[frozenset[str], frozenset[str]]:
        """Return the start identifiers of older and younger executors that claim the name."""
        before = self._age()
        claims = await self._claims(session)
        after = self._age()
        elders = {
            claim.boot
            for claim in claims
            # Answers take time: between two that may be equally old, the start identifier decides.
            if claim.age > after or (claim.age >= before and claim.boot < self._boot)
        }
        return frozenset(elders), frozenset(claim.boot for claim in claims) - elders

    async def _claims(self, session: AsyncSession) -> tuple[Claim, ...]:
        """Return the proven claims of other executors to the name."""
        challenge = Challenge(nonce=secrets.token_bytes(16))
        key = executor_command(NAMESPACE, self._name, CLAIM.name)
        try:
            answers = await session.query_others(key, encode(challenge), CLAIM_TIMEOUT)
        except SessionError:  # connection lost: no other executor is reachable
            return ()
        found = (self._proven(challenge, answer) for answer in answers)
        return tuple(claim for claim in found if claim is not None and claim.boot != self._boot)

    def _proven(self, challenge: Challenge, answer: bytes) -> Claim | None:
        try:
            claim = decode(Claim, answer)
        except WireError:
            return None
        if self._identity is None:
            return claim
        statement = (_KIND, self._name, challenge.nonce, claim.boot, claim.age)
        return claim if self._identity.is_own_signature(claim.signature, *statement) else None

    @property
    def lost(self) -> str:
        """Message for an executor that stops because an older one has its name."""
        return f"an older executor '{self._name}' is reachable again and keeps the name"

    @property
    def _tokens(self) -> str:
        return executor_tokens_of(NAMESPACE, self._name)

    @property
    def _unproven(self) -> str:
        reason = "does not answer" if self._identity is None else "does not prove that it has the keys"
        return f"ignoring a liveliness token of the name '{self._name}': its owner {reason}"

    def _age(self) -> int:
        return self._clock() - self._began

    def _taken(self) -> UsageError:
        return UsageError(f"duplicate executor '{self._name}'", help="choose another name with `--name`")


def _boot(token: str) -> str:
    """Return the start identifier in a token."""
    return token_node(token)[1].partition("-")[2]
