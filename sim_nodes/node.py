"""The process: a simulator served over Zenoh, one request at a time, in the order of arrival.

Requests arrive in a queue from Zenoh's threads; everything else happens on the main thread. A request that
cannot be carried out, also because of a fault in here, is answered with a refusal, and the node lives on.
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
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import FrameType

from seoro.bridges.secured import SERVING_NODES, secured
from seoro.bridges.session import Publisher, Request, Session, declare_publisher
from seoro.bridges.wire import Refusal, Result, SimulationState, encode, node_command, node_stream, node_token
from seoro.bridges.wire.keys import NAMESPACE
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.simulator import Simulator
from sim_nodes.verbs import handle
from sim_nodes.waiting import WaitingRequests

# Zenoh's threads and the main one take turns; with the default of 5 ms a wake-up can cost as much.
SWITCH_INTERVAL = 5e-4  # [s]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class NodeSettings:
    """Where a node is reached and under which name; exactly one of `listen` and `connect` is given."""

    node: str
    namespace: str = NAMESPACE
    listen: str | None = None
    connect: str | None = None


def serve(settings: NodeSettings, make: Callable[[], Simulator], ready: Callable[[Simulator], None]) -> None:
    """Serve a simulator until the process is told to end.

    Args:
        settings: Where and under which name.
        make: Makes the simulator.
        ready: Called once requests are taken.

    Raises:
        InvalidUse: Its keys are missing, or of no use there.
        SessionError: The endpoint does not work.
        RequestRefused: The world cannot be loaded.
    """
    sys.setswitchinterval(SWITCH_INTERVAL)
    endpoint = settings.listen or settings.connect or ""
    security = secured(endpoint, SERVING_NODES, listens=settings.listen is not None)
    session = Session(listen=settings.listen, connect=settings.connect, security=security)
    try:
        simulator = make()
        busy = Refusal(
            code=Result.OPERATION_FAILED, message="the node has too many requests waiting: ask again later"
        )
        inbox = session.serve(node_command(settings.namespace, settings.node, "*"), encode(busy))
        simulator.streams.connect(partial(_declare_stream, session, settings))
        session.declare_token(node_token(settings.namespace, settings.node, secrets.token_hex(8)))
        ready(simulator)
        waiting = WaitingRequests(simulator.log)
        while True:
            _turn(simulator, inbox, waiting)
    finally:
        session.close()


def _declare_stream(session: Session, settings: NodeSettings, name: str) -> Publisher:
    return declare_publisher(session, node_stream(settings.namespace, settings.node, name))


def _turn(simulator: Simulator, inbox: queue.SimpleQueue[Request], waiting: WaitingRequests) -> None:
    """Keep pace while playing, and answer those who have waited and the next request."""
    clock = time.monotonic()
    delay = keep_pace(simulator, clock)
    for request in waiting.due(clock):
        answer(simulator, request)
    limits = [limit for limit in (delay, waiting.within(clock)) if limit is not None]
    timeout = min(limits, default=None)
    try:
        request = inbox.get(block=timeout != 0.0, timeout=timeout)
    except queue.Empty:
        return
    if not waiting.put_aside(request, time.monotonic()):
        answer(simulator, request)


def keep_pace(simulator: Simulator, clock: float) -> float | None:
    """As `Simulator.keep_pace`; a fault pauses the simulation instead of ending the node."""
    try:
        return simulator.keep_pace(clock)
    except Exception:
        log.exception("fault while playing, paused")
        simulator.set_state(SimulationState.PAUSED)
        return None


def answer(simulator: Simulator, request: Request) -> None:
    """Carry out a request and answer it, whatever happens."""
    verb = request.key.rsplit("/", 1)[-1]
    try:
        request.reply(handle(simulator, verb, request.payload))
    except RequestRefused as refused:
        _refuse(request, refused.code, refused.message)
    except Exception as error:
        log.exception("fault in %s", verb)
        _refuse(request, Result.OPERATION_FAILED, f"fault in the simulator node: {type(error).__name__}: {error}")


def _refuse(request: Request, code: int, message: str) -> None:
    try:
        request.refuse(encode(Refusal(code=code, message=message)))
    except Exception:  # whoever asked is gone, or was answered in part
        log.exception("cannot refuse a request")


def end_on_signals() -> None:
    """Let SIGTERM end the process as Ctrl-C does: by an exception on the main thread, the session closes."""
    signal.signal(signal.SIGTERM, _end)


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
