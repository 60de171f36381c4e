"""Scheduling of checks: shortly after the last change, or immediately if a request needs the result.

All state belongs to the event loop. One thread checks immutable texts; the loop stores the results, and reports
them only if the texts are still current.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from seoro.lsp.analysis import Analysis, CheckCache, analyse
from seoro.lsp.documents import Documents

DELAY = 0.15  # [s] from the last change to the check
logger = logging.getLogger(__name__)
T = TypeVar("T")


@dataclass(eq=False)
class _State:
    """State of an open document.

    `wanted` is the number of the last change that affects it, `known` that of the last checked one.
    """

    wanted: int = 0
    known: int = 0
    latest: Analysis | None = None
    good: Analysis | None = None  # the latest without syntax errors
    memory: CheckCache = field(default_factory=CheckCache)
    timer: asyncio.TimerHandle | None = None
    lock: asyncio.Lock = field(default_factory=asyncio.Lock)


class Analyst:
    """Keeps the analyses of open documents up to date.

    Args:
        documents: The open documents.
        found: Called with each analysis of a document's current text.
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, documents: Documents, found: Callable[[Analysis], None], strict: bool) -> None:
        self._documents = documents
        self._found = found
        self._strict = strict
        self._states: dict[Path, _State] = {}
        self._changes = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self._worker = ThreadPoolExecutor(1, "analysis")

    def changed(self, path: Path) -> None:
        """Schedule checks of a changed document and of its importers."""
        for other in self._documents.paths:
            state = self._states.get(other)
            if other == path or state is None or state.latest is None or path in state.latest.files.by_path:
                self._schedule(other)

    def changed_all(self) -> None:
        """Schedule checks of all documents, after files were created or deleted."""
        for path in [path for path in self._states if self._documents.at(path) is None]:
            timer = self._states.pop(path).timer
            if timer is not None:
                timer.cancel()
        for path in self._documents.paths:
            self._schedule(path)

    def _schedule(self, path: Path) -> None:
        state = self._states.setdefault(path, _State())
        self._changes += 1
        state.wanted = self._changes
        if state.timer is not None:
            state.timer.cancel()
        state.timer = asyncio.get_running_loop().call_later(DELAY, self._start, path)

    def _start(self, path: Path) -> None:
        task = asyncio.get_running_loop().create_task(self._check_quietly(path))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _check_quietly(self, path: Path) -> None:
        try:
            await self._check(path)
        except Exception:  # a bug of the checker: the next change tries again
            logger.exception("cannot check %s", path)

    async def _check(self, path: Path) -> None:
        """Check the current text, unless it has been checked."""
        state = self._states.get(path)
        if state is None:
            return
        number = state.wanted
        async with state.lock:
            if state.known >= number:
                return
            number = state.wanted
            texts = self._documents.texts
            analysis = await self.run(lambda: analyse(path, texts, self._strict, state.memory))
            state.known, state.latest = number, analysis
            if not analysis.has_syntax_errors:
                state.good = analysis
        if state.known == state.wanted and self._states.get(path) is state:
            self._found(analysis)

    async def run(self, work: Callable[[], T]) -> T:
        """Run a function on the thread of the checker."""
        return await asyncio.get_running_loop().run_in_executor(self._worker, work)

    async def current(self, path: Path) -> Analysis | None:
        """Return the analysis of a document's current text, with its index; None if it is not open."""
        await self._check(path)
        state = self._states.get(path)
        analysis = state.latest if state is not None else None
        if analysis is not None:
            await self.run(lambda: analysis.index)
        return analysis

    async def recent(self, path: Path) -> Sequence[Analysis]:
        """Return the latest analysis of a document, and the latest one without syntax errors."""
        state = self._states.get(path)
        if state is not None and state.latest is None:
            await self._check(path)
        if state is None or state.latest is None:
            return ()
        if state.good is None or state.good is state.latest:
            return (state.latest,)
        return state.latest, state.good

    @property
    def analyses(self) -> tuple[Analysis, ...]:
        """Return the latest analyses of all documents."""
        return tuple(state.latest for state in self._states.values() if state.latest is not None)

    async def all_current(self) -> tuple[Analysis, ...]:
        """Return the analyses of the current texts of all documents."""
        for path in self._documents.paths:
            await self._check(path)
        return self.analyses

    def close(self) -> None:
        """Cancel pending checks."""
        self._worker.shutdown(wait=False, cancel_futures=True)
