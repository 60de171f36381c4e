"""Pictures of a film for recordings and bags."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.files.inputs import Kind, open_input

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.stream import VideoStream

FORMAT: Final = "h264"  # of Foxglove: a message has one picture, with the parameter sets of key pictures
_QUALITY: Final = 80  # of JPEG, in percent


def film_pictures(path: Path) -> Iterator[tuple[float, bytes]]:
    """Yield the pictures of a film of H.264 in MP4, with their times since its start [s].

    Raises:
        ValueError: The file cannot be read, or has no video in H.264.
    """
    from av.bitstream import BitStreamFilterContext  # noqa: PLC0415 - optional, and large

    with _opened(path) as (container, stream):
        to_packets = BitStreamFilterContext("h264_mp4toannexb", stream)
        for packet in container.demux(stream):
            for each in to_packets.filter(packet):
                if each.pts is not None and each.size:
                    yield float(each.pts * each.time_base), bytes(each)


def film_stills(path: Path) -> Iterator[tuple[float, bytes]]:
    """Yield the pictures of a film in JPEG, with their times since its start [s].

    Raises:
        ValueError: The file cannot be read, or has no video in H.264.
    """
    from PIL import Image  # noqa: PLC0415 - as `av`

    with _opened(path) as (container, stream):
        for frame in container.decode(stream):
            if frame.time is not None:
                picture = io.BytesIO()
                Image.fromarray(frame.to_ndarray(format="rgb24")).save(picture, "JPEG", quality=_QUALITY)
                yield frame.time, picture.getvalue()


@contextmanager
def _opened(path: Path) -> Iterator[tuple[InputContainer, VideoStream]]:
    import av  # noqa: PLC0415 - optional, and large
    from av.container import InputContainer  # noqa: PLC0415 - the same

    try:
        with open_input(path, Kind.OUTPUT) as file, av.open(file) as container:
            assert isinstance(container, InputContainer), "opened for reading"
            stream = next((each for each in container.streams.video if each.codec.name == FORMAT), None)
            if stream is None:
                raise ValueError(f"invalid film {path}: expected video in H.264")
            yield container, stream
    except (OSError, av.FFmpegError) as error:
        raise ValueError(f"cannot read the film {path}: {error.strerror}") from error
