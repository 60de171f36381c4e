"""Sessions, requests and liveliness, out of Zenoh's threads.

Zenoh has no asyncio interface, and calls back on its own receiving threads. What was learned about it
shapes this module: callbacks are direct (an indirect one costs a thread and makes the process hang at exit), do
no more than copy bytes into a bounded queue or wake the event loop, and never call back into Zenoh's
blocking functions; opening, declaring and closing happen in worker threads with a deadline; every query
object is released as soon as it is answered, because a client waits as long as one is alive.

`Session` is thread-neutral and is what a simulator node uses; `asynchronous.py` has its face to asyncio.
"""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable
from typing import Any

import zenoh
from zenoh.handlers import Callback

from seoro.bridges.session.brokered import reached
from seoro.bridges.session.endpoints import is_endpoint
from seoro.bridges.session.errors import InvalidEndpoint, SessionError
from seoro.bridges.session.outages import Outages
from seoro.bridges.session.requests import Attestor, Everything, Intake, Refuser, Request, receiver
from seoro.bridges.session.security import Security, secured_settings

CLOSE_DEADLINE = 2.0  # [s]
SEEN_WITHIN = 1.0  # [s]
LEASE = 15_000  # [ms] that a peer may be silent; one that has died is noticed by the end of its connection
PATIENCE = 1_000_000  # [us] that what is sent may wait for its turn, before it is lost
# Batches of 64 KiB that wait to be sent, as many as Zenoh has. Its own two are full when a laser scanner of 1,000
# scans a second has had to wait 20 ms for a processor, and what it sends then is lost.
ROOM = 16
INBOX_SIZE = 256
EVERYTHING = Everything()
# As nothing on the wire of seoro is larger (`wire.MAX_MESSAGE`): what is, is dropped while it arrives.
LARGEST = 64 << 20  # [bytes]


def _reason(error: Exception) -> str:
    """What Zenoh says, without where in its sources it was raised, and in words for the most frequent case."""
    said = str(error).partition(" at /")[0]
    return "nothing answers there" if said.startswith("Unable to connect to any of") else said


class Session:
    """A Zenoh session with seoro's settings: no multicast, no shared memory, gossip only where it is asked for.

    Args:
        listen: Endpoint to listen on; the session is then the hub (a router).
        connect: Endpoint of the hub to connect to, as a client.
        patient: Whether what is sent may wait a second for its turn before it is lost. A session that publishes
            must not: it would stand still with a receiver that does.
        security: Keys, for endpoints `tls/...`.
        gossip: Whether peers that connect to this router learn of each other, as behind the router of rmw_zenoh:
            a router does not pass on what peers send to each other. The router itself connects to none of them.
        as_peer: Whether to connect to a peer as another one, which learns what that peer announces itself, and not
            what it has from others.
        largest: [bytes] of a message; a larger one is dropped while it arrives.

    Raises:
        InvalidEndpoint: It is none.
        SessionError: Exactly one of the two has to be given, and the endpoint has to work.
    """

    def __init__(
        self,
        *,
        listen: str | None = None,
        connect: str | None = None,
        patient: bool = True,
        security: Security | None = None,
        gossip: bool = False,
        as_peer: bool = False,
        largest: int = LARGEST,
    ) -> None:
        if (listen is None) == (connect is None):
            raise SessionError("a session either listens or connects")
        if gossip and listen is None:
            raise SessionError("gossip needs a router: give `listen`")
        endpoint = listen if connect is None else connect
        assert endpoint is not None
        if not is_endpoint(endpoint):
            raise InvalidEndpoint(f"'{endpoint}' is no endpoint; endpoints look like tcp/127.0.0.1:7447")
        self._tokens: list[Any] = []
        self._queryables: list[Any] = []
        self._kept: list[Any] = []
        self._refuser = Refuser()
        self._listing = threading.Lock()
        self._lister: zenoh.Session | None = None
        self._is_hub = listen is not None
        self._knows_tokens = False
        way = connect if connect is None else reached(connect)
        self._settings = _settings(listen, way, patient, gossip, largest)
        if as_peer:
            self._settings["mode"] = "peer"
        try:
            if security is not None:
                secured_settings(self._settings, security)
            self._zenoh = self._open()
        except zenoh.ZError as error:
            raise SessionError(
                f"cannot {'listen on' if listen else 'connect to'} {endpoint}: {_reason(error)}"
            ) from error

    def _open(self) -> zenoh.Session:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(self._settings)))

    def peers(self) -> frozenset[str]:
        """The peers that are connected, by what Zenoh calls them; not routers, and not clients."""
        return frozenset(str(peer) for peer in self._zenoh.info.peers_zid())

    @property
    def is_cut_off(self) -> bool:
        """Whether a session that connects has lost its connection, and has not connected again yet."""
        info = self._zenoh.info
        return not self._is_hub and not (list(info.routers_zid()) or list(info.peers_zid()))

    def outages(self) -> Outages:
        """Record the outages of the connection from now on."""
        outages = Outages(is_connected=False)

        def changed(event: zenoh.TransportEvent) -> None:
            outages.change(event.kind == zenoh.SampleKind.PUT)

        listener = Callback(changed, indirect=False)
        # Present connections are reported before this returns.
        self.keep(self._zenoh.info.declare_transport_events_listener(listener, history=True))
        return outages

    def keep(self, declared: Any) -> None:
        """Keep what was declared for as long as the session: Zenoh takes back what nobody refers to."""
        self._kept.append(declared)

    @property
    def handle(self) -> zenoh.Session:
        """Zenoh's own session, for the modules of this package."""
        return self._zenoh

    def serve(
        self,
        key: str,
        busy: bytes,
        inbox: queue.SimpleQueue[Any],
        intake: Intake = EVERYTHING,
        attestor: Attestor | None = None,
    ) -> None:
        """Serve a key expression until the session closes.

        Args:
            key: A key expression, wildcards included.
            busy: The error answer to requests that find the queue full.
            inbox: The queue of each `Request`, in the order in which they were sent. Others may put other things
                into it. (It costs a round trip 0.1 ms less than a `Queue`.)
            intake: Decides which requests are accepted.
            attestor: Makes answers authentic.
        """

        def take(request: Request) -> bool:
            if inbox.qsize() >= INBOX_SIZE:
                return False
            inbox.put(request)
            return True

        receive = receiver(intake, self._refuser, take, busy, attestor)
        self._queryables.append(self._declare_queryable(key, receive))

    def answer(
        self,
        key: str,
        take: Callable[[Request], bool | None],
        busy: bytes = b"",
        intake: Intake = EVERYTHING,
        attestor: Attestor | None = None,
    ) -> Callable[[], None]:
        """Serve a key. Returns what ends it.

        Args:
            key: A key expression.
            take: Gets requests on a thread of Zenoh's, must not wait, and returns False if there is no room.
            busy: The error answer then.
            intake: Decides which requests are accepted.
            attestor: Makes answers authentic.
        """
        queryable = self._declare_queryable(key, receiver(intake, self._refuser, take, busy, attestor))
        undeclare: Callable[[], None] = queryable.undeclare
        return undeclare

    def _declare_queryable(self, key: str, receive: Callable[[zenoh.Query], None]) -> Any:
        return self._zenoh.declare_queryable(key, Callback(receive, indirect=False), complete=True)

    def declare_token(self, key: str) -> Callable[[], None]:
        """Be visible as alive under a key until the session closes or the process dies. Returns what ends it.

        The hub knows it when this returns, unless it does not answer within `SEEN_WITHIN`.
        """
        self._knows_tokens = True
        token = self._zenoh.liveliness().declare_token(key)
        self._tokens.append(token)
        _list(self._zenoh, key, SEEN_WITHIN)  # what is asked on the same way is answered after it has come

        def undeclare() -> None:
            self._tokens.remove(token)
            token.undeclare()  # type: ignore[no-untyped-call]

        return undeclare

    def get(
        self,
        key: str,
        payload: bytes,
        timeout: float,
        answers: Callback[zenoh.Reply],
        attachment: bytes | None = None,
        consolidation: zenoh.ConsolidationMode = zenoh.ConsolidationMode.AUTO,
        *,
        to_others: bool = False,
        is_urgent: bool = False,
    ) -> Callable[[], None]:
        """Ask; `answers` is called on a thread of Zenoh's. Returns what cancels the request.

        Args:
            key: Key that is served.
            payload: The request.
            timeout: [s]
            answers: Gets the answers.
            attachment: What travels beside the payload.
            consolidation: Which answers of several are taken.
            to_others: Whether all other sessions that serve the key are asked, instead of one.
            is_urgent: Whether it overtakes everything else on its way, as its answer does.
        """
        token = zenoh.CancellationToken()
        try:
            self._zenoh.get(
                key,
                answers,
                payload=payload,
                timeout=timeout,
                target=zenoh.QueryTarget.ALL if to_others else zenoh.QueryTarget.BEST_MATCHING,
                allowed_destination=zenoh.Locality.REMOTE if to_others else zenoh.Locality.ANY,
                consolidation=consolidation,
                congestion_control=zenoh.CongestionControl.DROP,
                cancellation_token=token,
                attachment=attachment,
                priority=zenoh.Priority.REAL_TIME if is_urgent else zenoh.Priority.DATA,
                express=is_urgent,
            )
        except zenoh.ZError as error:
            raise SessionError(f"cannot ask {key}: {error}") from error
        return token.cancel

    def watch_tokens(self, key: str, changed: Callable[[str, bool], None]) -> Callable[[], None]:
        """Call `changed(token, alive)` on a thread of Zenoh's, for present tokens and each change."""

        def take(sample: zenoh.Sample) -> None:
            changed(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        self._knows_tokens = True
        subscriber = self._zenoh.liveliness().declare_subscriber(key, Callback(take, indirect=False), history=True)
        undeclare: Callable[[], None] = subscriber.undeclare
        return undeclare

    def list_tokens(self, key: str, timeout: float) -> frozenset[str]:
        """Who is alive under a key expression; waits for the hub, `timeout` [s] at most.

        Raises:
            SessionError: The session is closed, or its hub is gone.
        """
        try:
            return _list(self._who_lists(), key, timeout)
        except zenoh.ZError as error:
            raise SessionError(f"cannot ask who is alive: {error}") from error

    def _who_lists(self) -> zenoh.Session:
        """Who can be asked for a list of tokens: of a client that knows some already, another one.

        Zenoh tells a client the tokens that it knows from the thread which asks, and from another that the list is
        at its end, where the hub's answer came. When the latter is first, the list lacks them: one in thirty does.
        """
        if self._is_hub or not self._knows_tokens:
            return self._zenoh
        with self._listing:
            if self._lister is None and not self._zenoh.is_closed():
                self._lister = self._open()
            return self._lister or self._zenoh

    def close(self) -> None:
        """Close, within `CLOSE_DEADLINE`; a session that hangs in closing is left to the end of the process."""
        closing = threading.Thread(target=self._close, daemon=True)
        closing.start()
        closing.join(CLOSE_DEADLINE)

    def _close(self) -> None:
        self._refuser.close()
        self._zenoh.close()  # type: ignore[no-untyped-call]
        with self._listing:
            if self._lister is not None:
                self._lister.close()  # type: ignore[no-untyped-call]


def _list(session: zenoh.Session, key: str, timeout: float) -> frozenset[str]:
    found: set[str] = set()
    done = threading.Event()

    def take(reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            found.add(str(reply.ok.key_expr))

    # Zenoh's own queue for replies has 256 places, and blocks whoever fills it.
    session.liveliness().get(key, Callback(take, drop=done.set, indirect=False), timeout=timeout)
    done.wait(timeout + CLOSE_DEADLINE)
    return frozenset(found)


def _settings(
    listen: str | None, connect: str | None, patient: bool, gossip: bool, largest: int
) -> dict[str, Any]:
    """The configuration of a session; both ends agree on the lease, by which a silent peer is given up."""
    queue: dict[str, Any] = {"size": {"data": ROOM}}
    if patient:
        # Zenoh sends answers as their requests were sent: what finds no room in time is lost. To have it wait for
        # ever would hold up the event loop by a peer that stands still; by Zenoh's own limit of 50 ms, busy
        # machines lose one large answer in a hundred.
        drop = {"wait_before_drop": PATIENCE, "max_wait_before_drop_fragments": PATIENCE}
        queue["congestion_control"] = {"drop": drop}
    link: dict[str, Any] = {"tx": {"lease": LEASE, "queue": queue}}
    if patient:
        link["rx"] = {"max_message_size": largest}
    return {
        "mode": "router" if listen else "client",
        "listen": {"endpoints": [listen] if listen else []},
        "connect": {
            "endpoints": [connect] if connect else [],
            "timeout_ms": 1000,
            "exit_on_failure": True,
            "retry": {"period_init_ms": 100, "period_max_ms": 500},
        },
        "scouting": {
            "multicast": {"enabled": False},
            "gossip": {"enabled": gossip, "multihop": False, "autoconnect": {"router": [], "peer": []}},
            "delay": 20,
        },
        "timestamping": {"enabled": True},
        "transport": {"shared_memory": {"enabled": False}, "link": link},
    }
