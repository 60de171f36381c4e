"""Delivery of notifications, within a bounded time and without redirects."""

from __future__ import annotations

import hashlib
import hmac
import os
import time
from base64 import b64encode
from collections.abc import Sequence
from http.client import HTTPException, HTTPMessage
from threading import Thread
from typing import IO, Final
from urllib.error import HTTPError, URLError
from urllib.request import HTTPRedirectHandler, OpenerDirector, ProxyHandler, Request, build_opener

from seoro import __version__
from seoro.notifications.addresses import Address
from seoro.notifications.message import Message

SECRET: Final = "SEORO_NOTIFY_SECRET"  # noqa: S105 - name of a variable of the environment
ATTEMPTS: Final = 3
LONGEST: Final = 10.0  # [s] for all attempts of all URLs
_ANSWER: Final = 3.0  # [s] for an answer
_PAUSE: Final = 0.25  # [s] before the second attempt; doubles
_LATER: Final = frozenset({408, 425, 429, 500, 502, 503, 504})  # statuses that another attempt may change


def deliver(addresses: Sequence[Address], message: Message, longest: float = LONGEST) -> list[str]:
    """Send a notification to all URLs at once.

    Args:
        addresses: The URLs.
        message: The notification.
        longest: Longest time that it takes [s].

    Returns:
        A description of each failed delivery, without secrets.
    """
    end = time.monotonic() + longest
    problems = [f"no answer within {longest:g} s"] * len(addresses)

    def send(index: int) -> None:
        problems[index] = _send(addresses[index], message, end)

    # Slow servers cannot delay the end of the process: its exit does not await daemons.
    threads = [Thread(target=send, args=(index,), daemon=True) for index in range(len(addresses))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(max(0.0, end - time.monotonic()))
    return [f"{address.shown}: {problem}" for address, problem in zip(addresses, problems, strict=True) if problem]


def signature(secret: str, body: bytes) -> str:
    """Return the signature of a body: HMAC-SHA256 with the secret, in hexadecimal digits."""
    return hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()


class _Unredirected(HTTPRedirectHandler):
    """Reports redirects as errors: the user has named the receiver."""

    def redirect_request(
        self, req: Request, fp: IO[bytes], code: int, msg: str, headers: HTTPMessage, newurl: str
    ) -> None:
        """Follow no redirect."""


def _send(address: Address, message: Message, end: float) -> str:
    """Send with repeated attempts; return the last problem, empty if it was delivered."""
    opener = build_opener(_Unredirected, *([ProxyHandler({})] if address.is_local else []))
    problem, pause = "", _PAUSE
    for attempt in range(ATTEMPTS):
        if attempt:
            time.sleep(min(pause, max(0.0, end - time.monotonic())))
            pause *= 2
        left = end - time.monotonic()
        if left <= 0:
            break
        problem, is_final = _attempt(opener, address, message, min(_ANSWER, left))
        if is_final:
            break
    return problem


def _attempt(opener: OpenerDirector, address: Address, message: Message, timeout: float) -> tuple[str, bool]:
    """Send once; return the problem, and whether another attempt is useless."""
    try:
        with opener.open(_request(address, message), timeout=timeout):
            return "", True
    except HTTPError as error:
        error.close()
        is_redirect = 300 <= error.code < 400
        return f"status {error.code}" + (" (redirects are not followed)" * is_redirect), error.code not in _LATER
    except URLError as error:
        return _reason(error.reason), False
    except (OSError, HTTPException) as error:
        return _reason(error), False


def _reason(error: object) -> str:
    if isinstance(error, TimeoutError):
        return f"no answer within {_ANSWER:g} s"
    return (isinstance(error, OSError) and error.strerror) or type(error).__name__


def _request(address: Address, message: Message) -> Request:
    headers = {
        "Content-Type": "application/json",
        "User-Agent": f"seoro/{__version__}",
        "Seoro-Event": message.event,
        "Seoro-Delivery": message.id,
    }
    if secret := os.environ.get(SECRET):
        headers["Seoro-Signature"] = f"sha256={signature(secret, message.body)}"
    if address.credentials is not None:
        headers["Authorization"] = f"Basic {b64encode(':'.join(address.credentials).encode()).decode()}"
    return Request(address.url, message.body, headers, method="POST")  # noqa: S310 - checked by `read_address`
