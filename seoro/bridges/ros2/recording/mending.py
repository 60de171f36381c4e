"""Making a bag whole that was cut off, since its writer was killed or had no room left."""

from __future__ import annotations

from pathlib import Path

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import information, write_metadata
from seoro.bridges.ros2.recording.reader import MCAP, Bag, files_of, open_bag
from seoro.bridges.ros2.recording.scanning import DAMAGES, is_whole, mend
from seoro.input_files import Kind, open_input


def mend_bag(path: Path) -> Bag:
    """Make the files of a bag whole, such that all tools can read them, and write its `metadata.yaml` anew.

    Nothing of what can be read is lost: what is cut off are parts of messages. Only bags of MCAP files are mended.

    Args:
        path: The folder of a bag, or a file.

    Raises:
        UnreadableBag: There is no such bag, a file of it is no MCAP file, or it is still being written.
        OSError: It cannot be written.
    """
    files = files_of(path) if path.is_dir() else [path]
    if not files or any(file.suffix != MCAP or not file.is_file() for file in files):
        raise UnreadableBag(f"{path} is no bag of MCAP files, which are what can be mended")
    for file in files:
        _mend_file(file)
    if path.is_dir():
        bag, extents = open_bag(path), {file.name: open_bag(file).extent for file in files}
        write_metadata(path, information(extents, list(bag.topics.values()), bag.notes))
    return open_bag(path)


def _mend_file(file: Path) -> None:
    try:
        with open_input(file, Kind.RECORDING) as stream:
            whole = is_whole(stream)
        if not whole:
            mend(file)
    except DAMAGES as error:
        raise UnreadableBag(f"{file} is no MCAP file, or is damaged: {error or type(error).__name__}") from None
    except BlockingIOError:
        raise UnreadableBag(f"{file} is still being written") from None
