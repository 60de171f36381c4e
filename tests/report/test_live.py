"""Frames of a growing trace, joined, are the data of the whole trace."""

from __future__ import annotations

import json
import os
import random
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from seoro.cli.main import main
from seoro.report import index
from seoro.report.following import TraceFile
from seoro.report.live import Cursor, LiveRun
from tests.report.joining import Joined, lines_of, split
from tests.report.traces import HOSTILE, many_records, records
from tests.traces.test_any_trace import ANY_RECORD, PLAUSIBLE

MORE = (
    {"t": 1.0, "kind": "path", "entity": "tb4", "points": [[0, 1], [2, 3.5]]},
    {"t": 1.5, "kind": "scan", "entity": "tb4", "pose": [0, 0, 0, 0, 0, 0, 1], "ranges": [1, None, 2],
     "angle_min": 0, "angle_increment": 0.1},
    {"t": 1.6, "kind": "poses", "time": 1.6, "entities": {}, "believed": {"tb4": [0, 1, 0.5]}},
    {"t": 1.7, "kind": "margin", "check": "c", "value": 0.5, "source": "a:1:1", "limit": float("nan")},
    {"t": 1.8, "kind": "event", "name": "seen", "arguments": {"distance": 3.5, "who": "tb4"}},
    {"t": 1.9, "kind": "behavior.start", "id": 1, "type": "wait", "name": "w", "path": "p", "source": ""},
    {"t": 1.95, "kind": "behavior.start", "id": 1, "type": "wait", "name": "w", "path": "p", "source": ""},
)  # fmt: skip


def encoded(found: Iterable[object]) -> bytes:
    return b"".join(json.dumps(record).encode() + b"\n" for record in found)


def run_of(trace: bytes) -> LiveRun:
    """Make a run without data, whose blocks are in a trace."""
    run = LiveRun()
    run.restart(lambda start, size: trace[start : start + size])
    return run


def frame_of(run: LiveRun, cursor: Cursor | None = None) -> tuple[bytes, Cursor]:
    parts: list[bytes] = []
    cursor = run.write_frame(parts.append, cursor)
    return b"".join(parts), cursor


def whole(trace: bytes, folder: Path | None = None) -> LiveRun:
    run = run_of(trace)
    run.feed(trace)
    run.finish(folder)
    return run


def joined_from(run: LiveRun) -> Joined:
    joined = Joined()
    joined.add(frame_of(run)[0])
    return joined


def follow(trace: bytes, cuts: Iterable[int], folder: Path | None = None) -> tuple[LiveRun, Joined]:
    """Feed a trace in pieces, with a frame after each."""
    run, joined = run_of(trace), Joined()
    cursor: Cursor | None = None
    start = 0
    for end in [*sorted(cuts), len(trace)]:
        run.feed(trace[start:end])
        start = end
        message, cursor = frame_of(run, cursor)
        joined.add(message)
        assert run.is_current(cursor)
    run.finish(folder)
    assert not run.is_current(cursor)
    joined.add(frame_of(run, cursor)[0])
    return run, joined


def check(trace: bytes, cuts: Iterable[int], folder: Path | None = None) -> None:
    run, joined = follow(trace, cuts, folder)
    expected = whole(trace, folder)
    found = joined_from(expected)
    assert joined.fields == found.fields
    assert joined.columns == found.columns
    for _, _, count, number in joined.fields["blocks"]:
        assert run.block(number) == expected.block(number)
        assert len(lines_of(run.block(number))) == count
    # A page that is opened later has the same.
    assert joined_from(run).fields == found.fields


@settings(max_examples=80, deadline=None)
@given(st.lists(PLAUSIBLE | ANY_RECORD, max_size=12), st.lists(st.integers(0, 2_000), max_size=6))
@example([{"t": float("nan"), "kind": "log"}, {"t": 0, "kind": "x", "name": "\ud800"}], [5])
def test_any_trace_cut_anywhere(found: list[object], cuts: list[int]) -> None:
    trace = encoded(found)
    check(trace, [min(cut, len(trace)) for cut in cuts])


@pytest.mark.parametrize(
    "make",
    [
        records,
        lambda: [*records(HOSTILE)[:40], *MORE, *records()[1:]],
        lambda: list(many_records(9_000)),
        lambda: [*records(), *records()],
    ],
    ids=["failing", "more", "many", "two"],
)
def test_frames_join_to_the_whole(make: Callable[[], list[dict[str, Any]]]) -> None:
    trace = encoded(make())
    draw = random.Random(1)
    for _ in range(4):
        check(trace, [draw.randrange(len(trace) + 1) for _ in range(12)])
    check(trace + b'{"seq": 9', [100])


def test_a_real_run_with_its_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("count.osc").write_text(
        "import osc.types\nimport osc.helpers\n\nscenario main:\n    do parallel:\n        serial:\n"
        '            wait elapsed(1s)\n            log("tick")\n        with:\n            repeat(5)\n'
        "        wait elapsed(4s)\n"
    )
    assert main(["exec", "count.osc", "--clock", "virtual", "-o", "out"]) == 0
    Path("out/measurements.json").write_text('{"engine": "mujoco", "world": "hall"}')
    Path("out/trajectories.csv").write_text("entity,time,x,y,yaw,command_linear\ntb,0,0,0,0,0.5\ntb,1,1,0,0,0.5\n")
    trace = Path("out/trace.jsonl").read_bytes()
    check(trace, range(0, len(trace), 777), Path("out"))
    joined = joined_from(whole(trace, Path("out")))
    assert joined.fields["status"] == "passed"
    assert joined.fields["scene"] == {"simulator": "mujoco", "world": "hall"}
    assert joined.columns["series.0.v"] == [0.5, 0.5]
    assert "--sim mujoco --world hall" in joined.fields["command"]


def test_later_frames_have_only_what_is_new() -> None:
    trace = encoded(many_records(9_000))
    run = LiveRun()
    run.feed(trace)
    first, cursor = frame_of(run)
    run.feed(encoded([{"t": 99, "kind": "log", "level": "info", "message": "new"}]))
    later, _ = frame_of(run, cursor)
    assert len(first) > 100_000
    assert len(later) < 1_000
    assert set(split(later)[0]["layout"]) == {"records.kind"}


def test_a_running_behavior_ends_in_a_later_frame() -> None:
    run, joined = LiveRun(), Joined()
    start = {"t": 0, "kind": "behavior.start", "id": 7, "type": "wait", "name": "w", "path": "p", "source": ""}
    run.feed(encoded([start, {"t": 1, "kind": "x"}]))
    message, cursor = frame_of(run)
    joined.add(message)
    assert (run.status, joined.fields["status"], joined.columns["behaviors.end"]) == ("running", "running", [1.0])
    run.feed(encoded([{"t": 3, "kind": "behavior.end", "id": 7, "status": "failed", "reason": "late"}]))
    joined.add(frame_of(run, cursor)[0])
    assert joined.columns["behaviors.end"] == [3.0]
    assert joined.columns["behaviors.endSeq"] == [2]
    assert joined.fields["strings"] == ["late"]
    run.finish()
    assert run.status == "killed"


def test_a_file_is_followed_until_it_is_written_anew(tmp_path: Path) -> None:
    path, run = tmp_path / "trace.jsonl", LiveRun()
    file = TraceFile(path, run)
    assert not file.poll()
    trace = encoded(records())
    path.write_bytes(trace[:1000])
    assert file.poll()
    message, cursor = frame_of(run)
    assert not file.poll()
    with path.open("ab") as more:
        more.write(trace[1000:])
    while file.poll():
        pass
    joined = Joined()
    joined.add(message)
    message, cursor = frame_of(run, cursor)
    joined.add(message)
    assert joined.fields["count"] == len(records())

    for rewrite in (lambda: path.write_bytes(trace[:500]), lambda: replace(path, encoded(many_records(500)))):
        rewrite()
        while file.poll():
            pass
        message, cursor = frame_of(run, cursor)
        joined.add(message)
        assert joined.fields == joined_from(run).fields
    assert joined.fields["count"] > 400
    path.write_bytes(encoded([{"t": 0, "kind": "x"}] * 9_000))  # longer than before
    while file.poll():
        pass
    joined.add(frame_of(run, cursor)[0])
    assert joined.fields["count"] == 9_000
    file.close()


def test_a_finished_run_is_read_from_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "measurements.json").write_text('{"engine": "mujoco"}')
    path = tmp_path / "trace.jsonl"
    path.write_bytes(encoded(many_records(9_000)))
    with read_to_its_end(path) as read:
        frame, blocks = frame_of(read)[0], [read.block(number) for number in range(5)]
    with monkeypatch.context() as patch:
        patch.setattr("seoro.report.reading.Reading.feed", None)  # nothing is read again
        with read_to_its_end(path) as cached:
            assert frame_of(cached)[0] == frame
            assert cached.status == "passed"
            assert cached.is_finished
            assert [cached.block(number) for number in range(5)] == blocks
            for number in (5, -1):
                with pytest.raises(IndexError):
                    cached.block(number)

    run = LiveRun()
    with closing(TraceFile(path, run, tmp_path)) as file:
        assert file.poll()
        assert not file.poll()
        _, cursor = frame_of(run)
        assert run.is_current(cursor)
        with path.open("ab") as more:  # the run was not finished
            more.write(encoded([{"t": 999, "kind": "x"}]))
        while file.poll():
            pass
    joined = Joined()
    joined.add(frame_of(run, cursor)[0])
    assert (joined.fields["time"], joined.fields["status"]) == (999, "passed")

    [kept] = (tmp_path / "cache/seoro/runs").iterdir()
    kept.write_bytes(kept.read_bytes()[:-1])  # damaged
    with read_to_its_end(path) as again:
        assert frame_of(again)[0] != frame
    (tmp_path / "measurements.json").write_text("{}")
    with read_to_its_end(path) as again:
        assert joined_from(again).fields["measurements"] == {}


def test_the_cache_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.report.index.MOST_FILES", 2)
    for number in range(4):
        index.store(tmp_path / f"{number}.run", index.Index("passed", b"", []))
        os.utime(tmp_path / f"{number}.run", (number, number))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["2.run", "3.run"]


@contextmanager
def read_to_its_end(path: Path) -> Iterator[LiveRun]:
    run = LiveRun()
    with closing(TraceFile(path, run, path.parent)) as file:
        while file.poll():
            pass
        file.finish()
        yield run


def replace(path: Path, data: bytes) -> None:
    other = path.with_name("other")
    other.write_bytes(data)
    other.replace(path)


def test_blocks_that_do_not_exist() -> None:
    run = LiveRun()
    for number in (0, -1):
        with pytest.raises(IndexError):
            run.block(number)


def test_a_block_of_a_replaced_trace_is_an_error(tmp_path: Path) -> None:
    path, run = tmp_path / "trace.jsonl", LiveRun()
    path.write_bytes(encoded(records()))
    with closing(TraceFile(path, run)) as file:
        while file.poll():
            pass
        assert lines_of(run.block(0))
    with pytest.raises(OSError, match="replaced"):
        run.block(0)
