"""The trace pipe passes all records in order, also while the run or the executor is blocked."""

import asyncio
import json
import os
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from seoro.executor.process.frames import Frame, read_frame
from seoro.executor.process.trace_pipe import TracePipe


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


def read_all(end: int) -> list[tuple[Frame, bytes]]:
    """Return the frames up to the end of a run."""
    frames: list[tuple[Frame, bytes]] = []
    with os.fdopen(os.dup(end), "rb") as file:
        while not frames or frames[-1][0] is not Frame.END:
            frame = read_frame(file)
            assert frame is not None
            frames.append(frame)
    return frames


def record(number: int) -> dict[str, Any]:
    return {"seq": number, "message": "x" * 1000}


async def test_the_trace_pipe_sends_frames_in_order(pipe: tuple[int, int]) -> None:
    trace = TracePipe(pipe[1])
    trace.send(Frame.BEGIN, "seed 7")
    trace.record(record(0))
    trace.record(record(1))
    trace.finish(b"end")
    begin, *traces, end = read_all(pipe[0])
    assert begin == (Frame.BEGIN, b"seed 7")
    assert [json.loads(line)["seq"] for _, lines in traces for line in lines.splitlines()] == [0, 1]
    assert end == (Frame.END, b"end")


async def test_an_action_that_blocks_the_loop_does_not_delay_the_trace(pipe: tuple[int, int]) -> None:
    trace = TracePipe(pipe[1])
    trace.record(record(0))
    with os.fdopen(os.dup(pipe[0]), "rb") as file:
        frame = read_frame(file)  # without a turn of the loop
    assert frame is not None
    assert json.loads(frame[1])["seq"] == 0


async def test_a_suspended_executor_delays_no_run_and_misses_no_record(pipe: tuple[int, int]) -> None:
    trace = TracePipe(pipe[1])
    before = time.monotonic()
    for number in range(1000):  # far more than a pipe holds
        trace.record(record(number))
        await asyncio.sleep(0)
    assert time.monotonic() - before < 30.0
    frames: list[tuple[Frame, bytes]] = []
    reader = threading.Thread(target=lambda: frames.extend(read_all(pipe[0])))
    reader.start()
    await asyncio.to_thread(trace.finish, b"end")
    reader.join()
    lines = b"".join(data for kind, data in frames if kind is Frame.TRACE).splitlines()
    assert [json.loads(line)["seq"] for line in lines] == list(range(1000))


async def test_the_death_of_the_executor_raises_no_error_in_a_run() -> None:
    read_end, write_end = os.pipe()
    trace = TracePipe(write_end)
    os.close(read_end)
    trace.record(record(0))
    await asyncio.sleep(0)
    trace.finish(b"end")
    with pytest.raises(BrokenPipeError):
        os.write(write_end, b"x")
    os.close(write_end)
