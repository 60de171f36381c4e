"""Writer of a trace: no item is lost, the run is never delayed, and errors are reported."""

import asyncio
import io
import json
import threading
import time

import pytest

from seoro.runtime.trace.jsonl import JsonLines, to_json, to_line
from seoro.runtime.trace.writer import PERIOD, Writer


class Slow(io.BytesIO):
    """A file that accepts no bytes until its release."""

    def __init__(self) -> None:
        super().__init__()
        self.go_on = threading.Event()
        self.reached = threading.Event()

    def write(self, data: object) -> int:
        self.reached.set()
        assert self.go_on.wait(30.0)
        return super().write(data)  # type: ignore[arg-type]


class Broken(io.BytesIO):
    def __init__(self, error: OSError) -> None:
        super().__init__()
        self.error = error

    def write(self, data: object) -> int:
        raise self.error


async def test_items_are_written_in_order() -> None:
    file = io.BytesIO()
    writer = Writer[int](file, "file", lambda number: b"%d\n" % number)
    for number in range(5000):
        writer.put(number)
    await writer.finish()
    assert file.getvalue().split() == [b"%d" % number for number in range(5000)]


async def test_queued_items_are_written_soon() -> None:
    file = io.BytesIO()
    writer = Writer[bytes](file, "file", bytes)
    writer.put(b"now")
    end = time.monotonic() + 100 * PERIOD
    while not file.getvalue() and time.monotonic() < end:
        await asyncio.sleep(PERIOD / 10)
    assert file.getvalue() == b"now"
    await writer.finish()


async def test_a_slow_file_does_not_delay_the_producer() -> None:
    file = Slow()
    writer = Writer[bytes](file, "file", bytes)
    writer.put(b"first ")
    assert await asyncio.to_thread(file.reached.wait, 30.0)
    for _ in range(1000):
        writer.put(b"more ")
    finishing = asyncio.create_task(writer.finish())
    await asyncio.sleep(0)
    assert not finishing.done()
    file.go_on.set()
    await finishing
    assert len(file.getvalue().split()) == 1001


async def test_a_file_may_accept_a_part_or_no_bytes_at_first() -> None:
    class Reluctant:
        def __init__(self) -> None:
            self.taken = b""
            self.turns = 0

        def write(self, data: memoryview, /) -> int | None:
            self.turns += 1
            if self.turns % 3 == 0:
                return None
            self.taken += bytes(data[:2])
            return min(2, len(data))

    file = Reluctant()
    writer = Writer[bytes](file, "file", bytes)
    writer.put(b"something long")
    await writer.finish()
    assert file.taken == b"something long"


async def test_memory_is_bounded() -> None:
    file = Slow()
    writer = Writer[bytes](file, "slow.jsonl", bytes, most_waiting=100)
    with pytest.raises(OSError, match="it is too slow: 100 lines wait"):
        for _ in range(1000):
            writer.put(b"x")
    with pytest.raises(OSError, match="too slow"):
        await writer.finish()  # does not wait for the file
    file.go_on.set()


async def test_a_full_disk_is_reported_with_the_next_item_and_at_the_end() -> None:
    writer = Writer[bytes](Broken(OSError(28, "No space left on device")), "trace.jsonl", bytes)
    writer.put(b"x")
    with pytest.raises(OSError, match="No space left on device"):
        await writer.finish()
    with pytest.raises(OSError, match="No space left"):
        writer.put(b"x")


async def test_a_closed_pipe_is_reported_in_words() -> None:
    writer = Writer[bytes](Broken(BrokenPipeError(32, "Broken pipe")), "stdout", bytes)
    writer.put(b"x")
    with pytest.raises(BrokenPipeError, match="its reader has closed it"):
        await writer.finish()


async def test_data_that_is_not_plain_ends_the_writer_with_an_error() -> None:
    lines = JsonLines(io.BytesIO(), "trace.jsonl")
    lines.record({"value": object()})
    with pytest.raises(TypeError, match="not JSON serializable"):
        await lines.finish()


def test_any_text_and_number_is_valid_json() -> None:
    strange = {"text": "a\ud800\n\x00\N{SNOWMAN}", "numbers": [float("nan"), float("inf"), -float("inf"), 1.5]}
    line = to_line(strange)
    assert line.endswith(b"\n") and line.count(b"\n") == 1

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    assert json.loads(line, parse_constant=refuse) == {
        "text": strange["text"], "numbers": ["NaN", "Infinity", "-Infinity", 1.5]
    }  # fmt: skip
    assert to_json({"a": (1, 2)}) == '{"a": [1, 2]}'
