"""Repair of truncated bags, whose writer was killed or had no disk space."""

from __future__ import annotations

from pathlib import Path

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import information, write_metadata
from seoro.bridges.ros2.recording.reader import MCAP, Bag, files_of, open_bag
from seoro.bridges.ros2.recording.scanning import DAMAGES, is_whole, repair
from seoro.files.inputs import Kind, open_input


def repair_bag(path: Path) -> Bag:
    """Complete the MCAP files of a bag, so that all tools can read them, and rewrite its `metadata.yaml`.

    All readable messages are kept; only incomplete messages are removed.

    Args:
        path: Folder of a bag, or a file.

    Raises:
        UnreadableBag: The bag is missing, a file is not an MCAP file, or the bag is still being written.
        OSError: The bag cannot be written.
    """
    files = files_of(path) if path.is_dir() else [path]
    if not files or any(file.suffix != MCAP or not file.is_file() for file in files):
        raise UnreadableBag(f"{path} is not a bag of MCAP files; only these can be repaired")
    for file in files:
        _repair_file(file)
    if path.is_dir():
        bag, extents = open_bag(path), {file.name: open_bag(file).extent for file in files}
        write_metadata(path, information(extents, list(bag.topics.values()), bag.notes))
    return open_bag(path)


def _repair_file(file: Path) -> None:
    try:
        with open_input(file, Kind.RECORDING) as stream:
            whole = is_whole(stream)
        if not whole:
            repair(file)
    except DAMAGES as error:
        raise UnreadableBag(f"{file} is damaged, or not an MCAP file: {error or type(error).__name__}") from None
    except BlockingIOError:
        raise UnreadableBag(f"{file} is still being written") from None
