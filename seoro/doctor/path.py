"""The way to an executor: a session, the executor, its version, clock, latency and disk, and what is beside it.

Each hop is looked at only if the one before works: what is behind one that does not cannot be known.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro import __version__
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.executor.clocks import describe
from seoro.bridges.executor.finding import find_executor, find_executors
from seoro.bridges.secured import CLIENTS, check_reached, keys_for, security_of
from seoro.bridges.session import AsyncSession, Security, SessionError, is_secured, open_session
from seoro.bridges.wire.keys import NAMESPACE, node_tokens, token_node
from seoro.bridges.wire.message import Empty
from seoro.doctor.endpoint import look_at_endpoint
from seoro.doctor.findings import Finding, Health, failed, ok, warning
from seoro.doctor.installed import in_bytes
from seoro.errors import BackendError, InvalidUse

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

EXCHANGES: Final = 100  # for the latency
SLOW: Final = 0.1  # [s] of a round trip that people notice
LITTLE: Final = 1 << 30  # [bytes] of free disk
TIMEOUT: Final = 2.0  # [s] for tokens


async def look_along(endpoint: str, name: str | None, keys: Path | None = None) -> AsyncIterator[Finding]:
    """Look at one hop after another.

    Args:
        endpoint: Where executors are reached.
        name: Of the executor; None for all that are there.
        keys: Folder of keys, as for commands.
    """
    there = await look_at_endpoint(endpoint)
    yield there
    if there.health is Health.FAILED:
        return
    try:
        own = keys_for(endpoint, CLIENTS, keys)
        security = security_of(endpoint, own)
    except InvalidUse as error:
        yield failed("keys", str(error), error.help or "")
        return
    yield ok("keys", "none are needed on this machine" if own is None else f"of {own.identity}")
    try:
        async with open_session(connect=endpoint, security=security) as session:
            yield ok("session", f"Zenoh answers at {endpoint}")
            async for finding in _look_behind(session, name, own, is_secured=is_secured(endpoint)):
                yield finding
    except SessionError as error:
        yield _no_session(endpoint, error, security)


def _no_session(endpoint: str, error: SessionError, security: Security | None) -> Finding:
    try:
        check_reached(endpoint, security)
    except InvalidUse as why:
        return failed("session", str(why), why.help or "")
    return failed(
        "session",
        f"something listens at {endpoint}, but it does not speak Zenoh with us: {error}",
        "check that an executor or a router of seoro listens there, and not another program; one that stands "
        "still (`kill -STOP`, a debugger) answers nobody",
    )


async def _look_behind(
    session: AsyncSession, name: str | None, keys: Keys | None, *, is_secured: bool
) -> AsyncIterator[Finding]:
    try:
        if name is None:
            executors = await find_executors(session, keys, is_secured=is_secured)
        else:
            executors = [await find_executor(session, name, keys, is_secured=is_secured)]
    except InvalidUse as error:
        yield failed("executor", str(error), error.help or "")
        return
    if not executors:
        yield failed("executor", "there is none behind this endpoint", "start one with `seoro serve`")
    for executor in executors:
        executor.patience = 0.0
        async for finding in _look_at(executor):
            yield finding
    for node in sorted(
        {token_node(token)[0] for token in await session.list_tokens(node_tokens(NAMESPACE), TIMEOUT)}
    ):
        yield ok("node", f"'{node}', a simulator or bridge, is connected there")


async def _look_at(executor: Executor) -> AsyncIterator[Finding]:
    what = executor.name
    try:
        info, clock = await describe(executor)
        times = [await _round_trip(executor) for _ in range(EXCHANGES)]
    except BackendError as error:
        advice = "if it stands still, end it with `kill -9` and start it again: it goes on with its queue"
        yield failed(what, str(error), advice)
        return
    yield _compare(what, info)
    yield ok(what, f"lets us ask; {info.running} runs go on, {info.jobs} at a time, and {info.waiting} wait")
    if clock is None:
        yield warning(what, "does not tell its clock", "it is older than this seoro: renew it")
    elif clock.is_wrong:
        yield warning(what, f"its clock is {clock}", "have both machines set their clocks by NTP")
    else:
        yield ok(what, f"its clock is {clock}, give or take {1000.0 * clock.round_trip / 2.0:.1f} ms")
    yield _latency(what, sorted(times))
    if info.free is not None:
        free = f"has {in_bytes(info.free)} of disk left for runs"
        yield ok(what, free) if info.free > LITTLE else warning(what, free, "`seoro rm` forgets runs")
    if info.simulators:
        yield ok(what, f"has the simulators {', '.join(info.simulators)}")
    elif info.simulators is not None:
        yield warning(what, "has no simulators", "install `seoro[mujoco]` there, if runs need one")


def _compare(what: str, info: wire.ExecutorInfo) -> Finding:
    if info.version == __version__:
        return ok(what, f"is of seoro {info.version}, as this is")
    return warning(
        what, f"is of seoro {info.version}, and this is {__version__}", "use the same version on both sides"
    )


async def _round_trip(executor: Executor) -> float:
    began = time.perf_counter()
    await executor.ask(wire.DESCRIBE, Empty())
    took = time.perf_counter() - began
    await anyio.sleep(0.0)
    return took


def _latency(what: str, times: list[float]) -> Finding:
    half, most = times[len(times) // 2], times[int(0.99 * len(times))]
    text = f"answers in {1000.0 * half:.1f} ms (p50), {1000.0 * most:.1f} ms (p99 of {len(times)})"
    return ok(what, text) if most < SLOW else warning(what, text, "the network or the machine is slow or busy")
