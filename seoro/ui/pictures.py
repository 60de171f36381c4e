"""Pictures of the simulator of a run on this machine; see `seoro.embed.picture_server`."""

from __future__ import annotations

import asyncio
import json
import os
import stat
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from seoro.embed.picture_server import NAME, short_path
from seoro.errors import BackendError

LARGEST_HEAD: Final = 64 << 10  # [bytes] of a line of JSON
LARGEST_PICTURE: Final = 32 << 20  # [bytes]
TIMEOUT: Final = 20.0  # [s] for an answer; a simulator at the highest rate may be busy


class NoPictures(BackendError):
    """The run has no pictures; the message has the reason."""


@dataclass(frozen=True)
class Picture:
    """A picture as PNG, with its time on the clock of the run [s]."""

    time: float
    png: bytes


class Pictures:
    """Connection to the cameras of a run. Open it with `connect_pictures`."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer

    async def cameras(self) -> Sequence[str]:
        """Return the names of the cameras.

        Raises:
            NoPictures: The run has none, or has ended.
        """
        found, _ = await self._ask({})
        names = found.get("cameras")
        return [str(name) for name in names] if isinstance(names, list) else []

    async def take(self, camera: str) -> Picture:
        """Take a picture.

        Raises:
            NoPictures: The camera is unknown or gives no picture, or the run has ended.
        """
        found, png = await self._ask({"camera": camera})
        time = found.get("time")
        return Picture(float(time) if isinstance(time, int | float) else 0.0, png)

    async def _ask(self, request: dict[str, str]) -> tuple[dict[str, Any], bytes]:
        try:
            async with asyncio.timeout(TIMEOUT):
                self._writer.write(json.dumps(request).encode() + b"\n")
                found = json.loads(await self._reader.readuntil(b"\n"))
                size = found.get("size", 0)
                if not 0 <= size <= LARGEST_PICTURE:
                    raise ValueError("too large")
                png = await self._reader.readexactly(size)
        except TimeoutError:
            raise NoPictures(f"the run gave no picture within {TIMEOUT:g} s") from None
        except (OSError, asyncio.IncompleteReadError):
            raise NoPictures("the run has ended") from None
        except (ValueError, TypeError, AttributeError, asyncio.LimitOverrunError):
            raise NoPictures("the run sent an invalid picture") from None
        if problem := found.get("problem"):
            raise NoPictures(str(problem))
        return found, png


@asynccontextmanager
async def connect_pictures(folders: Sequence[Path]) -> AsyncIterator[Pictures]:
    """Connect to the cameras of a run while the block lasts.

    Args:
        folders: Folders of the run, one of which has the socket.

    Raises:
        NoPictures: The run serves no pictures, or has ended.
    """
    path = next((folder / NAME for folder in folders if _is_socket(folder / NAME)), None)
    if path is None:
        raise NoPictures("this run has no pictures: it has ended, or it has no simulator")
    try:
        with short_path(path) as address:
            reader, writer = await asyncio.open_unix_connection(address, limit=LARGEST_HEAD)
    except OSError:
        raise NoPictures("the run has ended") from None
    try:
        yield Pictures(reader, writer)
    finally:
        writer.close()
        with suppress(OSError):
            await writer.wait_closed()


def _is_socket(path: Path) -> bool:
    """Whether a path is a socket file of this user, and not a link to one."""
    try:
        found = path.lstat()
    except OSError:
        return False
    return stat.S_ISSOCK(found.st_mode) and found.st_uid == os.getuid()
