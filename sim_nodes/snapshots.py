"""Snapshots: the state of a simulation as a message, and its restoration.

A snapshot includes the world, so that nodes without its files can continue. A state is valid only for the same
engine, its version, and the same version of seoro.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from hashlib import blake2b
from pathlib import Path
from time import monotonic
from typing import Any

from seoro import __version__
from seoro.bridges.wire import BYTES, SNAPSHOT_FORMAT, Purpose, Result, Snapshot, WireError, decode
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.deferred import dataclass
from seoro.files.inputs import Kind, read_input
from sim_nodes.codec import CodecError, deep_copy, pack, unpack
from sim_nodes.outcomes import feature_unsupported, operation_failed
from sim_nodes.physics import Engine, Rewinds, SavesState, UnsavableState, UnstablePhysics
from sim_nodes.simulation import Simulation
from sim_nodes.stateful import State
from sim_nodes.tracks import Mark
from sim_nodes.worlds.loader import World

MAX_STATE = 256 * 1024 * 1024  # [bytes] uncompressed
COMPRESSION = 1  # zlib's fastest level shrinks maps with few obstacles to a few percent


@dataclass(frozen=True)
class Contents:
    """Contents of a snapshot."""

    world: World
    seed: int
    engine: Any
    simulation: State


def take(simulation: Simulation) -> Snapshot:
    """Take a snapshot of a simulation, which is unchanged.

    Raises:
        RequestRefused: The engine does not save states, or the state is too large.
    """
    engine = _saving(simulation.engine)
    try:
        packed = pack(Contents(simulation.world, simulation.seed, dict(engine.save()), simulation.save()))
    except (UnsavableState, CodecError) as error:
        raise operation_failed(f"cannot save the state: {error}") from error
    if len(packed) > MAX_STATE:
        raise operation_failed(f"the state has {len(packed)} bytes; expected at most {MAX_STATE}")
    state = zlib.compress(packed, COMPRESSION)
    return Snapshot(
        format=SNAPSHOT_FORMAT,
        version=__version__,
        engine=simulation.engine.name,
        engine_version=simulation.engine.version,
        world=simulation.world.name,
        seed=simulation.seed,
        time=simulation.time,
        state=state,
        digest=_digest(state),
    )


def read(path: Path) -> Snapshot:
    """Read a snapshot from a file.

    Raises:
        RequestRefused: The file is unreadable or invalid.
    """
    try:
        return decode(Snapshot, read_input(path, Kind.SNAPSHOT), BYTES)
    except OSError as error:
        raise RequestRefused(Result.NOT_FOUND, f"cannot read {path}: {error.strerror}") from error
    except WireError as error:
        raise operation_failed(f"invalid snapshot: {path}") from error


def check(snapshot: Snapshot, engine: Engine) -> Contents:
    """Return the contents of a snapshot that matches an engine; changes nothing.

    Raises:
        RequestRefused: The snapshot is of another engine or version, or damaged.
    """
    _saving(engine)
    for item, needed, present in (
        ("format", snapshot.format, SNAPSHOT_FORMAT),
        ("engine", snapshot.engine, engine.name),
        (f"version of {engine.name}", snapshot.engine_version, engine.version),
        ("version of seoro", snapshot.version, __version__),
    ):
        if needed != present:
            raise operation_failed(f"the snapshot requires the {item} {needed}; found {present}")
    if _digest(snapshot.state) != snapshot.digest:
        raise operation_failed("the snapshot is damaged: the digest of its state differs")
    try:
        contents = unpack(_decompressed(snapshot.state))
    except (CodecError, zlib.error) as error:
        raise operation_failed(f"cannot read the snapshot: {error}") from error
    if not isinstance(contents, Contents) or not isinstance(contents.world, World):
        raise operation_failed("cannot read the snapshot: it has no simulation")
    return contents


def restored(contents: Contents, before: Simulation, purpose: Purpose, seed: int | None) -> Simulation:
    """Restore a simulation from a snapshot, in the engine of another one, which it replaces.

    Args:
        contents: Result of `check`.
        before: The simulation in the engine.
        purpose: Purpose of the restoration.
        seed: Seed of later random numbers; None for that of the snapshot.

    Raises:
        RequestRefused: The snapshot does not match; the engine has no usable state afterwards.
    """
    simulation = resumed(contents, before.engine, seed)
    with _refusing_mismatches():
        if purpose is Purpose.BEGIN:
            simulation.start_run()
        elif purpose is Purpose.REWIND:
            simulation.continue_from(before)
    return simulation


def resumed(contents: Contents, engine: Engine, seed: int | None) -> Simulation:
    """Restore a simulation from a snapshot, which continues as if uninterrupted; see `restored`."""
    with _refusing_mismatches():
        simulation = Simulation(engine, contents.world, contents.seed if seed is None else seed)
        _saving(engine).restore(contents.engine)
        simulation.restore(contents.simulation)
        return simulation


@contextmanager
def _refusing_mismatches() -> Iterator[None]:
    try:
        yield
    except Exception as error:  # invalid data can fail in any way
        raise operation_failed(f"cannot restore the snapshot: {error}") from error


def _saving(engine: Engine) -> SavesState:
    if not isinstance(engine, SavesState):
        raise feature_unsupported(f"the engine {engine.name} does not support snapshots")
    return engine


def _digest(state: bytes) -> str:
    return blake2b(state, digest_size=16).hexdigest()


def _decompressed(state: bytes) -> bytes:
    decompressor = zlib.decompressobj()
    unpacked = decompressor.decompress(state, MAX_STATE)
    if not decompressor.eof:
        raise CodecError(f"it has more than {MAX_STATE} bytes, or is truncated")
    return unpacked


def check_world_change(present: Simulation, world: World, needed: Mapping[str, str]) -> None:
    """Refuse a world that lacks a robot of the run.

    Args:
        present: The present simulation; the new world must have its robots in use.
        world: The new world.
        needed: Kinds of further required robots by name.

    Raises:
        RequestRefused: The world lacks a robot.
    """
    kinds = {name: present.robots[name].declaration.kinds[0] for name in present.robots_in_use} | dict(needed)
    there = {robot.name: robot.declaration.kinds for robot in world.robots}
    for name, kind in sorted(kinds.items()):
        if kind not in there.get(name, ()):
            robots = name_list(f"{robot} ({has[0]})" for robot, has in there.items())
            lacking = f"which lacks the {kind} {name!r}; robots: {robots}"
            raise RequestRefused(Result.NOT_FOUND, f"the run cannot continue in the world {world.name}, {lacking}")


def enter_world(present: Simulation, world: World) -> Simulation:
    """Return a simulation of a checked world, in its initial state, that continues the present one."""
    simulation = Simulation(present.engine, world, present.seed)
    simulation.continue_from(present)
    return simulation


LONGEST = 0.25  # [s] wall time; affects the time that is reached, not the results
SLICE = 0.5  # [s] simulated between two checks of the wall clock


@dataclass(frozen=True)
class Lookahead:
    """State of a simulation before it went ahead."""

    time: float  # [s]
    engine: Any
    state: State
    number: int  # number of the last event
    tracks: Mark


def simulate_ahead(simulation: Simulation, horizon: float, *, past_feedback: bool) -> Lookahead | None:
    """Simulate to a horizon [s], to the next event, or for as long as a client may be kept waiting.

    Args:
        simulation: The simulation.
        horizon: The horizon [s].
        past_feedback: Whether feedback does not end it.

    Returns:
        The state to return to; None if nothing was simulated.
    """
    engine = simulation.engine
    # Streamed, recorded and followed output cannot be withdrawn.
    shown = simulation.is_rendering or simulation.streams.are_open or simulation.log.is_followed
    is_quiet = partial(simulation.is_quiet, past_feedback=past_feedback)
    if horizon <= simulation.time or shown or not is_quiet() or not isinstance(engine, Rewinds):
        return None
    deadline = monotonic() + LONGEST
    checkpoint = engine.checkpoint()
    if checkpoint is None:
        return None
    # Saved data shares objects with the running simulation, hence the copy.
    ahead = Lookahead(
        simulation.time, checkpoint, deep_copy(simulation.save()), simulation.log.number, simulation.tracks.mark()
    )
    try:
        while simulation.time < horizon and is_quiet() and monotonic() < deadline:
            simulation.advance(min(simulation.time + SLICE, horizon), past_feedback=past_feedback)
    except UnstablePhysics:  # reported by the grant that reaches it
        return_to(simulation, ahead, ahead.time)
        return None
    return ahead


def return_to(simulation: Simulation, ahead: Lookahead, time: float) -> None:
    """Return to a time [s] that has been passed; consumes `ahead`."""
    assert isinstance(simulation.engine, Rewinds)
    simulation.engine.rewind(ahead.engine)
    simulation.restore(ahead.state)
    simulation.log.rewind(ahead.number)
    simulation.tracks.rewind(ahead.tracks)
    simulation.run(time)
    simulation.drop_feedback(time)  # the answer that went ahead had it
