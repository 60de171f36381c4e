"""Admission of requests: own `Host` and `Origin`, a token in the URL, then a cookie; bounded bodies.

A request needs the cookie, which only the printed URL sets. Other pages in the same browser and other users of the
machine have none. The check of `Host` stops foreign names that resolve to this machine (DNS rebinding).
"""

from __future__ import annotations

import hmac
import logging
import secrets
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Final
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from seoro.ui.answers import RequestError, answer
from seoro.ui.rights import READING

log = logging.getLogger(__name__)

LARGEST_BODY: Final = 64 << 10  # [bytes]
TOKEN: Final = "token"  # noqa: S105 - name of the parameter in the URL
POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' blob: data:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_HEADERS: Final = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


def _random() -> str:
    return secrets.token_urlsafe(32)


@dataclass(frozen=True)
class Access:
    """Addresses and secrets of a server.

    Args:
        scheme: `http` or `https`.
        hosts: Own names and addresses; the first one is printed.
        port: Port.
        token: Secret in the printed URL.
        session: Secret in the cookie.
    """

    scheme: str
    hosts: tuple[str, ...]
    port: int
    token: str = field(default_factory=_random, repr=False)
    session: str = field(default_factory=_random, repr=False)

    @property
    def url(self) -> str:
        """URL that gives access."""
        return f"{self.scheme}://{self.hosts[0]}:{self.port}/?{TOKEN}={self.token}"

    @property
    def cookie(self) -> str:
        """Name of the cookie; browsers share cookies between ports."""
        return f"seoro-ui-{self.port}"

    @property
    def authorities(self) -> frozenset[str]:
        """Valid values of `Host`."""
        is_default = self.port == {"http": 80, "https": 443}[self.scheme]
        return frozenset([f"{host}:{self.port}" for host in self.hosts] + (list(self.hosts) if is_default else []))

    @property
    def origins(self) -> frozenset[str]:
        """Valid values of `Origin`."""
        return frozenset(f"{self.scheme}://{authority}" for authority in self.authorities)


class Guard:
    """Middleware that admits requests and WebSockets, and adds the headers of security.

    Args:
        app: The application.
        access: Addresses and secrets.
    """

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or WebSocket."""
        if scope["type"] not in ("http", "websocket"):
            return
        send = _with_headers(send)
        try:
            signed_in = self._admit(scope)
        except RequestError as error:
            await _refuse(scope, receive, send, error)
            return
        if signed_in is not None:
            await signed_in(scope, receive, send)
            return
        try:
            if scope["type"] == "http":
                await self._serve_bounded(scope, receive, send)
            else:
                await self._app(scope, receive, send)
        except Exception:  # answered already
            log.exception("internal error in %s", scope["path"])

    def _admit(self, scope: Scope) -> Response | None:
        """Check a request; returns the redirection of one with the token.

        Raises:
            RequestError: The request is not admitted.
        """
        headers, is_socket = Headers(scope=scope), scope["type"] == "websocket"
        if headers.getlist("host") not in [[authority] for authority in self._access.authorities]:
            raise RequestError(
                421, "unknown `Host` of the request", "open the URL that `seoro ui` printed, with its address"
            )
        method = "" if is_socket else scope["method"]
        origins = headers.getlist("origin")
        if (origins or method not in READING) and (len(origins) != 1 or origins[0] not in self._access.origins):
            found = "foreign" if origins else "missing"
            raise RequestError(403, f"{found} `Origin` of the request", "only pages of this server may send it")
        if scope["path"] == "/" and method in READING:
            query = parse_qs(scope["query_string"].decode("latin-1"))
            if any(_is_equal(each, self._access.token) for each in query.get(TOKEN, [])):
                return self._sign_in()
        if not self._has_cookie(headers):
            raise RequestError(
                401, "this page needs its access token", "open the URL that `seoro ui` printed when it started"
            )
        return None

    def _sign_in(self) -> Response:
        redirect = RedirectResponse("/", 303)
        redirect.set_cookie(
            self._access.cookie,
            self._access.session,
            httponly=True,
            samesite="strict",
            secure=self._access.scheme == "https",
        )
        return redirect

    def _has_cookie(self, headers: Headers) -> bool:
        cookies = SimpleCookie()
        for line in headers.getlist("cookie"):
            try:
                cookies.load(line)
            except CookieError:
                return False
        found = cookies.get(self._access.cookie)
        return found is not None and _is_equal(found.value, self._access.session)

    async def _serve_bounded(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request whose body is small."""
        too_large = RequestError(
            413, "the body of the request is too large", f"at most {LARGEST_BODY // 1024} kB are accepted"
        )
        length = Headers(scope=scope).get("content-length", "0")
        if not length.isdecimal() or len(length) > 12 or int(length) > LARGEST_BODY:
            await _refuse(scope, receive, send, too_large)
            return
        received = 0

        async def receive_bounded() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > LARGEST_BODY:
                raise too_large
            return message

        await self._app(scope, receive_bounded, send)


def _is_equal(found: str, secret: str) -> bool:
    return hmac.compare_digest(found.encode("utf-8", "replace"), secret.encode())


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


async def _refuse(scope: Scope, receive: Receive, send: Send, error: RequestError) -> None:
    """Answer a request that is not admitted: pages as a sentence, other requests as JSON."""
    if scope["type"] == "http" and not scope["path"].startswith("/api/"):
        sentence = f"{error.error[0].upper()}{error.error[1:]}: {error.help}.\n"
        await Response(sentence, error.status, media_type="text/plain")(scope, receive, send)
    else:
        await answer(error.data, error.status)(scope, receive, send)
