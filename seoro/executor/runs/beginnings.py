"""Scenarios and robots of runs, from the beginnings of their traces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from seoro.bridges.executor.messages import RunInfo
from seoro.executor.storage.run_folder import RunFolder
from seoro.files.inputs import Kind, open_input
from seoro.traces.edges import read_robots, read_start

MOST_READ: Final = 50  # traces for one list; further ones are read for the next lists
MOST_KNOWN: Final = 2000
MOST_ROBOTS: Final = 20
_LONGEST: Final = 100  # [characters] of a name


class _Beginning(NamedTuple):
    scenario: str
    robots: tuple[str, ...]
    is_whole: bool  # whether it need not be read again


_UNKNOWN: Final = _Beginning("", (), is_whole=False)


class Beginnings:
    """Names of the scenarios and robots of runs, for lists.

    Args:
        folder: Returns the folder of a run.
    """

    def __init__(self, folder: Callable[[str], RunFolder]) -> None:
        self._folder = folder
        self._known: dict[str, _Beginning] = {}

    def add_to(self, runs: Sequence[RunInfo]) -> tuple[RunInfo, ...]:
        """Return runs with these names; blocks. They are empty for runs whose traces have no beginning yet."""
        unread = [info for info in runs if info.started is not None and not self._of(info).is_whole]
        for info in unread[:MOST_READ]:
            self._known[info.run] = self._read(info)
        while len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]
        return tuple(self._with_names(info) for info in runs)

    def _of(self, info: RunInfo) -> _Beginning:
        return self._known.get(info.run, _UNKNOWN)

    def _with_names(self, info: RunInfo) -> RunInfo:
        found = self._of(info)
        return info.model_copy(update={"scenario": found.scenario, "robots": found.robots})

    def _read(self, info: RunInfo) -> _Beginning:
        try:
            with open_input(self._folder(info.run).trace, Kind.TRACE) as file:
                start = read_start(file)
                robots = () if start is None else read_robots(file, start)
        except OSError:  # it was deleted, or has not begun
            start, robots = None, ()
        scenario = "" if start is None else str(start.get("scenario", ""))
        shown = tuple(map(_shortened, robots[:MOST_ROBOTS]))
        return _Beginning(
            _shortened(scenario), shown, is_whole=bool(shown) or info.state.is_final
        )  # a scene may follow


def _shortened(name: str) -> str:
    return name[:_LONGEST].encode("utf-8", "replace").decode()
