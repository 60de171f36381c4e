"""Serves a simulator over Zenoh; requests are handled one at a time, in order of arrival.

Zenoh's threads put requests into a queue; one thread opens sessions. Everything else happens on the main thread.
If a request fails, also through a defect of the node, the client gets a refusal and the node keeps running.
"""

from __future__ import annotations

import gc
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
from contextlib import asynccontextmanager
from enum import Enum, auto
from functools import partial
from pathlib import Path
from typing import assert_never

from anyio.from_thread import start_blocking_portal

from seoro.bridges import wire
from seoro.bridges.serving.admission import AdmissionLimits
from seoro.bridges.serving.answering import refuse
from seoro.bridges.serving.emergency import StopThread, stop_thread, subscribing_to_stops
from seoro.bridges.session import AsyncSession, Request, declare_publisher
from seoro.bridges.wire import Empty
from seoro.bridges.wire.holds import decode_sender
from seoro.bridges.wire.keys import NAMESPACE, verb_of
from seoro.bridges.wire.refusal import RequestRefused, read_request
from seoro.deferred import dataclass
from seoro.security.network.authorizer import NodeAuthorizer, open_authorizer
from seoro.security.network.listener import Listener, node_listener
from sim_nodes.event_log import LongPolls
from sim_nodes.leasing import EmergencyStops, Leasing
from sim_nodes.memory import return_free
from sim_nodes.simulator import Simulator
from sim_nodes.verbs import handle

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class NodeSettings:
    """Name and endpoint of a node; exactly one of `listen` and `connect` is given.

    Args:
        stop_file: File that keeps an emergency stop across restarts; None to keep none.
    """

    node: str
    namespace: str = NAMESPACE
    listen: str | None = None
    connect: str | None = None
    stop_file: Path | None = None
    log: Path | None = None  # audit log of a node with keys


@dataclass(frozen=True)
class TokenChanged:
    """The liveliness token of a client that holds robots appeared or disappeared."""

    token: str
    is_alive: bool


class Wake(Enum):
    """Events that wake the main thread."""

    STOP_REQUESTED = auto()
    SESSION_OPENED = auto()  # tokens are reported anew
    SIGNAL_RECEIVED = auto()  # the main thread handles it when it next waits


REPLACING = frozenset(
    verb.name
    for verb in (wire.LOAD_WORLD, wire.CHANGE_WORLD, wire.UNLOAD_WORLD, wire.RESET_SIMULATION, wire.RESTORE_STATE)
)
"""Names of the verbs after which the simulation before is garbage."""

InboxItem = Request | TokenChanged | Wake
"""Item of the queue from Zenoh's threads to the main thread."""


def serve(settings: NodeSettings, make: Callable[[], Simulator], ready: Callable[[Simulator], None]) -> None:
    """Serve a simulator until the process is stopped.

    Args:
        settings: Name and endpoint.
        make: Factory of the simulator.
        ready: Called once requests are accepted.

    Raises:
        UsageError: Its keys are missing or unusable, or the name is in use by another node.
        SessionError: The endpoint is unusable.
        RequestRefused: The world cannot be loaded.
    """
    listener = node_listener(settings.listen, settings.connect, settings.node, settings.namespace)
    with open_authorizer(listener, settings.log) as authorizer, start_blocking_portal() as portal:
        simulator, inbox = make(), queue.SimpleQueue[InboxItem]()
        _wake_on_signals(partial(inbox.put, Wake.SIGNAL_RECEIVED))
        serving = RequestLoop(simulator, authorizer, settings.stop_file)
        stops = EmergencyStops(simulator, serving.leasing, partial(inbox.put, Wake.STOP_REQUESTED))
        with stop_thread(authorizer.identity, stops.stop, serving.leasing.latch.save, settings.namespace) as line:
            serve = partial(
                _serve_session, settings, simulator, listener, authorizer, line, inbox, secrets.token_hex(8)
            )
            portal.start_task(listener.serve, serve)
            ready(simulator)
            while True:
                serving.run_once(inbox, stops)


@asynccontextmanager
async def _serve_session(
    settings: NodeSettings,
    simulator: Simulator,
    listener: Listener,
    authorizer: NodeAuthorizer,
    stops: StopThread,
    inbox: queue.SimpleQueue[InboxItem],
    boot: str,
    session: AsyncSession,
) -> AsyncIterator[None]:
    """Serve on a session; `boot` distinguishes this start of the node from later ones."""
    opened = session.blocking
    busy = wire.Refusal(
        code=wire.LabResult.UNAVAILABLE, message="too many requests are waiting in the node; retry later"
    )
    inbox.put(Wake.SESSION_OPENED)
    intake = AdmissionLimits(wire.NODE_VERBS.values(), "node", stop=stops.on_request)
    async with subscribing_to_stops(stops, listener, session):
        key = wire.node_command(settings.namespace, settings.node, "*")
        opened.serve(key, wire.encode(busy), inbox, intake, authorizer.attestor)
        stop_watching = opened.watch_tokens(
            wire.holder_tokens(settings.namespace),
            lambda token, is_alive: inbox.put(TokenChanged(token, is_alive)),
        )
        simulator.streams.connect(
            lambda name: declare_publisher(opened, wire.node_stream(settings.namespace, settings.node, name))
        )
        opened.declare_token(wire.node_token(settings.namespace, settings.node, boot))
        try:
            yield
        finally:
            stop_watching()  # the tokens disappear with the session; their owners may be alive


class RequestLoop:
    """Handles queued items, one after another.

    Args:
        simulator: Simulator to serve.
        authorizer: Authorizer of requests.
        stop_file: See `NodeSettings`.

    Attributes:
        leasing: Leases of the robots.
    """

    def __init__(self, simulator: Simulator, authorizer: NodeAuthorizer, stop_file: Path | None = None) -> None:
        self._simulator = simulator
        self._authorizer = authorizer
        self.leasing = Leasing(simulator, stop_file)
        self._waiting = LongPolls(simulator.log)

    def run_once(self, inbox: queue.SimpleQueue[InboxItem], stops: EmergencyStops) -> None:
        """Handle emergency stops, keep pace while playing, then handle due requests and the next item."""
        if stops.apply_pending():
            for request in self._waiting.pop_all():
                self.answer(request)
        clock = time.monotonic()
        delay = keep_pace(self._simulator, clock)
        if inbox.empty():  # otherwise a heartbeat may be waiting in the queue
            self.leasing.stop_overdue()
        for request in self._waiting.pop_due(clock):
            self.answer(request)
        times = (delay, self._waiting.time_to_next(clock), self.leasing.leases.within())
        timeout = min((each for each in times if each is not None), default=None)
        try:
            arrived = inbox.get(block=timeout != 0.0, timeout=timeout)
        except queue.Empty:
            return
        match arrived:
            case TokenChanged():
                self.leasing.token_changed(arrived.token, is_alive=arrived.is_alive)
            case Wake.SESSION_OPENED:
                self.leasing.leases.lose_connection()  # all tokens are reported anew
            case Request():
                self._receive(arrived)
            case Wake.STOP_REQUESTED | Wake.SIGNAL_RECEIVED:  # handled at the start of the next call
                pass
            case _:
                assert_never(arrived)

    def _receive(self, request: Request) -> None:
        """Answer a request, or defer it until an event occurs."""
        try:
            if not self._defer(request):
                self.answer(request)
        except RequestRefused as refused:
            refuse(request, refused.code, refused.message)

    def _defer(self, request: Request) -> bool:
        """Defer a request if its verb waits for events. Authenticates it and records a heartbeat first.

        Raises:
            RequestRefused: The request is not authentic, or the client holds no robots.
        """
        verb = verb_of(request.key)
        if verb not in wire.NODE_VERBS or not wire.NODE_VERBS[verb].waits:
            return False
        sender = self._authorizer.authenticate(request, self.leasing.leases.key_of) or decode_sender(
            request.attachment
        )
        if verb == wire.HOLD_ROBOTS.name:
            try:
                asked = wire.HOLD_ROBOTS.read(request.payload)
            except wire.WireError:
                return False  # the refusal is in the answer
            self._authorizer.check_holder(wire.HOLD_ROBOTS, sender, asked)
            self.leasing.leases.renew(asked.holder)
        return self._waiting.defer(request, time.monotonic())

    def answer(self, request: Request) -> None:
        """Handle a request and answer it, also after errors."""
        verb = verb_of(request.key)
        try:
            if verb == wire.CHALLENGE.name:
                request.reply(wire.encode(self._authorizer.prove(request.payload)))
                return
            with self._authorizer.admitted(request, self.leasing.leases.key_of) as sender:
                answer = self._carry_out(sender, verb, request.payload)
            request.reply(answer)
            if verb in REPLACING:
                gc.collect()  # worlds are large, and refer to themselves in cycles
                return_free()
        except RequestRefused as refused:
            refuse(request, refused.code, refused.message)
        except Exception as error:
            log.exception("fault in %s", verb)
            why = f"fault in the simulator node: {type(error).__name__}: {error}"
            refuse(request, wire.LabResult.FAULT, why)

    def _carry_out(self, sender: str, name: str, payload: bytes) -> bytes:
        handler = getattr(self.leasing, name, None) if name in wire.NODE_VERBS else None
        if handler is None:
            return handle(self._simulator, name, payload, partial(self.leasing.authorize, sender))
        request = read_request(verb := wire.NODE_VERBS[name], payload)
        self._authorizer.check_holder(verb, sender, request)
        if not verb.is_read_only:  # viewers may ask while the simulator is ahead
            self._simulator.discard_checkpoint()
        return wire.encode(handler(request) or Empty())


def keep_pace(simulator: Simulator, clock: float) -> float | None:
    """Call `Simulator.keep_pace`; an error pauses the simulation and the node keeps running."""
    try:
        return simulator.keep_pace(clock)
    except Exception:
        log.exception("fault while playing, paused")
        simulator.set_state(wire.SimulationState.PAUSED)
        return None


def end_on_signals() -> None:
    """Make SIGTERM raise KeyboardInterrupt on the main thread, as Ctrl-C does, so that the session closes."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def _wake_on_signals(wake: Callable[[], None]) -> None:
    """Call `wake` on a thread after each signal.

    A signal that arrives just before the main thread waits would not wake it.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)

    def forward() -> None:
        while os.read(reader, 1):
            wake()

    threading.Thread(target=forward, daemon=True, name="signals").start()


def die_with_parent(folder: str | None) -> None:
    """End the process when stdin closes, also during a request; ignore Ctrl-C.

    Args:
        folder: The parent's folder for its socket. A parent that writes to stdin before closing it deletes the
            folder itself; otherwise the parent was killed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_wait_for_parent, args=(folder,), daemon=True, name="parent").start()


def _wait_for_parent(folder: str | None) -> None:
    has_died = True
    while os.read(sys.stdin.fileno(), 4096):
        has_died = False
    if has_died and folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
    # The main thread may be in a long grant, and the parent is gone.
    os._exit(0)
