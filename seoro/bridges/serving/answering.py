"""Replies to requests: each request receives exactly one."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from typing import Final

import anyio.to_thread

from seoro.bridges import wire
from seoro.bridges.session import Request
from seoro.bridges.wire import LabResult, Result
from seoro.bridges.wire.keys import verb_of
from seoro.bridges.wire.refusal import RequestRefused

AT_ONCE: Final = 1 << 16  # [bytes] of replies that are sent on the event loop; larger ones may block

log = logging.getLogger(__name__)


async def answer(
    request: Request,
    carry_out: Callable[[str, bytes], Awaitable[wire.Message | None]],
    server: str,
    ended: int = Result.OPERATION_FAILED,
) -> None:
    """Carry out a request and reply to it.

    Args:
        request: The request, whose key ends with its verb.
        carry_out: Called with verb and payload; returns the reply (None if empty) or raises `RequestRefused`.
        server: Kind of the server for messages, such as `bridge`.
        ended: Code of the refusal if the server ends first.
    """
    verb = verb_of(request.key)
    try:
        payload = wire.encode(await carry_out(verb, request.payload) or wire.Empty())
        if len(payload) <= AT_ONCE:
            request.reply(payload)
        else:
            await anyio.to_thread.run_sync(request.reply, payload)
    except RequestRefused as refused:
        refuse(request, refused.code, refused.message)
    except Exception as error:
        log.exception("fault in %s", verb)
        refuse(request, LabResult.FAULT, f"fault in the {server}: {type(error).__name__}: {error}")
    except BaseException:
        refuse(request, ended, f"the {server} ends")
        raise


def refuse(request: Request, code: int, message: str) -> None:
    """Refuse a request; a failure is logged."""
    try:
        request.refuse(wire.encode(wire.Refusal(code=code, message=message)))
    except Exception:  # the client ended, or has a part of the reply
        log.exception("cannot refuse a request")
