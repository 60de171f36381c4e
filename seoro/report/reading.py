"""Trace as the data of a page, in one pass."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import IO, Any, Final

from seoro.report.blocks import Blocks
from seoro.report.columns import Packed, integers, reals
from seoro.report.rows import Behaviors
from seoro.report.series import AllSeries
from seoro.report.strings import Strings
from seoro.report.tracks import Tracks
from seoro.traces.reader import InvalidRecord, Record, read_lines

MOST_LISTED: Final = 2_000  # margins, and samples of coverage
MOST_LOGS: Final = 500  # first logs, for pages without JavaScript
MOST_PROBLEMS: Final = 20


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
        is_cut: Whether the last line is incomplete.
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
        self.is_cut = False
        self.further_runs = False
        self.strings = Strings()
        self.behaviors = Behaviors(self.strings)
        self.series = AllSeries()
        self.tracks = Tracks()
        self.blocks = Blocks()
        self.kinds: Counter[str] = Counter()
        self._event_times = reals()
        self._event_names = integers()
        self._event_seqs = integers()
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
        """Read a trace to its end, or to the start of a second run."""
        seq = -1
        for line, record in read_lines(file):
            if isinstance(record, InvalidRecord):
                self.is_cut = self.is_cut or record.is_cut
                if len(self.problems) < MOST_PROBLEMS and not record.is_cut:
                    self.problems.append(str(record))
                continue
            kind: str = record["kind"]
            found = record.get("seq")
            # Without numbers, and where they do not grow, records count on.
            seq = found if isinstance(found, int) and seq < found < 2**31 else seq + 1
            if kind == "run.start" and self.count:
                self.further_runs = True
                break
            self.count += 1
            self.time = max(self.time, record["t"])
            self.kinds[kind] += 1
            if (bulky := self._bulky.get(kind)) is not None:
                bulky(record)
                continue
            text = self._begin(record, line) if kind == "run.start" else line
            if (handler := self._handlers.get(kind)) is not None:
                handler(record, seq)
            name = f"log.{record['level']}" if kind == "log" else kind
            self.blocks.add(text.rstrip(), seq, record["t"], name)
        self.behaviors.close(self.time)

    def pack(self, packed: Packed) -> None:
        """Append the columns of behaviors, events and kinds of records."""
        self.behaviors.pack(packed)
        columns = ("t", self._event_times), ("name", self._event_names), ("seq", self._event_seqs)
        packed.add_all("events", columns)
        self.blocks.finish(packed)

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
        self._event_times.append(record["t"])
        self._event_names.append(self.strings.number(record["name"]))
        self._event_seqs.append(seq)
        self.series.event(record)


def _keep(records: list[Record], record: Record, most: int) -> None:
    if len(records) < most:
        records.append(record)
