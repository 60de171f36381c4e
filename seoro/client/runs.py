"""A run on an executor, as a client sees it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Mapping
from contextlib import aclosing
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor, Unavailable
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bundle.places import InvalidPlace, check_place
from seoro.embed.arguments import AnyPath, to_path, to_text
from seoro.embed.ends import Ended, InvalidEnd, unpack_end
from seoro.errors import BackendError, BackendLost, InvalidUse
from seoro.runtime.verdict import Verdict

WAIT: Final = 5.0  # [s] for what comes next; with every question, the executor knows that somebody is there
SHORTEST_WAIT: Final = 0.05  # [s]


class RemoteRun:
    """A run on an executor. Made by `seoro.Client`.

    Args:
        executor: Where it is.
        info: What is known of it.
        stop_if_lost: [s] without this client after which it is stopped; None if it goes on.
    """

    def __init__(self, executor: Executor, info: RunInfo, stop_if_lost: float | None = None) -> None:
        self.executor = executor
        self.info = info
        self._stop_if_lost = stop_if_lost
        self._end = b""  # what it ended with, if that came with its last records

    @property
    def id(self) -> str:
        """Its id, which any client can find it by."""
        return self.info.run

    @property
    def state(self) -> State:
        """What has become of it, when that was last asked for."""
        return self.info.state

    async def parts(
        self, printed: Callable[[bytes], object] | None = None
    ) -> AsyncIterator[tuple[RunInfo, list[dict[str, Any]]]]:
        """What is known of the run and the records that are new, whenever one of them has changed, to its end.

        Args:
            printed: Called with what the process of the run has printed, before the part with which that came.

        Raises:
            BackendError: The executor is gone, has forgotten the run, or sends another trace than it has recorded.
        """
        at, is_complete, trace = 0, False, hashlib.sha256()
        printed_at = None if printed is None else 0
        while not is_complete:
            async with aclosing(self._news(at, printed_at)) as news:
                async for found in news:
                    start = found.at - len(found.lines)
                    if start > at:
                        break  # a part got lost
                    new = found.lines[at - start :]
                    at += len(new)
                    trace.update(new)
                    if isinstance(found, wire.Records):
                        self.info, self._end = found.info, found.end
                        is_complete = found.is_complete and at == found.at
                        if is_complete:
                            self._check_trace(trace.hexdigest())
                        if printed is not None and printed_at is not None and found.printed:
                            printed(found.printed)
                            printed_at += len(found.printed)
                    yield self.info, _records(new)

    async def _news(self, at: int, printed_at: int | None) -> AsyncGenerator[wire.Records | wire.NewRecords, None]:
        """What the executor has after a byte of the trace, or what comes then, for a while."""
        allowed = self._stop_if_lost
        wait = WAIT if allowed is None else min(WAIT, max(allowed / 3.0, SHORTEST_WAIT))
        request = wire.AskRecords(
            run=self.id,
            at=at,
            state=self.info.state,
            is_announced=bool(self.info.announcement),
            waits=self.info.waits,
            wait=wait,
            keeps_alive=allowed is not None,
            printed_at=printed_at,
            in_parts=True,
        )
        try:
            asked = self.executor.ask_in_parts(wire.RECORDS, wire.NewRecords, request, wait)
            async with aclosing(asked) as parts:
                async for found in parts:
                    yield found
        except Unavailable:  # `ask` tells of that, and asks again and again
            now = wire.AskRecords(run=self.id, at=at, keeps_alive=request.keeps_alive, printed_at=printed_at)
            answer: wire.Records = await self.executor.ask(wire.RECORDS, now)
            yield answer

    async def records(self) -> AsyncIterator[dict[str, Any]]:
        """The records of its trace, from the first to the last, as they come; each once, in their order.

        Raises:
            BackendError: As `parts`.
        """
        async for _, records in self.parts():
            for record in records:
                yield record

    async def records_so_far(self) -> AsyncIterator[dict[str, Any]]:
        """The records that there are, without waiting for more.

        Raises:
            BackendError: As `parts`.
        """
        at, trace = 0, hashlib.sha256()
        while True:
            found = await self.executor.ask(wire.RECORDS, wire.AskRecords(run=self.id, at=at))
            self.info, at = found.info, found.at
            trace.update(found.lines)
            if found.is_complete:
                self._check_trace(trace.hexdigest())
            if not found.lines:
                return
            for record in _records(found.lines):
                yield record

    def _check_trace(self, found: str) -> None:
        """Check the SHA-256 of its whole trace.

        Raises:
            BackendLost: It is not that of the trace that its executor has recorded.
        """
        if self.info.trace not in ("", found):
            raise BackendLost(
                f"the trace of the run {self.id} was changed after it was recorded: its SHA-256 is {found}, and "
                f"not {self.info.trace}. Repeat the run, and find out who writes in the folder of "
                f"the executor '{self.executor.name}'"
            )

    async def end(self) -> Ended:
        """How it ended, with all that a program needs to show it; waits for that.

        Raises:
            InvalidScenario, InvalidUse: It was not run; as `start` would have raised it here.
            BackendError: There is no verdict: its process, its simulator or its executor has died.
        """
        if not self.state.is_final:
            async for _ in self.parts():
                pass
        if not self._end:
            found = await self.executor.ask(wire.GET_RUN, wire.OneRun(run=self.id))
            self.info, self._end = found.info, found.end
        if not self._end:
            raise BackendLost(f"the run is {self.state.value}: {self.info.reason}")
        try:
            end = unpack_end(self._end)
        except InvalidEnd as error:
            raise BackendError(str(error)) from error
        if isinstance(end, Ended):
            return end
        raise end.error

    async def result(self) -> Verdict:
        """The verdict, which is waited for. Does not raise when the scenario fails.

        Raises:
            InvalidScenario, InvalidUse, BackendError: There is none; see `end`.
        """
        return (await self.end()).verdict

    async def stop(self, reason: str = "") -> None:
        """Ask it to stop; it cleans up, which `result` waits for. Of no effect when it is over."""
        request = wire.StopRun(run=self.id, reason=to_text("reason", reason))
        self.info = await self.executor.ask(wire.STOP_RUN, request)

    async def remove(self) -> None:
        """Have the executor forget it; it must be over."""
        await self.executor.ask(wire.REMOVE_RUN, wire.OneRun(run=self.id))

    async def fetch(self, folder: AnyPath, elsewhere: Mapping[str, Path] = MappingProxyType({})) -> list[Path]:
        """Bring what it has left in its output folder into one of ours; returns the files.

        Args:
            folder: Ours.
            elsewhere: Files that go elsewhere, by their paths in its folder.

        Raises:
            InvalidUse: They cannot be written.
            BackendError: The executor is gone.
        """
        into = to_path("folder", folder)
        outputs = await self.executor.ask(wire.LIST_FILES, wire.OneRun(run=self.id))
        try:
            places = {each.path: into / check_place(each.path) for each in outputs.files}
        except InvalidPlace as error:
            raise BackendError(f"the executor names a file that cannot be: {error}") from error
        return [await self.fetch_file(name, elsewhere.get(name, place)) for name, place in places.items()]

    async def fetch_file(self, name: str, path: AnyPath) -> Path:
        """Bring one file that it has left.

        Args:
            name: Its path in the output folder of the run.
            path: Where to.

        Raises:
            InvalidUse: It cannot be written.
            BackendError: There is none, or the executor is gone.
        """
        to_text("name", name)
        path = to_path("path", path)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            async with await anyio.open_file(path, "wb") as file:
                offset = 0
                while data := (await self._part(name, offset)).data:
                    await file.write(data)
                    offset += len(data)
        except OSError as error:
            raise InvalidUse(f"cannot write {path}: {error.strerror}") from error
        return path

    async def _part(self, name: str, offset: int) -> wire.FilePart:
        return await self.executor.ask(wire.READ_FILE, wire.ReadFile(run=self.id, path=name, offset=offset))


def _records(lines: bytes) -> list[dict[str, Any]]:
    try:
        return [json.loads(line) for line in lines.splitlines()]
    except ValueError as error:
        raise BackendError(f"the executor sent records that are none: {error}") from error
