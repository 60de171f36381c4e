"""What a run tells its executor, over a pipe: all of it, in order, whatever holds the run or the executor up."""

import asyncio
import json
import os
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from seoro.executor.frames import Frame, read_frame
from seoro.executor.telling import Telling


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


def read_all(end: int) -> list[tuple[Frame, bytes]]:
    """The frames up to the end of a run."""
    frames: list[tuple[Frame, bytes]] = []
    with os.fdopen(os.dup(end), "rb") as file:
        while not frames or frames[-1][0] is not Frame.END:
            frame = read_frame(file)
            assert frame is not None
            frames.append(frame)
    return frames


def record(number: int) -> dict[str, Any]:
    return {"seq": number, "message": "x" * 1000}


async def test_all_is_told_in_order(pipe: tuple[int, int]) -> None:
    telling = Telling(pipe[1])
    telling.begin("seed 7")
    telling.record(record(0))
    telling.record(record(1))
    telling.finish(b"end")
    begin, *traces, end = read_all(pipe[0])
    assert begin == (Frame.BEGIN, b"seed 7")
    assert [json.loads(line)["seq"] for _, lines in traces for line in lines.splitlines()] == [0, 1]
    assert end == (Frame.END, b"end")


async def test_an_action_that_holds_the_loop_holds_no_news_up(pipe: tuple[int, int]) -> None:
    telling = Telling(pipe[1])
    telling.record(record(0))
    with os.fdopen(os.dup(pipe[0]), "rb") as file:
        frame = read_frame(file)  # without a turn of the loop
    assert frame is not None
    assert json.loads(frame[1])["seq"] == 0


async def test_an_executor_that_stands_still_misses_nothing_and_holds_nothing_up(pipe: tuple[int, int]) -> None:
    telling = Telling(pipe[1])
    before = time.monotonic()
    for number in range(1000):  # far more than a pipe holds
        telling.record(record(number))
        await asyncio.sleep(0)
    assert time.monotonic() - before < 5.0
    frames: list[tuple[Frame, bytes]] = []
    reader = threading.Thread(target=lambda: frames.extend(read_all(pipe[0])))
    reader.start()
    await asyncio.to_thread(telling.finish, b"end")
    reader.join()
    lines = b"".join(data for kind, data in frames if kind is Frame.TRACE).splitlines()
    assert [json.loads(line)["seq"] for line in lines] == list(range(1000))


async def test_an_executor_that_is_gone_is_no_fault_of_the_run() -> None:
    read_end, write_end = os.pipe()
    telling = Telling(write_end)
    os.close(read_end)
    telling.record(record(0))
    await asyncio.sleep(0)
    telling.finish(b"end")
    os.close(write_end)
