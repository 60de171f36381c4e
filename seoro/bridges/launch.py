"""Simulator nodes of runs: started for one run, or connected to if they are running.

A started node listens on a socket file in a private folder, and ends with its parent process. Its loss is detected
from its process and from its liveliness token.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

import anyio
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream

from seoro.bridges import wire
from seoro.bridges.finding import find_node
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import Claim, connection_error, held
from seoro.bridges.session import AsyncSession, SessionError, open_session
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.concurrency.background import background
from seoro.errors import BackendError, BackendLost, BackendRefused, UsageError
from seoro.files.world_names import WorldName
from seoro.security.keys.roles import MOVING
from seoro.security.network.endpoint_keys import node_keys, security_of
from seoro.security.network.peers import node_signer

SIMULATORS = {"mujoco": "mujoco", "pybullet": "pybullet"}  # required module of each simulator
ENGINES = "seoro.engines"  # entry-point group of engines in other packages
PYBULLET_SOURCE = (3, 12)  # first version of Python without packages of PyBullet
# [s] for all users of simulators: at low priority on a busy machine, 1 s of processor time takes minutes.
# The end of the process is noticed at once.
START_TIMEOUT = 600.0
START = "start one with `seoro sim mujoco`"
MAX_FOLDER = 60  # [characters]; paths of sockets have at most 107
STOP_TIMEOUT = 2.0  # [s] time limit of a node to end; then it is killed
STDERR_TIMEOUT = 0.2  # [s] time limit to read the last lines of an ended process
STDERR_LINES = 20  # number of lines kept for messages


@dataclass(frozen=True)
class SimulatorOptions:
    """Options of a simulator for a run.

    Args:
        world: Name of the world, or path of a world file; None for the node's default.
        seed: Random seed.
        models: Search path of models to spawn.
        snapshot: Initial state, with its own world; None for the initial state of the world.
    """

    world: str | None
    seed: int
    models: ModelPath
    snapshot: wire.Snapshot | None = None


@asynccontextmanager
async def start_simulator(name: str, options: SimulatorOptions) -> AsyncIterator[SimulatorNode]:
    """Start a simulator node, and stop it when the block ends.

    Raises:
        UsageError: The simulator is unknown or not installed, or the world is unknown.
        BackendError: The node did not start.
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
    """Use a running simulator node. All effects of the run are removed when the block ends.

    Args:
        endpoint: Zenoh endpoint of the node, or of its router.
        options: Options of the run.
        name: Name of the node; None for the only one.
        purpose: Purpose of the hold, shown to other clients.
        claim: Claim of the simulator.

    Raises:
        RobotsBusy: Another client holds the simulator.
        BackendUnreachable: No simulator was found at the endpoint (yet).
        UsageError: The world is unknown.
    """
    keys = node_keys(endpoint, MOVING)
    security = security_of(endpoint, keys)
    holder = (claim or Claim()).request(purpose, sends_heartbeats=False)
    try:
        async with open_session(connect=endpoint, security=security) as session:
            node_name = await find_simulator(session, endpoint, name)
            signer = node_signer(session, node_name, keys)
            address = NodeAddress(session, wire.NAMESPACE, node_name, sender=holder.holder, signer=signer)
            await address.prove()
            async with await _lease_simulator(address, holder), _cleared(address, options) as node:
                yield node
    except SessionError as error:
        raise connection_error(
            endpoint, security, error, "start a simulator there with `seoro sim mujoco`"
        ) from error


async def _lease_simulator(address: NodeAddress, holder: wire.Holder) -> AbstractAsyncContextManager[object]:
    """Return a hold of all robots of a simulator. Simulators without leases need none."""
    try:
        await ask(address, wire.GET_ROBOT_FEATURES, wire.Empty())
    except BackendRefused as refused:
        if refused.code != wire.Result.FEATURE_UNSUPPORTED:
            raise
        return nullcontext()
    return held(address, holder)


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
    """Return the parent folder of sockets; None for the default, unless paths of sockets there are too long."""
    return None if len(tempfile.gettempdir()) < MAX_FOLDER else "/tmp"  # noqa: S108 - a folder of its own is made


def check_installed(name: str) -> None:
    """Check that a simulator is known and installed.

    Raises:
        UsageError: The simulator is unknown, or its engine is not installed.
    """
    if not is_known(name):
        raise UsageError(f"unknown simulator '{name}'", help=f"simulators: {', '.join(known_simulators())}")
    if not is_installed(name):
        raise UsageError(f"the simulator '{name}' is not installed", help=_how_to_install(name))


def is_known(name: str) -> bool:
    """Whether a simulator is seoro's own, or in an installed package; only the latter takes a search."""
    return name in SIMULATORS or name in known_simulators()


def known_simulators() -> tuple[str, ...]:
    """Return the names of seoro's own simulators, and of those in installed packages."""
    return (*SIMULATORS, *sorted(entry_points(group=ENGINES).names - SIMULATORS.keys()))


def is_installed(name: str) -> bool:
    """Whether the engine of a known simulator is installed."""
    return name not in SIMULATORS or find_spec(SIMULATORS[name]) is not None


def can_film() -> bool:
    """Whether started simulators can record videos."""
    return find_spec("av") is not None


def _how_to_install(name: str) -> str:
    if name == "pybullet" and sys.version_info >= PYBULLET_SOURCE:
        wanted = ".".join(map(str, PYBULLET_SOURCE))
        return (
            f"pip install 'seoro[pybullet]' with a Python older than {wanted}: PyBullet has no newer packages. "
            "Or pip install 'seoro[node]' pybullet with a C++ compiler"
        )
    return f"pip install 'seoro[{name}]'"


async def _open(address: NodeAddress, options: SimulatorOptions) -> SimulatorNode:
    """Load the world or restore the snapshot, so that every run starts from the same state."""
    features = await ask(address, wire.GET_SIMULATOR_FEATURES, wire.Empty())
    node = SimulatorNode(address, options.models, features)
    if options.snapshot is not None:
        try:
            await node.begin_from(options.snapshot, options.seed)
        except BackendRefused as error:
            raise UsageError(
                f"{node.name} cannot begin from the snapshot: {error}",
                help=f"it was made by {options.snapshot.engine} {options.snapshot.engine_version}",
            ) from error
        return node
    try:
        await node.load_world(options.world or "", options.seed)
    except BackendRefused as error:
        known = f"worlds of {node.name}: {', '.join(features.available_worlds) or 'not reported'}"
        if options.world:
            message = f"the world '{options.world}' cannot be loaded: {error}"
            is_named = not WorldName.parse(options.world).is_file  # errors of files contain the advice
            raise UsageError(message, help=known if is_named else "") from error
        raise UsageError(
            f"{node.name} cannot restart: {error}", help=f"`--world` loads a world instead; {known}"
        ) from error
    return node


# ---------------------------------------------------------------- processes


@dataclass(frozen=True)
class _LastLines:
    """Last lines of a process on stderr, and whether its output has ended."""

    lines: deque[str] = field(default_factory=lambda: deque(maxlen=STDERR_LINES))
    complete: anyio.Event = field(default_factory=anyio.Event)


@asynccontextmanager
async def _process(command: list[str]) -> AsyncIterator[tuple[Process, _LastLines]]:
    """Run a process in its own session, so that Ctrl-C in the terminal reaches the parent only."""
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
    """End a process by closing its input, or kill it."""
    assert process.stdin is not None
    if process.returncode is None:
        with suppress(anyio.BrokenResourceError, anyio.ClosedResourceError):
            await process.stdin.send(b"\n")  # shows that the parent is alive
        await process.stdin.aclose()
        with anyio.move_on_after(STOP_TIMEOUT):
            await process.wait()
    if process.returncode is None:
        process.kill()
        await process.wait()
    await process.aclose()


async def _describe_exit(process: Process, errors: _LastLines) -> str:
    """Describe the end of a process, with its last line."""
    with anyio.move_on_after(STDERR_TIMEOUT):  # a child process may keep stderr open
        await errors.complete.wait()
    code = process.returncode
    how = f"killed by {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit status {code}"
    return f"{how}: {errors.lines[-1]}" if errors.lines else how


# ---------------------------------------------------------------- start and loss


async def _await_start(address: NodeAddress, process: Process, errors: _LastLines) -> None:
    """Wait until the node serves.

    Raises:
        BackendError: The node ended, or did not start in time.
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
        end = await _describe_exit(process, errors)
        raise BackendLost(f"the simulator node '{address.node}' did not start ({end})")
    raise BackendError(f"the simulator node '{address.node}' did not start within {START_TIMEOUT:g} s")


async def find_simulator(session: AsyncSession, endpoint: str, name: str | None = None) -> str:
    """Return the name of the simulator node that a session reaches; see `find_node`."""
    return await find_node(session, endpoint, name, "simulator node", START)


async def _watch_process(process: Process, node: SimulatorNode, errors: _LastLines) -> None:
    await process.wait()
    end = await _describe_exit(process, errors)
    node.report_loss(BackendLost(f"{node.name} died during the run ({end})"))


async def _watch_token(address: NodeAddress, node: SimulatorNode) -> None:
    async with address.session.tokens(wire.node_tokens(address.namespace)) as tokens:
        async for token, alive in tokens:
            if not alive and wire.token_node(token)[0] == address.node:
                # `_watch_process` reports a more detailed reason first.
                await anyio.sleep(0.2)
                node.report_loss(BackendLost(f"the connection to {node.name} was lost"))
