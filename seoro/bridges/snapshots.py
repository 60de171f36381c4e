"""Files with snapshots."""

from __future__ import annotations

from pathlib import Path

from seoro.bridges import wire
from seoro.errors import InvalidUse
from seoro.input_files import Kind, read_input


def read_snapshot(path: Path) -> wire.Snapshot:
    """The snapshot in a file that a run has left.

    Raises:
        InvalidUse: The file cannot be read, or holds no snapshot.
    """
    try:
        content = read_input(path, Kind.SNAPSHOT)
    except OSError as error:
        raise InvalidUse(f"the snapshot {path} cannot be read: {error.strerror}") from error
    try:
        return wire.decode(wire.Snapshot, content, wire.BYTES)
    except wire.WireError:
        raise InvalidUse(
            f"{path} holds no snapshot",
            help="`save_snapshot` of osc.snapshots saves one, and `seoro exec -o DIR` writes it to DIR",
        ) from None
