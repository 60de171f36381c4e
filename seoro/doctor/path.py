"""Checks of the path to executors: session, executor, version, clock, latency, disk, and nodes beside it.

Each hop is checked only if the one before works.
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
from seoro.bridges.executor.finding import find_executor, find_executors, start_hint
from seoro.bridges.executor.probing import EndpointReport
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bridges.wire.keys import MAJOR
from seoro.bridges.wire.message import Empty
from seoro.doctor.endpoint import check_endpoint
from seoro.doctor.findings import Finding, Health, failed, ok, warning
from seoro.doctor.installation import SANDBOX, in_bytes
from seoro.doctor.lab import HERE, NOWHERE, Places, check_from_executor
from seoro.doctor.nodes import place_findings
from seoro.doctor.peers import RELEASE, clock_finding, latency_finding, version_finding
from seoro.errors import BackendError, UsageError
from seoro.lab.probes import EXCHANGES, client_identity, explain_unreached, probe_nodes, quantiles
from seoro.security.network.endpoint_keys import CLIENTS, keys_for, security_of

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

LITTLE: Final = 1 << 30  # [bytes] of free disk


async def check_path_to_executors(
    endpoint: str, name: str | None, keys: Path | None = None, places: Places = NOWHERE
) -> AsyncIterator[Finding]:
    """Check one hop after another.

    Args:
        endpoint: Zenoh endpoint of executors.
        name: Name of the executor; None for all.
        keys: Folder of keys.
        places: Lab whose paths from the executors are checked.
    """
    there = await check_endpoint(endpoint)
    yield there
    if there.health is Health.FAILED:
        return
    try:
        own = keys_for(endpoint, CLIENTS, keys)
        security = security_of(endpoint, own)
    except UsageError as error:
        yield failed("keys", str(error), error.help or "")
        return
    yield ok("keys", "not needed on this machine" if own is None else f"of {own.identity}")
    try:
        async with open_session(connect=endpoint, security=security) as session:
            yield ok("session", f"Zenoh answers at {endpoint}")
            async for finding in _check_session(session, endpoint, name, own, places):
                yield finding
    except SessionError as error:
        yield failed("session", *explain_unreached(endpoint, error, security))


async def _check_session(
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
            yield failed("executor", "none found", start_hint("seoro serve", has_keys))
    except UsageError as error:
        yield failed("executor", str(error), error.help)
    for executor in executors:
        executor.patience = 0.0
        async for finding in _check_executor(executor, keys):
            yield finding
    names = places.names(endpoint)
    nodes = await probe_nodes(session, endpoint, keys, names)
    if nodes or endpoint in places.endpoints:
        seen = EndpointReport(endpoint=endpoint, who=client_identity(endpoint, keys), nodes=nodes)
        for finding in place_findings(seen, places.wanted(endpoint), names, HERE):
            yield finding
    for executor in executors:
        async for finding in check_from_executor(executor, places):
            yield finding


async def _check_executor(executor: Executor, keys: Keys | None) -> AsyncIterator[Finding]:
    what = executor.name
    try:
        info, clock = await describe(executor)
        times = [await _round_trip(executor) for _ in range(EXCHANGES)]
    except BackendError as error:
        advice = "if it hangs, end it with `kill -9` and restart it: it keeps its queue"
        yield failed(what, str(error), advice)
        return
    theirs = info.version, f"{MAJOR}.{executor.minor}"
    yield version_finding(what, "", theirs, f"{MAJOR}.{wire.MINOR}")
    yield ok(what, f"{_rights(keys)}; {info.running} active runs ({info.jobs} at a time), {info.waiting} queued")
    if info.stopped:
        yield failed(what, f"starts no runs: {info.stopped}", RELEASE)
    yield clock_finding(what, clock)
    yield latency_finding(what, *quantiles(times), len(times))
    if info.free is not None:
        free = f"{in_bytes(info.free)} of disk left for runs"
        yield ok(what, free) if info.free > LITTLE else warning(what, free, "`seoro rm` deletes runs")
    if info.no_sandbox:
        yield warning(what, f"does not sandbox runs: {info.no_sandbox}", SANDBOX)
    elif info.no_sandbox is not None:
        yield ok(what, "sandboxes runs")
    if info.simulators:
        yield ok(what, f"simulators: {', '.join(info.simulators)}")
    elif info.simulators is not None:
        yield warning(what, "no simulators", "install `seoro[mujoco]` there, if runs need one")


def _rights(keys: Keys | None) -> str:
    """Describe our permissions at an executor."""
    if keys is None:
        return "we can submit runs"
    if keys.identity.role.includes(wire.SUBMIT.role):
        return f"we ({keys.identity}) can submit runs"
    return f"we ({keys.identity}) can query it; only operators can submit runs"


async def _round_trip(executor: Executor) -> float:
    began = time.perf_counter()
    await executor.ask(wire.DESCRIBE, Empty())
    took = time.perf_counter() - began
    await anyio.sleep(0.0)
    return took
