"""There is one executor of a name: who asks for it must not reach now one and now another.

A liveliness token of the name only says that there may be another executor. Each token is asked for its claim: an
executor answers how long it has run, by a clock that nobody sets, and with keys signs that with what the asker has
drawn. So no token, no recorded answer and no clock that is wrong takes a name from an executor. Of two that have
the name, the one that has run longer keeps it.

Without keys, claims are not signed: whoever reaches an executor without keys may stop it anyway.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.executor.messages import MINOR
from seoro.bridges.naming import becomes_free, holders
from seoro.bridges.session import AsyncSession, SessionError
from seoro.bridges.wire.keys import NAMESPACE, executor_command, executor_token, executor_tokens_of, token_node
from seoro.bridges.wire.message import WireError, decode, encode
from seoro.bridges.wire.proving import CLAIM, Challenge, Claim
from seoro.errors import InvalidUse
from seoro.steady import steady_ns

if TYPE_CHECKING:
    from seoro.bridges.lock import Lock

ASKING: Final = 2.0  # [s] in which another executor answers for its token
AGAIN: Final = 5.0  # [s] after which a token that nobody has answered for is asked again
_KIND: Final = "seoro claim 1"

log = logging.getLogger(__name__)


class Name:
    """The name of an executor, which it has for as long as no older one claims it.

    Args:
        name: The name.
        lock: The keys of the executor; None if it has none.
        clock: [ns], which nobody sets.
    """

    def __init__(self, name: str, lock: Lock | None = None, clock: Callable[[], int] = steady_ns) -> None:
        self._name = name
        self._lock = lock
        self._clock = clock
        self._began = clock()
        self._boot = secrets.token_hex(8) if lock is None else lock.boot
        self.token: Final = executor_token(NAMESPACE, name, f"{MINOR}-{self._boot}")

    def claim(self, challenge: Challenge) -> Claim:
        """Answer another executor that asks who has the name."""
        age = self._age()
        said = (_KIND, self._name, challenge.nonce, self._boot, age)
        return Claim(boot=self._boot, age=age, signature=b"" if self._lock is None else self._lock.sign(*said))

    async def wait_until_free(self, session: AsyncSession) -> None:
        """Wait a little until nobody has the name; called before anything is served under it.

        Raises:
            InvalidUse: Another executor has it.
        """
        if await becomes_free(session, self._tokens):
            return
        if await self._claims(session):
            raise self._taken()
        log.warning("%s", self._unproven)

    async def check_first(self, session: AsyncSession) -> None:
        """Check that no older executor has taken the name at the same moment, once the token is there.

        Raises:
            InvalidUse: One has.
        """
        if not await holders(session, self._tokens) - {self.token}:
            return
        elders, _ = await self._others(session)
        if elders:
            raise self._taken()

    async def wait_for_elder(self, session: AsyncSession) -> None:
        """Wait until an older executor of the name is reached.

        Two have a name when the second one started while the first could not be reached.
        """
        doubtful: set[str] = set()  # tokens of others that nobody has answered for
        async with session.token_changes(self._tokens) as changes:
            while True:
                with anyio.move_on_after(AGAIN if doubtful else None) as waited:
                    token, is_alive = await changes.take()
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
                        log.warning("another executor '%s', which is younger than this one, stops", self._name)
                    elif not waited.cancelled_caught:
                        log.warning("%s", self._unproven)

    async def _others(self, session: AsyncSession) -> tuple[frozenset[str], frozenset[str]]:
        """Other executors that claim the name: which starts of older and of younger ones there are."""
        before = self._age()
        claims = await self._claims(session)
        after = self._age()
        elders = {
            claim.boot
            for claim in claims
            # Answers take time: of two that may be equally old, the name of their start decides.
            if claim.age > after or (claim.age >= before and claim.boot < self._boot)
        }
        return frozenset(elders), frozenset(claim.boot for claim in claims) - elders

    async def _claims(self, session: AsyncSession) -> tuple[Claim, ...]:
        """The claims of other executors to the name, as far as they are proven."""
        challenge = Challenge(nonce=secrets.token_bytes(16))
        key = executor_command(NAMESPACE, self._name, CLAIM.name)
        try:
            answers = await session.query_others(key, encode(challenge), ASKING)
        except SessionError:  # the connection is lost: nobody is reached
            return ()
        found = (self._proven(challenge, answer) for answer in answers)
        return tuple(claim for claim in found if claim is not None and claim.boot != self._boot)

    def _proven(self, challenge: Challenge, answer: bytes) -> Claim | None:
        try:
            claim = decode(Claim, answer)
        except WireError:
            return None
        said = (_KIND, self._name, challenge.nonce, claim.boot, claim.age)
        return claim if self._lock is None or self._lock.is_own(claim.signature, *said) else None

    @property
    def lost(self) -> str:
        """Why an executor ends that has met an older one of its name."""
        return (
            f"another executor '{self._name}', which has started before this one, is reached again, "
            "and has the name"
        )

    @property
    def _tokens(self) -> str:
        return executor_tokens_of(NAMESPACE, self._name)

    @property
    def _unproven(self) -> str:
        proof = "answers" if self._lock is None else "proves that it has the keys of that name"
        return f"ignoring a liveliness token of the name '{self._name}': nobody {proof}"

    def _age(self) -> int:
        return self._clock() - self._began

    def _taken(self) -> InvalidUse:
        return InvalidUse(
            f"there is an executor '{self._name}' already", help="`--name` gives this one another name"
        )


def _boot(token: str) -> str:
    """Which start of an executor a token is of."""
    return token_node(token)[1].partition("-")[2]
