"""Asking a node, and keeping who is to be told what comes of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import anyio

from seoro.bridges import wire
from seoro.bridges.leasing.share import own_id
from seoro.bridges.seals import Prepared, Seals
from seoro.bridges.session import AsyncSession, NoAnswer, NoServer, NotAuthentic, Refused, SessionError
from seoro.bridges.wire.proving import STALE, is_open, is_sealed
from seoro.bridges.wire.refusal import said_in
from seoro.errors import BackendError, BackendLost, BackendRefused, BackendStopped, BackendUnreachable, InvalidUse
from seoro.runtime.contracts import GoalStatus, Lost, Report, Reporter

REQUEST_TIMEOUT = 20.0  # [s] of the machine's clock; more than the lease of the session, which tells more
LOSS_NOTICE = 0.5  # [s] after a request has failed


@dataclass(frozen=True)
class NodeAddress:
    """How a node is reached: a session that is connected to it, its namespace and its name.

    `called` is what messages call such a node, `sender` who holds robots there and asks, and `seals` what seals
    requests to one with keys.
    """

    session: AsyncSession
    namespace: str
    node: str
    called: str = "simulator"
    sender: str = ""
    seals: Seals | None = None

    async def prove(self) -> None:
        """Have a node with keys prove that it is the one of its name.

        Raises:
            InvalidUse: It is not.
            BackendLost: It does not answer.
        """
        if self.seals is None:
            return
        try:
            await self.seals.prove()
        except NotAuthentic as error:
            raise InvalidUse(str(error), help="`seoro keys add NAME --role node` makes keys for a node") from None
        except SessionError as error:
            raise BackendUnreachable(
                f"the {self.called} node '{self.node}' does not prove who it is: {error}"
            ) from error

    async def query(
        self, verb: wire.Verb[wire.Q, wire.A], payload: bytes, timeout: float, sender: str | None = None
    ) -> bytes:
        """Ask once; beside the request goes a seal if one is needed, else the name of who asks.

        Args:
            verb: What is asked for.
            payload: The request.
            timeout: [s]
            sender: Who asks, if it is not `sender` of the address.

        Raises:
            BackendRefused: The keys here may not ask for that.
            SessionError: There is no answer, or it is not authentic.
        """
        key = wire.node_command(self.namespace, self.node, verb.name)
        who = sender or self.sender
        beside = wire.sender(who) if who else b""
        if self.seals is None:
            prepared = Prepared(beside or None)
        else:
            needs_seal = is_sealed(verb.name) or not (who or is_open(verb.name))
            prepared = await self.seals.prepare(verb.name, key, payload, None if needs_seal else beside)
        return await self.session.query(
            key, payload, timeout, prepared.beside, check=prepared.check, is_urgent=verb.is_urgent
        )


class Requests:
    """Requests to a node; what a node can do is in mixins upon this.

    Args:
        address: How it is reached.
    """

    def __init__(self, address: NodeAddress) -> None:
        self._address = address
        self._reporters: dict[str, Reporter] = {}
        self._ids = count(1)
        self._given: set[str] = set()
        self._lost: Lost = _ignore_loss
        self._loss: BackendError | None = None
        self._gone = anyio.Event()
        self.vet: Callable[[wire.Message], None] = _ignore_request  # refuses requests before they are sent

    @property
    def name(self) -> str:
        """How messages call it."""
        return f"{self._address.called} '{self._address.node}'"

    def new_id(self, kind: str) -> str:
        """An id for a goal or a watch, which nobody else gives there."""
        identifier = f"{kind}-{next(self._ids)}"
        if self._address.sender:
            identifier = own_id(self._address.sender, identifier)
        self._given.add(identifier)
        return identifier

    def report_loss(self, loss: BackendError) -> None:
        """Say that the node is gone, or obeys nobody any more; for whoever watches it."""
        if self._loss is None:
            self._loss = loss
            self._gone.set()
            self._address.session.abandon()
            self._lost(loss)

    async def ask(
        self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
    ) -> wire.A:
        """Ask the node to carry out a verb; see `ask` for what this raises."""
        self.vet(request)
        if self._loss is not None:
            raise self._loss.with_traceback(None)
        try:
            return await ask(self._address, verb, request, timeout)
        except BackendLost as error:
            # Whoever watches the node knows better why, and is about to say so.
            with anyio.move_on_after(LOSS_NOTICE):
                await self._gone.wait()
            if self._loss is not None:
                raise self._loss.with_traceback(None) from error
            raise

    async def ask_reported(self, verb: wire.Verb[wire.Q, wire.Empty], request: wire.Q, number: str) -> str:
        """Ask for something that is reported later, to the reporter of that number; returns the number."""
        try:
            await self.ask(verb, request)
        except BaseException:
            self._reporters.pop(number, None)
            raise
        return number

    async def forget(self, verb: wire.Verb[wire.Q, wire.Empty], request: wire.Q, number: str) -> None:
        """Cancel what would have been reported; what has ended in the meantime is left alone."""
        self._reporters.pop(number, None)
        try:
            await self.ask(verb, request)
        except BackendRefused as error:
            if error.code != wire.Result.NOT_FOUND:  # it has ended by itself in the meantime
                raise


async def ask(
    address: NodeAddress, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
) -> wire.A:
    """Ask a node to carry out a verb.

    Raises:
        BackendRefused: It said no.
        BackendLost: It does not obey this client any more, or what it answers is no valid message.
        BackendUnreachable: It is gone, is busy, or does not answer.
    """
    called = f"the {address.called} node '{address.node}'"
    try:
        try:
            answer = await _ask_once(address, verb, request, timeout)
        except Refused as refused:
            if address.seals is None or said_in(refused.payload).code != STALE:
                raise
            address.seals.forget()
            answer = await _ask_once(address, verb, request, timeout)
        return verb.read_answer(answer)
    except Refused as refused:
        raise refusal_of(refused) from None
    except NoServer:
        raise BackendUnreachable(f"{called} is gone") from None
    except NoAnswer:
        raise BackendUnreachable(f"{called} did not answer `{verb.name}` in {timeout:g} s") from None
    except NotAuthentic as error:
        raise BackendLost(str(error)) from None
    except SessionError as error:
        raise BackendUnreachable(f"{called} cannot be asked: {error}") from error
    except wire.WireError as error:
        raise BackendLost(f"{called} sent an answer that is none: {error}") from error


async def _ask_once(
    address: NodeAddress, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float
) -> bytes:
    try:
        payload = verb.pack(request)
    except wire.LimitExceeded as error:
        raise BackendRefused(str(error), wire.Result.OPERATION_FAILED) from None
    return await address.query(verb, payload, timeout)


def _ignore_request(request: wire.Message) -> None:
    """Nobody has said what may not be asked for."""


def refusal_of(refused: Refused) -> BackendError:
    """Exception for the refusal of a node; refusals that are no answer of the robot are losses of the backend."""
    said = said_in(refused.payload)
    match said.code:
        case wire.LabResult.STOPPED:
            return BackendStopped(said.message, said.code)
        case wire.LabResult.NOT_HELD | wire.LabResult.FAULT:
            return BackendLost(said.message)
        case wire.LabResult.UNAVAILABLE:
            return BackendUnreachable(said.message)
        case _:
            return BackendRefused(said.message, said.code)


def report_of(occurrence: wire.Occurrence) -> Report:
    """Report of the end of a goal, or of a watch."""
    status = GoalStatus(occurrence.outcome.value)
    return Report(status, occurrence.message, occurrence.interrupted)


def _ignore_loss(loss: BackendError) -> None:
    """Before a run has started nobody listens; the reason is kept."""
