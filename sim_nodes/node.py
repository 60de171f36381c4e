"""The process: a simulator served over Zenoh, one request at a time, in the order of arrival.

Requests arrive in a queue from Zenoh's threads; a thread opens sessions, and everything else happens on the main
one. A request that cannot be carried out, also because of a fault in here, is answered with a refusal, and the
node lives on.
"""

from __future__ import annotations

import logging
import os
import queue
import secrets
import shutil
import signal
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import FrameType
from typing import assert_never

from anyio.from_thread import start_blocking_portal

from seoro.bridges.door import Door, node_door
from seoro.bridges.serving.emergency import StopLine, hearing_stops, stop_line
from seoro.bridges.serving.gate import NodeGate, opened_gate
from seoro.bridges.serving.intake import CountedIntake
from seoro.bridges.session import (
    AsyncSession,
    Publisher,
    Request,
    Session,
    SessionError,
    declare_publisher,
)
from seoro.bridges.wire import (
    BRIDGE_VERBS,
    CHALLENGE,
    HOLD_ROBOTS,
    LAB_VERBS,
    VERBS,
    LabResult,
    Refusal,
    Result,
    SimulationState,
    WireError,
    encode,
    holder_tokens,
    node_command,
    node_stream,
    node_token,
)
from seoro.bridges.wire.holding import sender_of
from seoro.bridges.wire.keys import NAMESPACE, verb_of
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.leasing import Leasing
from sim_nodes.simulator import Simulator
from sim_nodes.stopping import Stops
from sim_nodes.verbs import handle
from sim_nodes.waiting import VERBS as LASTING
from sim_nodes.waiting import WaitingRequests

# Zenoh's threads and the main one take turns; with the default of 5 ms a wake-up can cost as much.
SWITCH_INTERVAL = 5e-4  # [s]

ALL_VERBS = (*VERBS, *BRIDGE_VERBS, *LAB_VERBS, CHALLENGE)

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class NodeSettings:
    """Where a node is reached and under which name; exactly one of `listen` and `connect` is given.

    Args:
        stop_file: Where it keeps an emergency stop, so that it outlasts the process; None for nowhere.
    """

    node: str
    namespace: str = NAMESPACE
    listen: str | None = None
    connect: str | None = None
    stop_file: Path | None = None
    log: Path | None = None  # of what is asked of a node with keys


@dataclass(frozen=True)
class TokenChanged:
    """A liveliness token of somebody who holds robots has appeared, or is gone."""

    token: str
    is_alive: bool


@dataclass(frozen=True)
class Urgent:
    """There is an emergency stop."""


@dataclass(frozen=True)
class Opened:
    """A session was opened, by which tokens have to be seen."""


@dataclass(frozen=True)
class Outlet:
    """Where a stream goes to, until its session is closed; those who take it have to ask anew then."""

    publisher: Publisher

    def put(self, payload: bytes) -> None:
        """Publish, without waiting for anybody."""
        with suppress(SessionError):
            self.publisher.put(payload)

    @property
    def is_taken(self) -> bool:
        """Whether somebody subscribes."""
        return self.publisher.is_taken

    def close(self) -> None:
        """Publish nothing any more."""
        self.publisher.close()


@dataclass(frozen=True)
class Signalled:
    """A signal has come, which the main thread sees to as soon as it does not wait."""


Arrived = Request | TokenChanged | Urgent | Opened | Signalled
"""What comes from Zenoh's threads to the main one."""


def serve(settings: NodeSettings, make: Callable[[], Simulator], ready: Callable[[Simulator], None]) -> None:
    """Serve a simulator until the process is told to end.

    Args:
        settings: Where and under which name.
        make: Makes the simulator.
        ready: Called once requests are taken.

    Raises:
        InvalidUse: Its keys are missing, or of no use there; or there is another node of the name.
        SessionError: The endpoint does not work.
        RequestRefused: The world cannot be loaded.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    door = node_door(settings.listen, settings.connect, settings.node, settings.namespace)
    with opened_gate(door, settings.log) as gate, start_blocking_portal() as portal:
        simulator, inbox = make(), queue.SimpleQueue[Arrived]()
        _wake_on_signals(partial(inbox.put, Signalled()))
        serving = Serving(simulator, gate, settings.stop_file)
        stops = Stops(simulator, serving.leasing, partial(inbox.put, Urgent()))
        with stop_line(gate.lock, stops.stop, serving.leasing.latch.keep, settings.namespace) as line:
            reached = partial(_reached, settings, simulator, door, gate, line, inbox, secrets.token_hex(8))
            portal.start_task(door.attend, reached)
            ready(simulator)
            while True:
                serving.turn(inbox, stops)


@asynccontextmanager
async def _reached(
    settings: NodeSettings,
    simulator: Simulator,
    door: Door,
    gate: NodeGate,
    stops: StopLine,
    inbox: queue.SimpleQueue[Arrived],
    boot: str,
    session: AsyncSession,
) -> AsyncIterator[None]:
    """Be the node at a session; `boot` tells this start of it from the next."""
    opened = session.blocking
    busy = Refusal(code=LabResult.UNAVAILABLE, message="the node has too many requests waiting: ask again later")
    inbox.put(Opened())
    intake = CountedIntake(ALL_VERBS, "node", stop=stops.take)
    async with hearing_stops(stops, door, session):
        key = node_command(settings.namespace, settings.node, "*")
        opened.serve(key, encode(busy), inbox, intake, gate.attestor)
        blind = _watch_holders(opened, settings.namespace, inbox)
        simulator.streams.connect(partial(_declare_stream, opened, settings))
        opened.declare_token(node_token(settings.namespace, settings.node, boot))
        try:
            yield
        finally:
            blind()  # that tokens go with the session says nothing of their holders


def _watch_holders(session: Session, namespace: str, inbox: queue.SimpleQueue[Arrived]) -> Callable[[], None]:
    """Watch the tokens of those who hold robots; returns what ends it."""

    def changed(token: str, is_alive: bool) -> None:
        inbox.put(TokenChanged(token, is_alive))

    return session.watch_tokens(holder_tokens(namespace), changed)


def _declare_stream(session: Session, settings: NodeSettings, name: str) -> Outlet:
    return Outlet(declare_publisher(session, node_stream(settings.namespace, settings.node, name)))


class Serving:
    """Carries out what arrives, one after another.

    Args:
        simulator: The simulator.
        gate: Lets requests in.
        stop_file: See `NodeSettings`.

    Attributes:
        leasing: Who has which robots.
    """

    def __init__(self, simulator: Simulator, gate: NodeGate, stop_file: Path | None = None) -> None:
        self._simulator = simulator
        self._gate = gate
        self.leasing = Leasing(simulator, stop_file)
        self._waiting = WaitingRequests(simulator.log)

    def turn(self, inbox: queue.SimpleQueue[Arrived], stops: Stops) -> None:
        """Keep pace while playing, and see to what has come, is due, or comes next; to emergency stops first."""
        if stops.settle():
            for request in self._waiting.all():
                self.answer(request)
        clock = time.monotonic()
        delay = keep_pace(self._simulator, clock)
        if inbox.empty():  # else a sign of life may have come that nobody has had the time to see
            self.leasing.stop_overdue()
        for request in self._waiting.due(clock):
            self.answer(request)
        times = (delay, self._waiting.within(clock), self.leasing.within())
        timeout = min((each for each in times if each is not None), default=None)
        try:
            arrived = inbox.get(block=timeout != 0.0, timeout=timeout)
        except queue.Empty:
            return
        match arrived:
            case TokenChanged():
                self.leasing.token_changed(arrived.token, is_alive=arrived.is_alive)
            case Opened():
                self.leasing.lose_sight()
            case Request():
                self._receive(arrived)
            case Urgent() | Signalled():  # which the next turn begins with
                pass
            case _:
                assert_never(arrived)

    def _receive(self, request: Request) -> None:
        """Answer a request, or let it wait for something to happen."""
        try:
            waits = self._put_aside(request)
        except RequestRefused as refused:
            _refuse(request, refused.code, refused.message)
            return
        if not waits:
            self.answer(request)

    def _put_aside(self, request: Request) -> bool:
        """Let a request wait if its verb does; it is authenticated when it arrives, and gives a sign of life.

        Raises:
            RequestRefused: It is not authentic, or the client holds nothing.
        """
        verb = verb_of(request.key)
        if verb not in LASTING:
            return False
        sender = self._gate.authenticate(request, self.leasing.key_of) or sender_of(request.attachment)
        if verb == HOLD_ROBOTS.name:
            try:
                asked = HOLD_ROBOTS.read(request.payload)
            except WireError:
                return False  # which the answer says
            self._gate.check_holder(verb, sender, asked)
            self.leasing.note_life(asked.holder)
        return self._waiting.put_aside(request, time.monotonic())

    def answer(self, request: Request) -> None:
        """Carry out a request and answer it, whatever happens."""
        verb = verb_of(request.key)
        try:
            if verb == CHALLENGE.name:
                request.reply(encode(self._gate.prove(request.payload)))
                return
            with self._gate.admitted(request, self.leasing.key_of) as sender:
                answer = self._carry_out(sender, verb, request.payload)
            request.reply(answer)
        except RequestRefused as refused:
            _refuse(request, refused.code, refused.message)
        except Exception as error:
            log.exception("fault in %s", verb)
            why = f"fault in the simulator node: {type(error).__name__}: {error}"
            _refuse(request, LabResult.FAULT, why)

    def _carry_out(self, sender: str, verb: str, payload: bytes) -> bytes:
        own = self.leasing.verbs.get(verb)
        if own is None:
            return handle(self._simulator, verb, payload, partial(self.leasing.permit, sender))
        known, carry = own
        try:
            asked = known.read(payload)
        except WireError as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        self._gate.check_holder(verb, sender, asked)
        self._simulator.stay()
        return encode(carry(asked))


def keep_pace(simulator: Simulator, clock: float) -> float | None:
    """As `Simulator.keep_pace`; a fault pauses the simulation instead of ending the node."""
    try:
        return simulator.keep_pace(clock)
    except Exception:
        log.exception("fault while playing, paused")
        simulator.set_state(SimulationState.PAUSED)
        return None


def _refuse(request: Request, code: int, message: str) -> None:
    try:
        request.refuse(encode(Refusal(code=code, message=message)))
    except Exception:  # whoever asked is gone, or was answered in part
        log.exception("cannot refuse a request")


def end_on_signals() -> None:
    """Let SIGTERM end the process as Ctrl-C does: by an exception on the main thread, the session closes."""
    signal.signal(signal.SIGTERM, _end)


def _wake_on_signals(wake: Callable[[], None]) -> None:
    """Have something called, on a thread, when a signal has come.

    By itself, one that comes just before the main thread begins to wait does not wake it.
    """
    come, told = os.pipe()
    os.set_blocking(told, False)
    signal.set_wakeup_fd(told, warn_on_full_buffer=False)

    def work() -> None:
        while os.read(come, 1):
            wake()

    threading.Thread(target=work, daemon=True, name="signals").start()


def _end(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def die_with_parent(folder: str | None) -> None:
    """End the process when stdin ends, also in the middle of a request; leave Ctrl-C to the parent.

    Args:
        folder: The parent's folder for their socket. A parent that writes anything before it closes stdin removes
            that itself; one that does not has died.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_wait_for_parent, args=(folder,), daemon=True, name="parent").start()


def _wait_for_parent(folder: str | None) -> None:
    has_died = True
    while os.read(sys.stdin.fileno(), 4096):
        has_died = False
    if has_died and folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
    # The main thread may be deep in a grant, and nobody is left to be told anything.
    os._exit(0)
