"""Reading traces."""

import io
import json

import pytest

from seoro.traces.reader import MAX_LINE, InvalidRecord, LineReader, read_trace

START = {"seq": 0, "t": 0.0, "kind": "run.start", "scenario": "main", "file": "maze.osc"}


def read(text: bytes) -> list[object]:
    return list(read_trace(io.BytesIO(text)))


def test_records_come_one_by_one() -> None:
    line = json.dumps(START).encode()
    assert read(line + b"\n\n" + line + b"\r\n") == [START, START]


def test_a_last_line_that_is_cut_off_is_distinguished() -> None:
    line = json.dumps(START).encode()
    assert read(line + b"\n" + line[:20]) == [START, InvalidRecord(2, "invalid JSON", is_cut=True)]
    assert read(line[:20] + b"\n" + line) == [InvalidRecord(1, "invalid JSON", is_cut=False), START]


def test_invalid_records_are_reported() -> None:
    lines = [b"[]", b"{}", b'{"t": NaN, "kind": "log"}', b'{"t": 0, "kind": "log"}', b"[" * 100_000, b"\xff"]
    found = read(b"\n".join(lines) + b"\n")
    assert [item.line for item in found if isinstance(item, InvalidRecord)] == [1, 2, 3, 4, 5, 6]
    assert "`message` of `log` is missing" in str(found[3])


def test_a_kind_that_is_new_is_a_record() -> None:
    record = {"t": 1, "kind": "weather", "sun": True}
    assert read(json.dumps(record).encode() + b"\n") == [record]


def test_a_line_without_end_is_not_read_into_memory_whole() -> None:
    class Endless(io.BytesIO):
        longest = 0

        def readline(self, size: int | None = -1, /) -> bytes:
            assert size == MAX_LINE
            return b"x" * min(MAX_LINE, 0) if self.longest else self._once(size)

        def _once(self, size: int) -> bytes:
            self.longest = size
            return b"x" * size

    [found] = read_trace(Endless())
    assert isinstance(found, InvalidRecord)
    assert "longer than" in found.reason


def test_lines_have_their_places_also_after_one_that_is_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.traces.reader.MAX_LINE", 50)
    lines = [
        b'{"t": 0, "kind": "a"}',
        b"x" * 200,
        b"",
        b'{"t": 1, "kind": "b"}',
        b"y" * 90,
        b'{"t": 2, "kind": "c"}',
    ]
    trace = b"\n".join(lines)
    for size in (1, 7, 60, 1000):
        reader, found = LineReader(), list[tuple[int, int, object]]()
        for start in range(0, len(trace), size):
            found += reader.feed(trace[start : start + size])
        found += reader.finish()
        assert [trace[start:end] for start, end, _ in found] == [line for line in lines if line]
        assert [isinstance(record, InvalidRecord) for *_, record in found] == [False, True, False, True, False]


def test_lines_have_their_places_if_a_finished_trace_grows() -> None:
    first, more = b'{"t": 0, "kind": "a"}\n', b'{"t": 1, "kind": "b"}\n'
    for cut in (b"", b'{"t": 0.5'):
        reader = LineReader()
        found = [*reader.feed(first + cut), *reader.finish(), *reader.feed(more)]
        assert (first + cut + more)[slice(*found[-1][:2])] == more.rstrip()
