"""Snapshots: the state of a simulation as a message, and a simulation made from one.

The world comes with it, so that a node that knows no such world can go on from it. A state is for the engine, its
version and the version of seoro by which it was made: what follows from it in others would not be the same.
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
from seoro.input_files import Kind, read_input
from sim_nodes.codec import CodecError, pack, unpack
from sim_nodes.physics import Engine, SavesState, UnsavableState
from sim_nodes.simulation import Simulation
from sim_nodes.stateful import State
from sim_nodes.worlds.loader import World

MAX_STATE = 256 * 1024 * 1024  # [bytes] unpacked
COMPRESSION = 1  # zlib's fastest: maps with few obstacles shrink to a few percent by it


@dataclass(frozen=True)
class Contents:
    """What is in a snapshot."""

    world: World
    seed: int
    engine: Any
    simulation: State


def take(simulation: Simulation, version: str) -> Snapshot:
    """A snapshot of a simulation.

    Args:
        simulation: The simulation; it stays as it is.
        version: Of seoro.

    Raises:
        RequestRefused: Its engine does not save states, or there is too much to save.
    """
    engine = _saving(simulation.engine)
    try:
        packed = pack(Contents(simulation.world, simulation.seed, dict(engine.save()), simulation.save()))
    except (UnsavableState, CodecError) as error:
        raise RequestRefused(Result.OPERATION_FAILED, f"the state cannot be saved: {error}") from error
    if len(packed) > MAX_STATE:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"the state has {len(packed)} bytes: snapshots have {MAX_STATE} at most"
        )
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
    """The snapshot in a file.

    Raises:
        RequestRefused: The file cannot be read, or holds no snapshot.
    """
    try:
        return decode(Snapshot, read_input(path, Kind.SNAPSHOT), BYTES)
    except OSError as error:
        raise RequestRefused(Result.NOT_FOUND, f"{path} cannot be read: {error.strerror}") from error
    except WireError as error:
        raise RequestRefused(Result.OPERATION_FAILED, f"{path} holds no snapshot") from error


def check(snapshot: Snapshot, engine: Engine, version: str) -> Contents:
    """What is in a snapshot, if an engine can go on from it; nothing has changed yet.

    Raises:
        RequestRefused: It is of another engine or version, or damaged.
    """
    _saving(engine)
    for what, made, here in (
        ("format", snapshot.format, SNAPSHOT_FORMAT),
        ("engine", snapshot.engine, engine.name),
        (f"version of {engine.name}", snapshot.engine_version, engine.version),
        ("version of seoro", snapshot.version, version),
    ):
        if made != here:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the snapshot was made with the {what} {made}, and here is {here}, where it means nothing",
            )
    if _digest(snapshot.state) != snapshot.digest:
        raise RequestRefused(Result.OPERATION_FAILED, "the snapshot is damaged: its state is not what was saved")
    try:
        contents = unpack(_decompressed(snapshot.state))
    except (CodecError, zlib.error) as error:
        raise RequestRefused(Result.OPERATION_FAILED, f"the snapshot cannot be read: {error}") from error
    if not isinstance(contents, Contents) or not isinstance(contents.world, World):
        raise RequestRefused(Result.OPERATION_FAILED, "the snapshot cannot be read: it holds no simulation")
    return contents


def restored(contents: Contents, before: Simulation, purpose: Purpose, seed: int | None) -> Simulation:
    """The simulation of a snapshot, in the engine of another, which it takes the place of.

    Args:
        contents: What `check` returned.
        before: The simulation that has been in the engine.
        purpose: What it is restored for.
        seed: Of what is drawn from there on; None for that of the snapshot.

    Raises:
        RequestRefused: The snapshot does not fit; the engine has no usable state then.
    """
    simulation = resumed(contents, before.engine, seed)
    with _refusing_what_does_not_fit():
        match purpose:
            case Purpose.CONTINUE:
                pass
            case Purpose.BEGIN:
                simulation.begin()
            case Purpose.REWIND:
                simulation.take_over(before)
    return simulation


def resumed(contents: Contents, engine: Engine, seed: int | None) -> Simulation:
    """The simulation of a snapshot, which goes on as if nothing had been between; see `restored`."""
    with _refusing_what_does_not_fit():
        simulation = Simulation(engine, contents.world, contents.seed if seed is None else seed)
        _saving(engine).restore(contents.engine)
        simulation.restore(contents.simulation)
        return simulation


@contextmanager
def _refusing_what_does_not_fit() -> Iterator[None]:
    try:
        yield
    except Exception as error:  # what somebody has made up can be wrong in any way
        raise RequestRefused(Result.OPERATION_FAILED, f"the snapshot cannot be restored: {error}") from error


def _saving(engine: Engine) -> SavesState:
    if not isinstance(engine, SavesState):
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED, f"the engine {engine.name} cannot save its state: it has no snapshots"
        )
    return engine


def _digest(state: bytes) -> str:
    return blake2b(state, digest_size=16).hexdigest()


def _decompressed(state: bytes) -> bytes:
    decompressor = zlib.decompressobj()
    unpacked = decompressor.decompress(state, MAX_STATE)
    if not decompressor.eof:
        raise CodecError(f"it has more than {MAX_STATE} bytes, or less than it should")
    return unpacked
