"""Requests to a node, its events, and reports of goals and watches."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count
from typing import Any, TypeVar

import anyio

from seoro.bridges import wire
from seoro.bridges.leasing.event_filter import scoped_id
from seoro.bridges.session import AsyncSession, NoAnswer, NoServer, NotAuthentic, Refused, SessionError
from seoro.bridges.wire.authentication import STALE
from seoro.bridges.wire.refusal import read_refusal
from seoro.errors import BackendError, BackendLost, BackendRefused, BackendStopped, BackendUnreachable, UsageError
from seoro.robotics.geometry import Velocity6D
from seoro.runtime.contracts.backends import (
    CONTACT,
    DEPARTURE,
    WARNING,
    EventHandler,
    GoalStatus,
    LossHandler,
    Report,
    Reporter,
)
from seoro.security.network.peers import PeerSigner, PreparedRequest

REQUEST_TIMEOUT = 20.0  # [s] of the machine's clock; the lease of the session ends earlier, with a better reason
LOSS_NOTICE = 0.5  # [s] time limit for the reason of a failed request

R = TypeVar("R", bound=wire.TrackedRequest)


@dataclass(frozen=True)
class NodeAddress:
    """Address of a node.

    Args:
        session: A connected session.
        namespace: Namespace of the node.
        node: Name of the node.
        display_name: Kind of node in messages.
        sender: Client that sends the requests and holds robots there.
        signer: Signer of requests; None if the node has no keys.
    """

    session: AsyncSession
    namespace: str
    node: str
    display_name: str = "simulator"
    sender: str = ""
    signer: PeerSigner | None = None

    async def prove(self) -> None:
        """Challenge a node with keys to prove its name.

        Raises:
            UsageError: The proof is invalid.
            BackendUnreachable: The node does not answer.
        """
        if self.signer is None:
            return
        try:
            await self.signer.verify_peer()
        except NotAuthentic as error:
            raise UsageError(str(error), help="`seoro keys add NAME --role node` makes keys for a node") from None
        except SessionError as error:
            raise BackendUnreachable(
                f"the {self.display_name} node '{self.node}' does not prove its identity: {error}"
            ) from error

    async def query(
        self, verb: wire.Verb[wire.Q, wire.A], payload: bytes, timeout: float, sender: str | None = None
    ) -> bytes:
        """Send a request once, with a signature if required, else with the name of the sender.

        Args:
            verb: Request.
            payload: The request.
            timeout: [s]
            sender: Sender, if other than `sender` of the address.

        Raises:
            BackendRefused: The role of these keys may not send the verb.
            SessionError: The answer is missing or not authentic.
        """
        key = wire.node_command(self.namespace, self.node, verb.name)
        who = sender or self.sender
        attachment = wire.encode_sender(who) if who else b""
        if self.signer is None:
            prepared = PreparedRequest(attachment or None)
        else:
            needs_signature = verb.is_audited or not (who or verb.is_public)
            prepared = await self.signer.prepare(verb, key, payload, None if needs_signature else attachment)
        return await self.session.query(
            key, payload, timeout, prepared.attachment, check=prepared.check, is_urgent=verb.is_urgent
        )


class Requests:
    """Base of the requests to a node; its subclasses implement the capabilities.

    Args:
        address: Address of the node.

    Attributes:
        vet: Called with each request before it is sent; raises `BackendRefused` to reject it.
    """

    def __init__(self, address: NodeAddress) -> None:
        self._address = address
        self._reporters: dict[str, Reporter] = {}
        self._ids = count(1)
        self._given: set[str] = set()
        self._on_event: EventHandler = _ignore_event
        self._on_lost: LossHandler = _ignore
        self._loss: BackendError | None = None
        self._loss_reported = anyio.Event()
        self.vet: Callable[[wire.Message], None] = _ignore

    @property
    def name(self) -> str:
        """Name in messages."""
        return f"{self._address.display_name} '{self._address.node}'"

    def new_id(self, kind: str) -> str:
        """Return a new id for a goal or a watch, unique at the node."""
        identifier = f"{kind}-{next(self._ids)}"
        if self._address.sender:
            identifier = scoped_id(self._address.sender, identifier)
        self._given.add(identifier)
        return identifier

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """See `Backend`."""
        self._on_event, self._on_lost = on_event, on_lost
        if self._loss is not None:
            on_lost(self._loss)

    def report_loss(self, loss: BackendError) -> None:
        """Report that the node is lost, or no longer obeys this client."""
        if self._loss is None:
            self._loss = loss
            self._loss_reported.set()
            self._address.session.abandon()
            self._on_lost(loss)

    def report_event(self, event: wire.Message | None) -> None:
        """Report an event of the node; the end of a goal or a watch goes to its reporter."""
        match event:
            case wire.Contact():
                self._on_event(CONTACT, contact_arguments(event))
            case wire.Departure():
                self._on_event(DEPARTURE, departure_arguments(event))
            case wire.NavigationFeedback():
                self._on_event("navigation_feedback", event.model_dump())
            case wire.GoalWarning():
                self._on_event(WARNING, {"message": event.message})
            case wire.Occurrence():
                if (report := self._reporters.pop(event.id, None)) is not None:
                    status = GoalStatus(event.outcome.value)
                    report(Report(status, event.message, event.interrupted, event.margin))

    async def ask(
        self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
    ) -> wire.A:
        """Send a request to the node and return its reply; see `ask` for the exceptions."""
        self.vet(request)
        if self._loss is not None:
            raise self._loss.with_traceback(None)
        try:
            return await ask(self._address, verb, request, timeout)
        except BackendLost as error:
            # The watcher of the node reports the loss soon, with a better reason.
            with anyio.move_on_after(LOSS_NOTICE):
                await self._loss_reported.wait()
            if self._loss is not None:
                raise self._loss.with_traceback(None) from error
            raise

    async def start(self, verb: wire.Verb[R, wire.Empty], request: R, report: Reporter) -> str:
        """Start a goal or a watch, whose end goes to a reporter; returns its id."""
        self._reporters[request.id] = report
        try:
            await self.ask(verb, request)
        except BaseException:
            self._reporters.pop(request.id, None)
            raise
        return request.id

    async def cancel_report(self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, number: str) -> wire.A | None:
        """Cancel a goal or a watch, and drop its reporter; returns None if it has ended meanwhile."""
        self._reporters.pop(number, None)
        try:
            return await self.ask(verb, request)
        except BackendRefused as error:
            if error.code != wire.Result.NOT_FOUND:
                raise
            return None


async def ask(
    address: NodeAddress, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
) -> wire.A:
    """Send a request to a node and return its reply.

    Raises:
        BackendRefused: The node refuses the request.
        BackendLost: The node no longer obeys this client, or its reply is invalid.
        BackendUnreachable: The node is disconnected, is busy, or does not answer.
    """
    named = f"the {address.display_name} node '{address.node}'"
    try:
        try:
            answer = await _ask_once(address, verb, request, timeout)
        except Refused as refused:
            if address.signer is None or read_refusal(refused.payload).code != STALE:
                raise
            address.signer.reset()
            answer = await _ask_once(address, verb, request, timeout)
        return verb.read_reply(answer)
    except Refused as refused:
        raise to_exception(refused) from None
    except NoServer:
        raise BackendUnreachable(f"{named} is disconnected") from None
    except NoAnswer:
        raise BackendUnreachable(f"{named} did not answer `{verb.name}` in {timeout:g} s") from None
    except NotAuthentic as error:
        raise BackendLost(str(error)) from None
    except SessionError as error:
        raise BackendUnreachable(f"{named} is unreachable: {error}") from error
    except wire.WireError as error:
        raise BackendLost(f"{named} sent an invalid answer: {error}") from error


async def _ask_once(
    address: NodeAddress, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float
) -> bytes:
    try:
        payload = verb.pack(request)
    except wire.LimitExceeded as error:
        raise BackendRefused(str(error), wire.Result.OPERATION_FAILED) from None
    return await address.query(verb, payload, timeout)


def to_exception(refused: Refused) -> BackendError:
    """Convert the refusal of a node to an exception."""
    refusal = read_refusal(refused.payload)
    match refusal.code:
        case wire.LabResult.STOPPED:
            return BackendStopped(refusal.message, refusal.code)
        case wire.LabResult.NOT_HELD | wire.LabResult.FAULT:
            return BackendLost(refusal.message)
        case wire.LabResult.UNAVAILABLE:
            return BackendUnreachable(refusal.message)
        case _:
            return BackendRefused(refusal.message, refusal.code)


def _ignore(argument: object) -> None:
    """Do nothing: the default of callbacks."""


def _ignore_event(name: str, arguments: Mapping[str, object]) -> None:
    """Do nothing: events before a run are dropped."""


# ------------------------------------------------------------ values of the runtime and messages


def twist_message(velocity: Velocity6D) -> wire.Twist:
    """Convert a velocity [m/s, rad/s] to its message."""
    linear, angular = velocity.translational, velocity.angular
    return wire.Twist(
        linear=wire.Vector3(x=linear.x, y=linear.y, z=linear.z),
        angular=wire.Vector3(x=angular.roll, y=angular.pitch, z=angular.yaw),
    )


def contact_arguments(contact: wire.Contact) -> dict[str, Any]:
    """Return the arguments of the event of a contact, for `contracts.contacts.Contact.of`."""
    place, found = contact.position, contact.model_dump(exclude_defaults=True)
    if contact.strikers is not None:
        found["strikers"] = list(contact.strikers)
    if place is not None:
        found["position"] = [place.x, place.y, place.z]
    return found


def departure_arguments(departure: wire.Departure) -> dict[str, Any]:
    """Return the arguments of the event of a robot that left its world: `time`, `robot` and `reason`."""
    place = departure.position
    left, lower, right, upper = departure.extent
    where = f"({place.x:.3f}, {place.y:.3f}, {place.z:.3f}) m"
    reason = (
        f"{departure.robot} left the world at {where}, {departure.time:.3f} s after the start; expected "
        f"x from {left:g} to {right:g} m and y from {lower:g} to {upper:g} m "
        "(`extent` of the world file)"
    )
    return {"time": departure.time, "robot": departure.robot, "reason": reason}
