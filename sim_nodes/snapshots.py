"""Snapshots: the state of a simulation as a message, and its restoration.

A snapshot includes the world, so that nodes without its files can continue. A state is valid only for the same
engine, its version, and the same version of seoro.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

from seoro.bridges.wire import BYTES, SNAPSHOT_FORMAT, Purpose, Result, Snapshot, WireError, decode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.files.inputs import Kind, read_input
from sim_nodes.codec import CodecError, pack, unpack
from sim_nodes.physics import Engine, SavesState, UnsavableState
from sim_nodes.refusals import feature_unsupported, operation_failed
from sim_nodes.simulation import Simulation
from sim_nodes.stateful import State
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


def take(simulation: Simulation, version: str) -> Snapshot:
    """Take a snapshot of a simulation.

    Args:
        simulation: The simulation; it is unchanged.
        version: Version of seoro.

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
        version=version,
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


def check(snapshot: Snapshot, engine: Engine, version: str) -> Contents:
    """Return the contents of a snapshot that matches an engine; changes nothing.

    Raises:
        RequestRefused: The snapshot is of another engine or version, or damaged.
    """
    _saving(engine)
    for item, needed, present in (
        ("format", snapshot.format, SNAPSHOT_FORMAT),
        ("engine", snapshot.engine, engine.name),
        (f"version of {engine.name}", snapshot.engine_version, engine.version),
        ("version of seoro", snapshot.version, version),
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
        match purpose:
            case Purpose.CONTINUE:
                pass
            case Purpose.BEGIN:
                simulation.start_run()
            case Purpose.REWIND:
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
