"""Emergency stop at one endpoint, by several connections.

It is sent twice. It is published on one key, which reaches all connected nodes even during long work. It is also
sent as a request to each live node and executor, which acknowledge it.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from contextlib import AsyncExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from seoro.bridges import wire
from seoro.bridges.session import SessionError, is_secured, publishing
from seoro.concurrency.gathering import gather
from seoro.errors import UsageError
from seoro.lab.outcomes import OnOutcome, Outcome, request_outcome
from seoro.lab.status import Connection, connect_endpoint, members_at
from seoro.security.keys.roles import MOVING

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

CONNECTIONS = 3  # to an endpoint, to send an emergency stop
STAGGER = 0.1  # [s] between the starts of connections


async def stop_endpoint(
    endpoint: str, request: wire.EmergencyStop, folder: Path | None, began: float, on_outcome: OnOutcome
) -> list[Outcome]:
    """Send a stop to all members at an endpoint; if one does not confirm, send it again.

    Args:
        endpoint: The endpoint.
        request: The stop.
        folder: Folder of keys, as in `connect_members`.
        began: Start of the stop, by the monotonic clock [s].
        on_outcome: Called with each outcome as it arrives; those of repetitions, too.
    """
    send = partial(_stop_at, endpoint, request, folder, began, on_outcome)
    outcomes = await _first_success(send)
    # On a busy machine, connections may fail, and goals may end a little later.
    return await send() if _has_errors(outcomes) else outcomes


def _has_errors(outcomes: Sequence[Outcome]) -> bool:
    return any(each.error and not each.is_elsewhere for each in outcomes)


async def _first_success(send: Callable[[], Awaitable[list[Outcome]]]) -> list[Outcome]:
    """Send a stop over several connections, started one after another; the first success counts.

    At an endpoint that is flooded with requests, one of some dozen connections takes a second.

    Returns:
        Outcomes of the first successful connection, else of the last one.
    """
    found: list[Outcome] = []

    async def attempt(after: float, over: anyio.CancelScope) -> None:
        nonlocal found
        await anyio.sleep(after)
        outcomes = await send()
        if not found or _has_errors(found):
            found = outcomes
        if not _has_errors(outcomes):
            over.cancel()

    async with anyio.create_task_group() as tasks:
        for number in range(CONNECTIONS):
            tasks.start_soon(attempt, number * STAGGER, tasks.cancel_scope)
    return found


async def _stop_at(
    endpoint: str, request: wire.EmergencyStop, folder: Path | None, began: float, on_outcome: OnOutcome
) -> list[Outcome]:
    key, payload = wire.emergency_key(wire.NAMESPACE), wire.encode(request)
    try:
        async with AsyncExitStack() as stack:
            session, keys = await stack.enter_async_context(connect_endpoint(endpoint, folder, is_repeated=True))
            own = keys if is_secured(endpoint) else None
            if own is None or own.identity.role in MOVING:  # for others, the request is refused
                publisher = await stack.enter_async_context(publishing(session, key, is_urgent=True))
                publisher.put(payload, _signature(own, key, payload))
            members = await members_at(endpoint, session, keys)
            if request.robots:  # executors have no robots
                members = [each for each in members if not each.member.is_executor]

            async def stop(each: Connection) -> Outcome:
                outcome = await request_outcome(each, wire.EMERGENCY_STOP, request, began)
                on_outcome(outcome)
                return outcome

            return await gather(stop, members)
    except (SessionError, UsageError) as error:
        unreached = Outcome(endpoint, endpoint, error=str(error), is_reached=False)
        on_outcome(unreached)
        return [unreached]


def _signature(keys: Keys | None, key: str, payload: bytes) -> bytes | None:
    if keys is None:
        return None
    from seoro.security.signing.commands import sign_emergency_stop  # noqa: PLC0415 - only where there are keys

    return sign_emergency_stop(keys, key, payload)
