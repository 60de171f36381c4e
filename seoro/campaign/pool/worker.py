"""Process of a worker, forked by `template.py`.

Its pipe brings lines: first `Start`, then planned runs, and `stop`. Its socket takes the row of each run, after it
was appended to the shard. Instead of a row, it takes the reason why rows cannot be written, or `lost` if the
simulator has died. When the pipe closes, the campaign is over, or its coordinator has died; the present run is
then stopped.
"""

from __future__ import annotations

import asyncio
import os
import socket
import sys
from typing import Final

from seoro.campaign.pool.messages import FATAL, LOST, STOP, Start
from seoro.campaign.runs import Planned
from seoro.campaign.store.folder import shard
from seoro.campaign.store.lines import Appender
from seoro.campaign.work.job import Job
from seoro.campaign.work.running import SimulatorDied, Stopped, Worker

MOST_OF_A_LINE: Final = 1 << 20  # [bytes]


def work(job: Job, control: int, data: int) -> None:
    """Make runs until the pipe closes, and end the process.

    Args:
        job: Shared data of all runs.
        control: Descriptor of the pipe.
        data: Descriptor of the socket.
    """
    status = 0
    with socket.socket(fileno=data) as connection:
        try:
            asyncio.run(_work(job, control, connection))
        except (Stopped, BrokenPipeError, ConnectionResetError):
            pass
        except SimulatorDied:
            connection.sendall(LOST)
        except OSError as error:  # such as a full disk
            connection.sendall(FATAL + f"{error.filename or job.folder}: {error.strerror}\n".encode())
            status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)  # ends threads of actions, too


async def _work(job: Job, control: int, connection: socket.socket) -> None:
    reader = asyncio.StreamReader(MOST_OF_A_LINE)
    loop = asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(control, "rb", buffering=0)
    )
    start = Start.model_validate_json(await reader.readline())
    worker = Worker(job, start.name, start.endpoint, start.simulator)
    rows = Appender(shard(job.folder, start.name))
    planned: asyncio.Queue[Planned | None] = asyncio.Queue()

    async def listen() -> None:
        while (line := await reader.readline()) not in (b"", STOP):
            planned.put_nowait(Planned.from_line(line))
        worker.stop()
        planned.put_nowait(None)

    listening = asyncio.create_task(listen())
    try:
        while (run := await planned.get()) is not None:
            line = (await worker.make(run)).to_line()
            rows.append(line)
            connection.sendall(line.encode("utf-8", "backslashreplace"))
    finally:
        listening.cancel()
        transport.close()
        rows.close()
        worker.close()
