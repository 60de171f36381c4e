"""Getting at simulator nodes: one started for a run and stopped after it, or one that is running already.

A node that is started here is reached over a socket file in a folder of its own, which nobody else can open. It
is told to die with its parent, so that no path leaves it behind, and its death is noticed by the end of the
process and of its liveliness token, whichever comes first.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

import anyio
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.finding import find_node
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import Claim, held, not_reached
from seoro.bridges.seals import node_seals
from seoro.bridges.secured import node_keys, security_of
from seoro.bridges.session import AsyncSession, SessionError, open_session
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendError, BackendLost, BackendRefused, InvalidUse
from seoro.keys.roles import MOVING

SIMULATORS = {"mujoco": "mujoco", "pybullet": "pybullet"}  # name, and the module its engine needs
ENGINES = "seoro.engines"  # the group of entry points by which packages bring engines of others
PYBULLET_SOURCE = (3, 12)  # the first version of Python for which PyBullet has to be compiled
START_TIMEOUT = 30.0  # [s]
START = "start one with `seoro sim mujoco`"
MAX_FOLDER = 60  # [characters]; of 107 that the name of a socket has at most
STOP_TIMEOUT = 2.0  # [s]; after this a node is killed
LAST_WORDS = 0.2  # [s] that the last lines of a process that has ended may take to arrive
STDERR_LINES = 20  # kept for messages


@dataclass(frozen=True)
class SimulatorOptions:
    """What a run wants of its simulator.

    Args:
        world: Name of the world, or path of a world file; None for the node's own choice.
        seed: For everything the node draws.
        models: Where models to spawn are looked up.
        snapshot: The state to begin at, which has a world of its own; None for the initial state of the world.
    """

    world: str | None
    seed: int
    models: ModelPath
    snapshot: wire.Snapshot | None = None


@asynccontextmanager
async def start_simulator(name: str, options: SimulatorOptions) -> AsyncIterator[SimulatorNode]:
    """Start a simulator node, and stop it when the block ends.

    Raises:
        InvalidUse: There is no such simulator, it is not installed, or it does not know the world.
        BackendError: It did not start.
    """
    check_installed(name)
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as folder:
        endpoint = f"unixsock-stream/{Path(folder) / 'hub.sock'}"
        async with open_session(listen=endpoint) as session:
            command = [sys.executable, "-m", "sim_nodes", name, "--connect", endpoint, "--node", name]
            command += ["--namespace", wire.NAMESPACE, "--die-with-parent", "--folder", folder]
            async with (
                _process(command) as (process, errors),
                background() as group,
            ):
                address = NodeAddress(session, wire.NAMESPACE, name)
                await _await_start(address, process, errors)
                node = await _open(address, options)
                group.start_soon(_watch_process, process, node, errors)
                group.start_soon(_watch_token, address, node)
                yield node


@asynccontextmanager
async def connect_simulator(
    endpoint: str,
    options: SimulatorOptions,
    name: str | None = None,
    purpose: str = "a run",
    claim: Claim | None = None,
) -> AsyncIterator[SimulatorNode]:
    """Have a simulator node that is running; it goes on when the block ends, without anything of the run.

    Args:
        endpoint: Zenoh endpoint of the node, or of the router that it is connected to.
        options: What the run wants of it.
        name: Of the node; None for the only one there.
        purpose: What it is held for, for others who want it.
        claim: By what it is claimed.

    Raises:
        RobotsTaken: Others have it.
        BackendUnreachable: There is none at the endpoint (yet).
        InvalidUse: It does not know the world.
    """
    keys = node_keys(endpoint, MOVING)
    security = security_of(endpoint, keys)
    holder = (claim or Claim()).of(purpose, gives_signs=False)
    try:
        async with open_session(connect=endpoint, security=security) as session:
            node_name = await find_simulator(session, endpoint, name)
            seals = node_seals(session, node_name, keys)
            address = NodeAddress(session, wire.NAMESPACE, node_name, sender=holder.holder, seals=seals)
            await address.prove()
            async with _all_of(address, holder), _cleared(address, options) as node:
                yield node
    except SessionError as error:
        raise not_reached(endpoint, security, error, "start a simulator there with `seoro sim mujoco`") from error


@asynccontextmanager
async def _all_of(address: NodeAddress, holder: wire.Holder) -> AsyncIterator[None]:
    """Hold a simulator with all that it has; one that knows nothing of holders is had by whoever asks."""
    async with held(address, holder) if await _has_holders(address) else nullcontext():
        yield


async def _has_holders(address: NodeAddress) -> bool:
    try:
        await ask(address, wire.GET_ROBOT_FEATURES, wire.Empty())
    except BackendRefused as refused:
        if refused.code == wire.Result.FEATURE_UNSUPPORTED:
            return False
        raise
    return True


@asynccontextmanager
async def _cleared(address: NodeAddress, options: SimulatorOptions) -> AsyncIterator[SimulatorNode]:
    node = await _open(address, options)
    async with background() as group:
        group.start_soon(_watch_token, address, node)
        try:
            yield node
        finally:
            with anyio.move_on_after(STOP_TIMEOUT, shield=True), suppress(BackendError):
                await node.clear()


def folder_for_sockets() -> str | None:
    """The folder for temporary files, unless the name of a socket in it would be longer than sockets may have."""
    return None if len(tempfile.gettempdir()) < MAX_FOLDER else "/tmp"  # noqa: S108 - a folder of its own is made


def check_installed(name: str) -> None:
    """Check that a simulator can be started.

    Raises:
        InvalidUse: There is none of that name, or its engine is not installed.
    """
    if name not in (known := known_simulators()):
        raise InvalidUse(f"there is no simulator '{name}'", help=f"simulators: {', '.join(known)}")
    if not is_installed(name):
        raise InvalidUse(f"the simulator '{name}' is not installed", help=_how_to_install(name))


def known_simulators() -> tuple[str, ...]:
    """Names of the simulators that there are: ours, and those that installed packages bring."""
    return (*SIMULATORS, *sorted(entry_points(group=ENGINES).names - SIMULATORS.keys()))


def is_installed(name: str) -> bool:
    """Whether a known simulator has its engine here."""
    return name not in SIMULATORS or find_spec(SIMULATORS[name]) is not None


def can_film() -> bool:
    """Whether simulators that are started here can be filmed."""
    return find_spec("av") is not None


def _how_to_install(name: str) -> str:
    if name == "pybullet" and sys.version_info >= PYBULLET_SOURCE:
        wanted = ".".join(map(str, PYBULLET_SOURCE))
        return (
            f"use a Python older than {wanted} and pip install 'seoro[pybullet]': PyBullet has no packages for "
            "newer ones; where there is a C++ compiler, pip install 'seoro[node]' pybullet builds it in minutes"
        )
    return f"pip install 'seoro[{name}]'"


async def _open(address: NodeAddress, options: SimulatorOptions) -> SimulatorNode:
    """Load the world or restore the snapshot, so that every run begins at the same state."""
    features = await ask(address, wire.GET_SIMULATOR_FEATURES, wire.Empty())
    node = SimulatorNode(address, options.models, features)
    if options.snapshot is not None:
        try:
            await node.begin_from(options.snapshot, options.seed)
        except BackendRefused as error:
            raise InvalidUse(
                f"{node.name} cannot begin from the snapshot: {error}",
                help=f"it was made by {options.snapshot.engine} {options.snapshot.engine_version}",
            ) from error
        return node
    try:
        await node.load_world(options.world or "", options.seed)
    except BackendRefused as error:
        known = f"worlds of {node.name}: {', '.join(features.available_worlds) or 'not told'}"
        if options.world:
            message = f"the world '{options.world}' cannot be loaded: {error}"
            is_named = not options.world.endswith((".yaml", ".yml"))  # else a file, and its error says what to do
            raise InvalidUse(message, help=known if is_named else "") from error
        raise InvalidUse(
            f"{node.name} cannot start over: {error}", help=f"`--world` loads a world instead; {known}"
        ) from error
    return node


# ---------------------------------------------------------------- processes


@dataclass(frozen=True)
class _LastLines:
    """The last lines that a process wrote to stderr, and whether that is all."""

    lines: deque[str] = field(default_factory=lambda: deque(maxlen=STDERR_LINES))
    complete: anyio.Event = field(default_factory=anyio.Event)


@asynccontextmanager
async def _process(command: list[str]) -> AsyncIterator[tuple[Process, _LastLines]]:
    """A process in a session of its own, so that a Ctrl-C in the terminal is for the parent alone."""
    errors = _LastLines()
    process = await anyio.open_process(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )
    async with background() as group:
        group.start_soon(_keep_last_lines, process, errors)
        try:
            yield process, errors
        finally:
            with anyio.CancelScope(shield=True):
                await _stop(process)


async def _keep_last_lines(process: Process, errors: _LastLines) -> None:
    assert process.stderr is not None
    rest = ""
    async for text in TextReceiveStream(process.stderr, errors="replace"):
        *whole, rest = (rest + text).split("\n")
        errors.lines.extend(line for line in whole if line.strip())
    errors.complete.set()


async def _stop(process: Process) -> None:
    """Close its input, which ends it; then the hard way."""
    assert process.stdin is not None
    if process.returncode is None:
        with suppress(anyio.BrokenResourceError, anyio.ClosedResourceError):
            await process.stdin.send(b"\n")  # so that it knows that its parent lives
        await process.stdin.aclose()
        with anyio.move_on_after(STOP_TIMEOUT):
            await process.wait()
    if process.returncode is None:
        process.kill()
        await process.wait()
    await process.aclose()


async def _last_words(process: Process, errors: _LastLines) -> str:
    """How a process ended, for people."""
    with anyio.move_on_after(LAST_WORDS):  # something that it started may hold its stderr open
        await errors.complete.wait()
    code = process.returncode
    how = f"killed by {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit status {code}"
    return f"{how}: {errors.lines[-1]}" if errors.lines else how


# ---------------------------------------------------------------- life and death


async def _await_start(address: NodeAddress, process: Process, errors: _LastLines) -> None:
    """Wait until the node serves.

    Raises:
        BackendError: It ended before, or takes too long.
    """
    async with (
        address.session.tokens(wire.node_tokens(address.namespace)) as tokens,
        anyio.create_task_group() as group,
    ):

        async def ended() -> None:
            await process.wait()
            group.cancel_scope.cancel()

        group.start_soon(ended)
        with anyio.move_on_after(START_TIMEOUT):
            async for _token, alive in tokens:
                if alive:
                    group.cancel_scope.cancel()
                    return
        group.cancel_scope.cancel()
    if process.returncode is not None:
        words = await _last_words(process, errors)
        raise BackendLost(f"the simulator node '{address.node}' did not start ({words})")
    raise BackendError(f"the simulator node '{address.node}' did not start within {START_TIMEOUT:g} s")


async def find_simulator(session: AsyncSession, endpoint: str, name: str | None = None) -> str:
    """The name of the simulator node that is reached by a session; see `find_node`."""
    return await find_node(session, endpoint, name, "simulator node", START)


async def _watch_process(process: Process, node: SimulatorNode, errors: _LastLines) -> None:
    await process.wait()
    said = await _last_words(process, errors)
    node.report_loss(BackendLost(f"{node.name} died in the middle of the run ({said})"))


async def _watch_token(address: NodeAddress, node: SimulatorNode) -> None:
    async with address.session.tokens(wire.node_tokens(address.namespace)) as tokens:
        async for token, alive in tokens:
            if not alive and wire.token_node(token)[0] == address.node:
                # The end of a process that was started here tells more; let it be first.
                await anyio.sleep(0.2)
                node.report_loss(BackendLost(f"{node.name} is gone: the connection to it was lost"))
