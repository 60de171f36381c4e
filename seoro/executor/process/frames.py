"""Frames between an executor and the process of a run, over two pipes: a kind with data.

One pipe carries the job and requests to resume or stop; its end means that the executor has died. The other
carries the announcement of the run, the lines of its trace, and its end; before that, if needed, the wait for busy
robots.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import IO, Final

HEADER: Final = struct.Struct("!BI")  # kind, and length of the data [bytes]

NOT_BEGUN: Final = 75  # exit status of a process whose run was stopped before it began


class Frame(IntEnum):
    """Kind of a frame."""

    JOB = 1  # `Job`
    STOP = 2  # reason, as text
    BEGIN = 3  # announcement of the run, as text
    TRACE = 4  # lines
    END = 5  # `seoro.embed.run_end`
    WAITS = 6  # robots that the run waits for and their holders, as text
    READY = 7  # the run holds its robots, and waits for a slot
    GO = 8  # the run has a slot
    DRY_RUN_RESULT = 9  # result of a dry run: `messages.DryRunResult`
    HALT = 10  # like STOP, without further motion of robots
    ABORT = 11  # end the run as an error: reason, as text
    EMIT = 12  # emit an event: `messages.EmitEvent`
    EMITTED = 13  # outcome of an emission: `messages.Emitted`
    RUNS = 14  # runs for a worker of a campaign: `messages.PlannedRuns`
    RUNS_TAKEN = 15  # number of their part, as text


def frame(kind: Frame, data: bytes) -> bytes:
    """Encode a frame."""
    return HEADER.pack(kind, len(data)) + data


def read_frame(source: IO[bytes]) -> tuple[Frame, bytes] | None:
    """Wait for the next frame; None at the end of the pipe."""
    header = source.read(HEADER.size)
    if len(header) < HEADER.size:
        return None
    kind, length = HEADER.unpack(header)
    data = source.read(length)
    return None if len(data) < length else (Frame(kind), data)
