"""Trace as the data of a page, read in one pass, also while it grows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import IO, Any, Final

from seoro.report.blocks import Blocks
from seoro.report.columns import integers, reals
from seoro.report.rows import Behaviors
from seoro.report.series import AllSeries
from seoro.report.strings import Strings
from seoro.report.tracks import Tracks
from seoro.traces.reader import InvalidRecord, LineReader, Record

MOST_LISTED: Final = 2_000  # margins, and samples of coverage
MOST_LOGS: Final = 500  # first logs, for pages without JavaScript
MOST_PROBLEMS: Final = 20
_PIECE: Final = 1 << 18  # [bytes]


class Reading:
    """Data of a run, read from its trace.

    Attributes:
        start: Record `run.start` without sources and tree; None if missing.
        end: Record `run.end`; None for a killed or active run.
        scene: Record `scene`; None without a simulator.
        sources: Scenario files.
        tree: Static behaviors.
        time: Latest time [s].
        count: Number of records.
        logs: First logs.
        margins: Margins of checks.
        samples: Samples of coverage.
        problems: Texts about invalid lines.
        is_finished: Whether the trace was read to its end.
        is_cut: Whether its last line is incomplete.
        further_runs: Whether more runs follow in the file; they are not read.
    """

    def __init__(self) -> None:
        self.start: Record | None = None
        self.end: Record | None = None
        self.scene: Record | None = None
        self.sources: list[Any] = []
        self.tree: list[Any] = []
        self.time = 0.0
        self.count = 0
        self.logs: list[Record] = []
        self.margins: list[Record] = []
        self.samples: list[Record] = []
        self.problems: list[str] = []
        self.is_finished = False
        self.is_cut = False
        self.further_runs = False
        self.strings = Strings()
        self.behaviors = Behaviors(self.strings)
        self.series = AllSeries()
        self.tracks = Tracks()
        self.blocks = Blocks()
        self.kinds: Counter[str] = Counter()
        self.event_times = reals()
        self.event_names = integers()
        self.event_seqs = integers()
        self._lines = LineReader()
        self._seq = -1
        self._handlers: dict[str, Callable[[Record, int], None]] = {
            "behavior.start": self.behaviors.start,
            "behavior.end": self.behaviors.end,
            "event": self._event,
            "variable": lambda record, seq: self.series.variable(record),
            "log": lambda record, seq: _keep(self.logs, record, MOST_LOGS),
            "margin": lambda record, seq: _keep(self.margins, record, MOST_LISTED),
            "cover": lambda record, seq: _keep(self.samples, record, MOST_LISTED),
            "record": lambda record, seq: _keep(self.samples, record, MOST_LISTED),
            "run.end": self._end,
        }
        self._bulky: dict[str, Callable[[Record], None]] = {
            "scene": self._scene,
            "poses": self.tracks.poses,
            "path": self.tracks.path,
            "scan": self.tracks.scan,
        }

    def read(self, file: IO[bytes]) -> None:
        """Read a trace to its end."""
        while data := file.read(_PIECE):
            self.feed(data)
        self.finish()

    def feed(self, data: bytes) -> None:
        """Read the next piece of a trace, which may end anywhere. Lines are read when they are complete."""
        for line, record in self._lines.feed(data):
            self._add(line, record)

    def finish(self) -> None:
        """Read the last line, and mark the trace as read to its end."""
        for line, record in self._lines.finish():
            self._add(line, record)
        self.is_finished = True

    def _add(self, line: bytes, record: Record | InvalidRecord) -> None:
        if self.further_runs:
            return
        if isinstance(record, InvalidRecord):
            self.is_cut = self.is_cut or record.is_cut
            if len(self.problems) < MOST_PROBLEMS and not record.is_cut:
                self.problems.append(str(record))
            return
        kind: str = record["kind"]
        if kind == "run.start" and self.count:
            self.further_runs = True
            return
        found = record.get("seq")
        # Without numbers, and where they do not grow, records count on.
        seq = self._seq = found if isinstance(found, int) and self._seq < found < 2**31 else self._seq + 1
        self.count += 1
        self.time = max(self.time, record["t"])
        self.kinds[kind] += 1
        if (bulky := self._bulky.get(kind)) is not None:
            bulky(record)
            return
        text = self._begin(record, line) if kind == "run.start" else line
        if (handler := self._handlers.get(kind)) is not None:
            handler(record, seq)
        name = f"log.{record['level']}" if kind == "log" else kind
        self.blocks.add(text.rstrip(), seq, record["t"], name)

    def _begin(self, record: Record, line: bytes) -> bytes:
        """Take sources and tree out of the first record; returns its line without them."""
        from json import dumps  # noqa: PLC0415 - for this record only

        sources, tree = record.pop("sources", None), record.pop("tree", None)
        self.sources = sources if isinstance(sources, list) else []
        self.tree = tree if isinstance(tree, list) else []
        self.start = record
        return dumps(record, ensure_ascii=False).encode() if sources or tree else line

    def _end(self, record: Record, seq: int) -> None:
        self.end = record

    def _scene(self, record: Record) -> None:
        if self.scene is None:
            self.scene = record

    def _event(self, record: Record, seq: int) -> None:
        self.event_times.append(record["t"])
        self.event_names.append(self.strings.number(record["name"]))
        self.event_seqs.append(seq)
        self.series.event(record)


def _keep(records: list[Record], record: Record, most: int) -> None:
    if len(records) < most:
        records.append(record)
