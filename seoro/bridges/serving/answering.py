"""Answering requests: each gets exactly one answer, whatever happens."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from typing import Any, Final

import anyio.to_thread

from seoro.bridges import wire
from seoro.bridges.session import Request
from seoro.bridges.wire import LabResult, Result
from seoro.bridges.wire.keys import verb_of
from seoro.bridges.wire.refusal import RequestRefused

AT_ONCE: Final = 1 << 16  # [bytes] that are sent without waiting for one who takes nothing

log = logging.getLogger(__name__)


async def answer(
    request: Request,
    carry_out: Callable[[str, bytes], Awaitable[wire.Message]],
    called: str,
    ended: int = Result.OPERATION_FAILED,
) -> None:
    """Carry out a request and answer it.

    Args:
        request: The request, whose key ends with its verb.
        carry_out: Gets verb and payload, and returns what to answer or raises `RequestRefused`.
        called: What messages call whoever serves it, such as `bridge`.
        ended: The code of the refusal when that ends before there is an answer.
    """
    verb = verb_of(request.key)
    try:
        payload = wire.encode(await carry_out(verb, request.payload))
        if len(payload) <= AT_ONCE:
            request.reply(payload)
        else:
            await anyio.to_thread.run_sync(request.reply, payload)
    except RequestRefused as refused:
        refuse(request, refused.code, refused.message)
    except Exception as error:
        log.exception("fault in %s", verb)
        refuse(request, LabResult.FAULT, f"fault in the {called}: {type(error).__name__}: {error}")
    except BaseException:
        refuse(request, ended, f"the {called} ends")
        raise


def decoded(verb: wire.Verb[Any, Any], payload: bytes) -> Any:
    """What a request says.

    Raises:
        RequestRefused: It is none of that verb.
    """
    try:
        return verb.read(payload)
    except wire.WireError as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


def refuse(request: Request, code: int, message: str) -> None:
    """Refuse a request; one that cannot be answered is logged."""
    try:
        request.refuse(wire.encode(wire.Refusal(code=code, message=message)))
    except Exception:  # whoever asked is gone, or was answered in part
        log.exception("cannot refuse a request")
