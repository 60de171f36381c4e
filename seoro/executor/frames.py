"""What an executor and the process of a run say to each other, over two pipes: frames of a kind and some bytes.

One pipe has the job and, later, that it is to go on or to stop; its end means that the executor is gone. The
other has what the run begins with, the lines of its trace as they are made, and its end; before that, if it needs
robots that others have, for whom it waits, and that it has them. What is told of processes has a pipe of its own.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import IO, Final

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire.message import Message

HEADER: Final = struct.Struct("!BI")  # kind, and the length of what follows [bytes]
TOLD: Final = struct.Struct("!Bii")  # what is told of a process, its number, and its exit status if it has ended

NOT_BEGUN: Final = 75  # exit status of a process whose run was stopped before it began


class Frame(IntEnum):
    """What a frame is."""

    JOB = 1  # `Job`
    STOP = 2  # why, as text
    BEGIN = 3  # what the run begins with, as text for people
    TRACE = 4  # lines
    END = 5  # `seoro.embed.ends`
    WAITS = 6  # for whom it waits, as text: others may go on meanwhile
    READY = 7  # it has what it has waited for, and waits for its turn
    GO = 8  # it has its turn
    TRIED = 9  # what a dry run would begin with: `messages.Tried`
    HALT = 10  # as STOP, and nothing is to be done with robots after the run
    GIVE_UP = 11  # end the run as an error: why, as text


class Told(IntEnum):
    """What is told of a process."""

    STARTED = 1
    ENDED = 2


class Job(Message):
    """A run that is to be carried out: where its files lie, and what its scenario may do."""

    manifest: wire.Manifest
    files: str  # folder with the bundle
    output: str  # folder for what it leaves
    log: str  # file for what its process prints
    home: str  # folder for what its programs keep, which is removed after it
    largest_file: int  # [bytes]
    memory: int | None = None  # [bytes] that its processes have together at most; None for no limit
    processes: int | None = None  # at most; None for no limit
    allowed: tuple[str, ...]
    reach: tuple[str, ...] = ()  # endpoints of other machines
    environment: tuple[str, ...] = ()  # further variables of the executor that it sees
    is_dry: bool = False  # whether it is only tried
    is_sandboxed: bool = False
    hidden: tuple[str, ...] = ()  # folders of the executor that a sandboxed run must not see


def frame(kind: Frame, data: bytes) -> bytes:
    """A frame, as it is written."""
    return HEADER.pack(kind, len(data)) + data


def read_frame(source: IO[bytes]) -> tuple[Frame, bytes] | None:
    """The next frame, which is waited for; None when nothing more comes."""
    header = source.read(HEADER.size)
    if len(header) < HEADER.size:
        return None
    kind, length = HEADER.unpack(header)
    data = source.read(length)
    return None if len(data) < length else (Frame(kind), data)
