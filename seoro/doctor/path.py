"""The way to an executor: a session, the executor, its version, clock, latency and disk, and what is beside it.

Each hop is looked at only if the one before works: what is behind one that does not cannot be known.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.executor.clocks import describe
from seoro.bridges.executor.finding import find_executor, find_executors, how_to_see_some
from seoro.bridges.executor.sight import PlaceSeen
from seoro.bridges.secured import CLIENTS, keys_for, security_of
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bridges.wire.keys import MAJOR
from seoro.bridges.wire.message import Empty
from seoro.doctor.endpoint import look_at_endpoint
from seoro.doctor.findings import Finding, Health, failed, ok, warning
from seoro.doctor.installed import SANDBOX, in_bytes
from seoro.doctor.lab import HERE, NOWHERE, Places, look_from
from seoro.doctor.measured import RELEASE, tell_clock, tell_latency, tell_version
from seoro.doctor.nodes import tell_place
from seoro.errors import BackendError, InvalidUse
from seoro.keys.roles import executor_verbs
from seoro.lab.examining import EXCHANGES, examine_nodes, quantiles, who_asks, why_unreached

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

LITTLE: Final = 1 << 30  # [bytes] of free disk


async def look_along(
    endpoint: str, name: str | None, keys: Path | None = None, places: Places = NOWHERE
) -> AsyncIterator[Finding]:
    """Look at one hop after another.

    Args:
        endpoint: Where executors are reached.
        name: Of the executor; None for all that are there.
        keys: Folder of keys, as for commands.
        places: Of a lab, at which executors are asked to look.
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
            async for finding in _look_behind(session, endpoint, name, own, places):
                yield finding
    except SessionError as error:
        yield failed("session", *why_unreached(endpoint, error, security))


async def _look_behind(
    session: AsyncSession, endpoint: str, name: str | None, keys: Keys | None, places: Places
) -> AsyncIterator[Finding]:
    has_keys = is_secured(endpoint)
    executors: list[Executor] = []
    try:
        if name is None:
            executors = await find_executors(session, keys, is_secured=has_keys)
        else:
            executors = [await find_executor(session, name, keys, is_secured=has_keys)]
        if not executors:
            yield failed("executor", "none is seen there", how_to_see_some("seoro serve", has_keys))
    except InvalidUse as error:
        yield failed("executor", str(error), error.help)
    for executor in executors:
        executor.patience = 0.0
        async for finding in _look_at(executor, keys):
            yield finding
    names = places.names(endpoint)
    nodes = await examine_nodes(session, endpoint, keys, names)
    if nodes or endpoint in places.endpoints:
        seen = PlaceSeen(endpoint=endpoint, who=who_asks(endpoint, keys), nodes=nodes)
        for finding in tell_place(seen, places.wanted(endpoint), names, HERE):
            yield finding
    for executor in executors:
        async for finding in look_from(executor, places):
            yield finding


async def _look_at(executor: Executor, keys: Keys | None) -> AsyncIterator[Finding]:
    what = executor.name
    try:
        info, clock = await describe(executor)
        times = [await _round_trip(executor) for _ in range(EXCHANGES)]
    except BackendError as error:
        advice = "if it stands still, end it with `kill -9` and start it again: it goes on with its queue"
        yield failed(what, str(error), advice)
        return
    theirs = info.version, f"{MAJOR}.{executor.minor}"
    yield tell_version(what, "", theirs, f"{MAJOR}.{wire.MINOR}")
    yield ok(what, f"{_rights(keys)}; {info.running} runs go on, {info.jobs} at a time, and {info.waiting} wait")
    if info.stopped:
        yield failed(what, f"begins no runs: {info.stopped}", RELEASE)
    yield tell_clock(what, clock)
    yield tell_latency(what, *quantiles(times), len(times))
    if info.free is not None:
        free = f"has {in_bytes(info.free)} of disk left for runs"
        yield ok(what, free) if info.free > LITTLE else warning(what, free, "`seoro rm` forgets runs")
    if info.no_sandbox:
        yield warning(what, f"does not sandbox runs: {info.no_sandbox}", SANDBOX)
    elif info.no_sandbox is not None:
        yield ok(what, "sandboxes runs")
    if info.simulators:
        yield ok(what, f"has the simulators {', '.join(info.simulators)}")
    elif info.simulators is not None:
        yield warning(what, "has no simulators", "install `seoro[mujoco]` there, if runs need one")


def _rights(keys: Keys | None) -> str:
    """What an executor lets us do, in words."""
    if keys is None:
        return "lets us submit runs"
    if wire.SUBMIT.name in executor_verbs(keys.identity.role):
        return f"lets us, {keys.identity}, submit runs"
    return f"lets us, {keys.identity}, look; submitting runs is for operators"


async def _round_trip(executor: Executor) -> float:
    began = time.perf_counter()
    await executor.ask(wire.DESCRIBE, Empty())
    took = time.perf_counter() - began
    await anyio.sleep(0.0)
    return took
