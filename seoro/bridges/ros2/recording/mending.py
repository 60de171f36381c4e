"""Making a bag whole that was cut off, since its writer was killed or had no room left."""

from __future__ import annotations

from pathlib import Path

from mcap.exceptions import McapError

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import information, read_metadata, write_metadata
from seoro.bridges.ros2.recording.reader import Bag, files_of, open_bag
from seoro.bridges.ros2.recording.scanning import is_whole, mend


def mend_bag(folder: Path) -> Bag:
    """Make the files of a bag whole, such that all tools can read them, and write its `metadata.yaml` anew.

    Nothing of what can be read is lost: what is cut off are parts of messages. Only bags of MCAP files are mended.

    Args:
        folder: The bag.

    Raises:
        UnreadableBag: There is no such bag, or a file of it is no MCAP file.
        OSError: It cannot be written.
    """
    files = files_of(folder)
    if not files:
        raise UnreadableBag(f"{folder} is no bag of MCAP files")
    for file in files:
        _mend_file(file)
    metadata = read_metadata(folder)
    bags = {file.name: open_bag(file) for file in files}
    notes = (metadata.custom_data if metadata else None) or {}
    bag = open_bag(folder)
    write_metadata(
        folder, information({name: each.extent for name, each in bags.items()}, list(bag.topics.values()), notes)
    )
    return bag


def _mend_file(file: Path) -> None:
    try:
        with file.open("rb") as stream:
            whole = is_whole(stream)
        if not whole:
            mend(file)
    except McapError as error:
        raise UnreadableBag(f"{file} is no MCAP file: {error}") from None
