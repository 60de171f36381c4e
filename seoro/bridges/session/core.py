"""Sessions, requests and liveliness, out of Zenoh's threads.

Zenoh has no asyncio interface, and calls back on its own receiving threads. Callbacks are direct, since an
indirect one costs a thread and makes the process hang at exit. They only copy bytes into a bounded queue or wake
the event loop, and never call Zenoh's blocking functions. Opening, declaring and closing happen in worker threads
with a deadline. Every query object is released as soon as it is answered, because the client waits while one is
alive.

`Session` works in any thread, as in simulator nodes; `asynchronous.py` adapts it to asyncio.
"""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import zenoh
from zenoh.handlers import Callback

from seoro.bridges.session.brokered import broker_address
from seoro.bridges.session.endpoints import is_endpoint
from seoro.bridges.session.errors import InvalidEndpoint, SessionError, Unanswered
from seoro.bridges.session.outages import Outages
from seoro.bridges.session.requests import AdmissionPolicy, Refuser, Request, receiver
from seoro.bridges.session.security import Security, secured_settings
from seoro.bridges.session.settings import LARGEST, session_settings

if TYPE_CHECKING:
    from seoro.security.signing.answers import AnswerSigner

CLOSE_DEADLINE = 2.0  # [s]
SEEN_WITHIN = 1.0  # [s] time limit for the hub to know a new token
INBOX_SIZE = 256
EVERYTHING = AdmissionPolicy()


def _failure(error: Exception, what: str) -> SessionError:
    """Return the exception for an error of Zenoh, without its source positions."""
    text = str(error).partition(" at /")[0]
    if text.startswith("Unable to connect to any of"):
        return Unanswered(f"cannot {what}: nothing answers there")
    return SessionError(f"cannot {what}: {text}")


class Session:
    """A Zenoh session with seoro's settings: no multicast, no shared memory, gossip only on request.

    Args:
        listen: Endpoint to listen on; the session is then the hub (a router).
        connect: Endpoint of the hub to connect to, as a client.
        patient: Whether messages may wait a second for room on the link before they are dropped. Sessions that
            publish must not wait: one blocked receiver would block the others.
        security: Keys, for endpoints `tls/...`.
        gossip: Whether peers discover each other, as behind the router of rmw_zenoh. A router with gossip names
            its peers to each other, and connects to none of them itself. It forwards no messages between peers. A
            session that connects with gossip is such a peer, to which others of this machine connect, too.
        as_peer: Whether to connect to a peer as another peer. It receives the announcements of that peer only.
        largest: Size limit of received messages [bytes]; larger ones are dropped while they arrive.

    Raises:
        InvalidEndpoint: An endpoint is invalid.
        Unanswered: No session answers at the endpoint to connect to within a second.
        SessionError: Not exactly one of `listen` and `connect` is given, or the endpoint does not work.
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
        endpoint = listen if connect is None else connect
        assert endpoint is not None
        if not is_endpoint(endpoint):
            raise InvalidEndpoint(f"'{endpoint}' is an invalid endpoint; expected one like tcp/127.0.0.1:7447")
        self._kept: list[Any] = []  # Zenoh ends declarations without references
        self._refuser = Refuser()
        self._listing = threading.Lock()
        self._lister: zenoh.Session | None = None
        self._is_hub = listen is not None
        self._knows_tokens = False
        address = connect if connect is None else broker_address(connect)
        meets_peers = gossip and address == connect  # behind a broker, only the endpoint itself is reached
        self._settings = session_settings(
            listen, address, patient=patient, gossip=meets_peers, as_peer=as_peer, largest=largest
        )
        try:
            if security is not None:
                secured_settings(self._settings, security)
            self._zenoh = self._open()
            self._is_routed = bool(list(self._zenoh.info.routers_zid()))
        except zenoh.ZError as error:
            raise _failure(error, f"{'listen on' if listen else 'connect to'} {endpoint}") from error

    def _open(self, **changes: Any) -> zenoh.Session:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(self._settings | changes)))

    def peers(self) -> frozenset[str]:
        """Return Zenoh's ids of the connected peers, without routers and clients."""
        return frozenset(str(peer) for peer in self._zenoh.info.peers_zid())

    @property
    def is_cut_off(self) -> bool:
        """Whether a client has lost its connection, and has not connected again yet."""
        info = self._zenoh.info
        peers = [] if self._is_routed else list(info.peers_zid())
        return not self._is_hub and not (list(info.routers_zid()) or peers)

    def outages(self) -> Outages:
        """Record the outages of the connection from now on."""
        outages, routed = Outages(is_connected=False), self._is_routed

        def changed(event: zenoh.TransportEvent) -> None:
            if not routed or event.transport.whatami == zenoh.WhatAmI.ROUTER:
                outages.change(event.kind == zenoh.SampleKind.PUT)

        listener = Callback(changed, indirect=False)
        # Present connections are reported before this returns.
        self.keep(self._zenoh.info.declare_transport_events_listener(listener, history=True))
        return outages

    def keep(self, declared: Any) -> None:
        """Keep a declaration until the session closes."""
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
        intake: AdmissionPolicy = EVERYTHING,
        attestor: AnswerSigner | None = None,
    ) -> None:
        """Serve a key expression until the session closes.

        Args:
            key: A key expression, wildcards included.
            busy: Error answer to requests that find the queue full.
            inbox: Queue that receives each `Request` in the order of arrival, and may receive other items. (A
                round trip takes 0.1 ms less than with a `Queue`.)
            intake: Decides which requests are accepted.
            attestor: Makes answers authentic.
        """

        def take(request: Request) -> bool:
            if inbox.qsize() >= INBOX_SIZE:
                return False
            inbox.put(request)
            return True

        self.keep(self.answer(key, take, busy, intake, attestor))

    def answer(
        self,
        key: str,
        take: Callable[[Request], bool | None],
        busy: bytes = b"",
        intake: AdmissionPolicy = EVERYTHING,
        attestor: AnswerSigner | None = None,
    ) -> Callable[[], None]:
        """Serve a key. Returns a function that ends this.

        Args:
            key: A key expression.
            take: Called with requests on a thread of Zenoh; must not wait, and returns False if the queue is
                full.
            busy: Error answer for a full queue.
            intake: Decides which requests are accepted.
            attestor: Makes answers authentic.
        """
        receive = receiver(intake, self._refuser, take, busy, attestor)
        queryable = self._zenoh.declare_queryable(key, Callback(receive, indirect=False), complete=True)
        undeclare: Callable[[], None] = queryable.undeclare
        return undeclare

    def declare_token(self, key: str) -> Callable[[], None]:
        """Declare a liveliness token until the session closes or the process dies; returns a function to end it.

        On return, the hub knows the token, unless it did not answer within `SEEN_WITHIN`.
        """
        self._knows_tokens = True
        token = self._zenoh.liveliness().declare_token(key)
        self.keep(token)
        _list(self._zenoh, key, SEEN_WITHIN)  # the answer follows the token on the same connection

        def undeclare() -> None:
            self._kept.remove(token)
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
        """Send a request. Returns a function that cancels it.

        Args:
            key: Key of the server.
            payload: The request.
            timeout: [s]
            answers: Called with answers on a thread of Zenoh.
            attachment: Attachment of the request.
            consolidation: Policy for several answers.
            to_others: Whether the request goes to all other sessions that serve the key, instead of one.
            is_urgent: Whether the request and its answer overtake all other messages.
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
            raise SessionError(f"cannot send a request to {key}: {error}") from error
        return token.cancel

    def watch_tokens(self, key: str, changed: Callable[[str, bool], None]) -> Callable[[], None]:
        """Call `changed(token, alive)` on a thread of Zenoh, for present tokens and each change."""

        def take(sample: zenoh.Sample) -> None:
            changed(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        self._knows_tokens = True
        subscriber = self._zenoh.liveliness().declare_subscriber(key, Callback(take, indirect=False), history=True)
        undeclare: Callable[[], None] = subscriber.undeclare
        return undeclare

    def list_tokens(self, key: str, timeout: float) -> frozenset[str]:
        """Return the live tokens of a key expression; waits for the hub, `timeout` [s] at most.

        Raises:
            SessionError: The session is closed, or its hub is disconnected.
        """
        try:
            return _list(self._listing_session(), key, timeout)
        except zenoh.ZError as error:
            raise SessionError(f"cannot list liveliness tokens: {error}") from error

    def _listing_session(self) -> zenoh.Session:
        """Return a session that can list tokens: for one that follows tokens already, a client beside it.

        Zenoh reports tokens that a client knows from the calling thread, and the end of the list from another
        thread. If the end comes first, as in one of thirty lists, tokens are missing.
        """
        if self._is_hub or not self._knows_tokens:
            return self._zenoh
        with self._listing:
            if self._lister is None and not self._zenoh.is_closed():
                self._lister = self._open(mode="client", listen={"endpoints": []})
            return self._lister or self._zenoh

    def close(self) -> None:
        """Close within `CLOSE_DEADLINE`; a session that hangs is closed by the end of the process."""
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

    # Zenoh's own queue for replies holds 256, and blocks its sender when it is full.
    session.liveliness().get(key, Callback(take, drop=done.set, indirect=False), timeout=timeout)
    done.wait(timeout + CLOSE_DEADLINE)
    return frozenset(found)
