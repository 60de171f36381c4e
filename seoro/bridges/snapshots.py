"""Snapshot files."""

from __future__ import annotations

from pathlib import Path

from seoro.bridges import wire
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input


def read_snapshot(path: Path) -> wire.Snapshot:
    """Read a snapshot from an output file of a run.

    Raises:
        UsageError: The file cannot be read, or is invalid.
    """
    try:
        content = read_input(path, Kind.SNAPSHOT)
    except OSError as error:
        raise UsageError(f"cannot read the snapshot {path}: {error.strerror}") from error
    try:
        return wire.decode(wire.Snapshot, content, wire.BYTES)
    except wire.WireError:
        raise UsageError(
            f"invalid snapshot: {path}",
            help="`save_snapshot` of osc.snapshots saves one, and `seoro exec -o DIR` writes it to DIR",
        ) from None
