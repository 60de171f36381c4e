"""Trace as the data of a page, read in one pass, also while it grows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import IO, Any, Final

from pydantic_core import from_json

from seoro.report.blocks import KINDS, Blocks
from seoro.report.columns import integers, reals
from seoro.report.rows import Behaviors
from seoro.report.series import AllSeries
from seoro.report.strings import Strings
from seoro.report.tracks import MOST_ENTITIES, Tracks
from seoro.traces.reader import InvalidRecord, LineReader, Record

MOST_LISTED: Final = 2_000  # margins, and samples of coverage
MOST_LOGS: Final = 500  # first logs, for pages without JavaScript
MOST_PROBLEMS: Final = 20
_PIECE: Final = 1 << 18  # [bytes]
_MOST_SEQ: Final = 2**31  # so that they fit into a column
_LOG: Final = "log."  # prefix of kinds of logs, by level


@dataclass(slots=True)
class _Kind:
    """Reader of the records of one kind.

    Args:
        number: Number in `KINDS`.
        handle: Adds a record with its `seq`; None if it is in the blocks only.
        is_bulky: Whether records are left out of the blocks.
        count: Number of records.
    """

    number: int
    handle: Callable[[Record, int], None] | None = None
    is_bulky: bool = False
    count: int = 0


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
        self.event_times = reals()
        self.event_names = integers()
        self.event_seqs = integers()
        self._lines = LineReader(from_json)
        self._seq = -1
        self._has_scene = False
        self._kinds = {name: _Kind(number) for number, name in enumerate(KINDS)}
        handlers: dict[str, Callable[[Record, int], None]] = {
            "behavior.start": self.behaviors.start,
            "behavior.end": self.behaviors.end,
            "event": self._event,
            "variable": self.series.variable,
            "margin": lambda record, seq: _keep(self.margins, record, MOST_LISTED),
            "cover": lambda record, seq: _keep(self.samples, record, MOST_LISTED),
            "record": lambda record, seq: _keep(self.samples, record, MOST_LISTED),
            "run.end": self._end,
        }
        for name, handle in handlers.items():
            self._kinds[name].handle = handle
        bulky = {
            "scene": self._scene,
            "poses": self.tracks.poses,
            "path": self.tracks.path,
            "scan": self.tracks.scan,
        }
        self._kinds |= {name: _Kind(0, handle, is_bulky=True) for name, handle in bulky.items()}
        self._kinds["entity"] = _Kind(0, self._entity)

    @property
    def kinds(self) -> Counter[str]:
        """Number of records of each kind."""
        found: Counter[str] = Counter()
        for name, kind in self._kinds.items():
            if kind.count:
                found["log" if name.startswith(_LOG) else name] += kind.count
        return found

    def read(self, file: IO[bytes]) -> None:
        """Read a trace to its end."""
        while data := file.read(_PIECE):
            self.feed(data)
        self.finish()

    def feed(self, data: bytes) -> None:
        """Read the next piece of a trace, which may end anywhere. Lines are read when they are complete."""
        self._add(self._lines.feed(data))

    def finish(self) -> None:
        """Read the last line, and mark the trace as read to its end."""
        self._add(self._lines.finish())
        self.is_finished = True

    def _add(self, lines: Iterable[tuple[int, int, Record | InvalidRecord]]) -> None:
        if self.further_runs:
            return
        kinds, add, seq, latest, count = self._kinds, self.blocks.add, self._seq, self.time, self.count
        for start, end, record in lines:
            if isinstance(record, InvalidRecord):
                self._add_problem(record)
                continue
            name = record["kind"]
            if name == "run.start":
                if count:
                    self.further_runs = True
                    break
                self._begin(record)
            elif name == "log":
                _keep(self.logs, record, MOST_LOGS)
                name = _LOG + record["level"]
            kind = kinds.get(name)
            if kind is None:
                kind = kinds[name] = _Kind(0)
            number, time = record.get("seq"), record["t"]
            # Without numbers, and where they do not grow, records count on.
            seq = number if isinstance(number, int) and seq < number < _MOST_SEQ else seq + 1
            if time > latest:  # noqa: PLR1730 - faster than a call
                latest = time
            count += 1
            kind.count += 1
            if kind.handle is not None:
                kind.handle(record, seq)
            if not kind.is_bulky:
                add(start, end, seq, time, kind.number)
        self._seq, self.time, self.count = seq, latest, count

    def _add_problem(self, record: InvalidRecord) -> None:
        self.is_cut = self.is_cut or record.is_cut
        if len(self.problems) < MOST_PROBLEMS and not record.is_cut:
            self.problems.append(str(record))

    def _begin(self, record: Record) -> None:
        """Take the bulky sources and tree out of the first record, also in its block."""
        from json import dumps  # noqa: PLC0415 - for this record only

        sources, tree = record.pop("sources", None), record.pop("tree", None)
        self.sources = sources if isinstance(sources, list) else []
        self.tree = tree if isinstance(tree, list) else []
        self.start = record
        if sources or tree:
            self.blocks.head = dumps(record, ensure_ascii=False).encode()

    def _end(self, record: Record, seq: int) -> None:
        self.end = record

    def _scene(self, record: Record, seq: int) -> None:
        if not self._has_scene:
            self._has_scene = True
            before = [] if self.scene is None else self.scene["entities"]
            own = record.get("entities")
            self.scene = {**record, "entities": [*(own if isinstance(own, list) else []), *before]}

    def _entity(self, record: Record, seq: int) -> None:
        """Add an entity that was spawned, or the robot of a bridge, which has no scene."""
        entity = record.get("entity")
        if not isinstance(entity, dict):
            return
        known = [] if self.scene is None else self.scene["entities"]
        named = (each for each in known if isinstance(each, dict) and each.get("name") == entity.get("name"))
        before = next(named, None)
        if before is not None or len(known) < MOST_ENTITIES:
            others = [each for each in known if each is not before]
            self.scene = {**(self.scene or {}), "entities": [*others, _with_frames(entity, before, record)]}

    def _event(self, record: Record, seq: int) -> None:
        self.event_times.append(record["t"])
        self.event_names.append(self.strings.number(record["name"]))
        self.event_seqs.append(seq)
        self.series.event(record, seq)


def _with_frames(entity: Record, before: Record | None, record: Record) -> Record:
    """Return an entity with the times [s] from which its poses are in a frame, if that is not always `map`."""
    earlier = before.get("frames", []) if before is not None else []
    if "frame" not in entity and not earlier:
        return entity
    return {**entity, "frames": [*earlier, [record.get("time", record["t"]), entity.get("frame", "map")]]}


def _keep(records: list[Record], record: Record, most: int) -> None:
    if len(records) < most:
        records.append(record)
