"""Pictures of a film for recordings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from seoro.files.inputs import Kind, open_input

FORMAT: Final = "h264"  # of Foxglove: a message has one picture, with the parameter sets of key pictures


def film_pictures(path: Path) -> Iterator[tuple[float, bytes]]:
    """Yield the pictures of a film of H.264 in MP4, with their times since its start [s].

    Raises:
        ValueError: The file cannot be read, or has no video in H.264.
    """
    import av  # noqa: PLC0415 - optional, and large
    from av.bitstream import BitStreamFilterContext  # noqa: PLC0415 - the same
    from av.container import InputContainer  # noqa: PLC0415 - the same

    try:
        with open_input(path, Kind.OUTPUT) as file, av.open(file) as container:
            assert isinstance(container, InputContainer), "opened for reading"
            stream = next((each for each in container.streams.video if each.codec.name == FORMAT), None)
            if stream is None:
                raise ValueError(f"invalid film {path}: expected video in H.264")
            to_packets = BitStreamFilterContext("h264_mp4toannexb", stream)
            for packet in container.demux(stream):
                for each in to_packets.filter(packet):
                    if each.pts is not None and each.size:
                        yield float(each.pts * each.time_base), bytes(each)
    except (OSError, av.FFmpegError) as error:
        raise ValueError(f"cannot read the film {path}: {error.strerror}") from error
