"""Live pictures of the cameras of a run's simulator, for viewers on this machine.

The run itself asks its simulator, since only the run knows its time: a simulator may have simulated ahead of it.
So the simulation is the same with and without viewers. Pictures take at most `SHARE` of the time.

Viewers connect to a socket file, which only this user can open. A request is a line of JSON, `{"camera": NAME}`,
or `{}` for the names of the cameras. The answer is a line of JSON, and the picture as PNG if it has a `size`.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
import stat
import time
from collections import deque
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from seoro.concurrency.background import background
from seoro.errors import BackendError
from seoro.runtime.contracts.sensors import Cameras
from seoro.runtime.trace.jsonl import to_line

if TYPE_CHECKING:
    from anyio.abc import TaskGroup

    from seoro.bridges.sim.node import SimulatorNode

NAME: Final = "pictures.sock"  # in the folder of a run
LARGEST_REQUEST: Final = 4096  # [bytes]
SHARE: Final = 0.1  # of the machine's time that pictures may take
_BACKLOG: Final = 8  # viewers that wait for a connection


@asynccontextmanager
async def serving_pictures(simulator: SimulatorNode, folder: Path) -> AsyncIterator[None]:
    """Serve pictures in a folder while the block lasts; none if the folder cannot have sockets.

    Args:
        simulator: Simulator of the run.
        folder: Folder of the run.
    """
    listening = _listen(folder)
    if listening is None:
        yield
        return
    async with background() as tasks:
        server = _Server(simulator)
        try:
            tasks.start_soon(server.accept, listening, tasks)
            yield
        finally:
            listening.close()
            with suppress(OSError):
                (folder / NAME).unlink()


class _Server:
    """Answers viewers, one picture at a time.

    Args:
        simulator: Simulator of the run.
    """

    def __init__(self, simulator: SimulatorNode) -> None:
        self._simulator = simulator
        self._lock = asyncio.Lock()
        self._free = 0.0  # time from which the simulator may be asked, by the monotonic clock [s]
        self._took: deque[float] = deque(maxlen=8)  # durations of requests [s]

    async def accept(self, listening: socket.socket, tasks: TaskGroup) -> None:
        """Accept viewers until this is cancelled."""
        loop = asyncio.get_running_loop()
        while True:
            accepted, _ = await loop.sock_accept(listening)
            reader, writer = await asyncio.open_unix_connection(sock=accepted, limit=LARGEST_REQUEST)
            tasks.start_soon(self._serve, reader, writer)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while line := await reader.readline():
                found, png = await self._answer(line)
                writer.write(to_line(found) + png)
                await writer.drain()
        except (ConnectionError, ValueError):  # the viewer has left, or its line is too long
            pass
        finally:
            writer.close()

    async def _answer(self, line: bytes) -> tuple[dict[str, Any], bytes]:
        try:
            camera = json.loads(line)["camera"] if line.strip() != b"{}" else None
        except (ValueError, TypeError, KeyError, RecursionError):
            return {"problem": "invalid request"}, b""
        if not self._simulator.serves(Cameras):
            return {"problem": f"{self._simulator.name} has no cameras"}, b""
        try:
            async with self._turn():
                if camera is None:
                    return {"cameras": list(await self._simulator.cameras())}, b""
                image = await self._simulator.take_picture(str(camera))
        except BackendError as error:
            return {"problem": str(error)}, b""
        return {
            "time": image.time,
            "width": image.width,
            "height": image.height,
            "size": len(image.png),
        }, image.png

    @asynccontextmanager
    async def _turn(self) -> AsyncIterator[None]:
        """Wait until the simulator may be asked again, and ask it in the block."""
        async with self._lock:
            await asyncio.sleep(max(0.0, self._free - time.monotonic()))
            began = time.monotonic()
            try:
                yield
            finally:
                self._took.append(time.monotonic() - began)
                # The shortest of some times is without the work that was in the simulator's queue before.
                self._free = time.monotonic() + min(self._took) * (1.0 / SHARE - 1.0)


def _listen(folder: Path) -> socket.socket | None:
    """Listen in a folder; None if it cannot have sockets."""
    path = folder / NAME
    listening = socket.socket(socket.AF_UNIX)
    try:
        if path.is_socket():  # of a run that was killed
            path.unlink()
        os.fchmod(listening.fileno(), stat.S_IRUSR | stat.S_IWUSR)  # of the file that `bind` makes
        with short_path(path) as address:
            listening.bind(address)
        listening.listen(_BACKLOG)
        listening.setblocking(False)
    except OSError:
        listening.close()
        return None
    return listening


@contextmanager
def short_path(path: Path) -> Iterator[str]:
    """Yield a path of a socket file with less than 108 bytes, the most that sockets can have.

    Raises:
        OSError: The folder cannot be opened.
    """
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)
