"""Run on an executor, as seen by a client."""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, aclosing
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor, Unavailable
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bundle.paths import InvalidPath, check_path
from seoro.client.sending import check_emitting
from seoro.client.subscribing import open_subscription
from seoro.embed.arguments import AnyPath, to_path, to_text
from seoro.embed.run_end import Ended, InvalidEnd, unpack_end
from seoro.embed.subscriptions import CAPACITY, EventSubscription, OnFull, check_buffer
from seoro.errors import BackendError, BackendLost, BackendRefused, UsageError
from seoro.runtime.events.occurrence import Occurrence
from seoro.runtime.verdict import Verdict

WAIT: Final = 5.0  # [s] for new records; each request is a heartbeat of the client
SHORTEST_WAIT: Final = 0.05  # [s]


class RemoteRun:
    """A run on an executor. Made by `seoro.Client`.

    Args:
        executor: Executor of the run.
        info: State of the run.
        stop_if_lost: Time without this client after which the run is stopped [s]; None to continue.
    """

    def __init__(self, executor: Executor, info: RunInfo, stop_if_lost: float | None = None) -> None:
        self.executor = executor
        self.info = info
        self._stop_if_lost = stop_if_lost
        self._end = b""  # packed end, if received with the last records

    def __repr__(self) -> str:
        return f"<RemoteRun {self.id} of {self.info.file}: {self.state.value}>"

    def _repr_html_(self) -> str:
        """Return the run for notebooks, as it was last received."""
        from seoro.text.notebook import card  # noqa: PLC0415 - for notebooks only

        info = self.info
        duration = None if info.started is None or info.ended is None else f"{info.ended - info.started:.1f} s"
        facts = {
            "run": self.id,
            "reason": info.reason,
            "duration": duration,
            "waits for": info.waits,
            "place in the queue": info.place,
            "values": info.announcement,
            "submitted by": info.by,
        }
        return card(info.file, self.state.value, facts)

    @property
    def id(self) -> str:
        """Id of the run, for any client."""
        return self.info.run

    @property
    def state(self) -> State:
        """State of the run, when last received."""
        return self.info.state

    async def parts(
        self, printed: Callable[[bytes], object] | None = None
    ) -> AsyncIterator[tuple[RunInfo, list[dict[str, Any]]]]:
        """Yield the state of the run with new records; see `lines`."""
        async with aclosing(self.lines(printed)) as parts:
            async for info, lines in parts:
                yield info, _records(lines)

    async def lines(
        self, printed: Callable[[bytes], object] | None = None
    ) -> AsyncGenerator[tuple[RunInfo, bytes], None]:
        """Yield the state of the run with new lines of its trace, at each change, to its end.

        Args:
            printed: Called with new printed output of the run, before the part that came with it.

        Raises:
            BackendError: The executor does not answer, has deleted the run, or sends a changed trace.
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
                    yield self.info, new

    async def _news(self, at: int, printed_at: int | None) -> AsyncGenerator[wire.Records | wire.NewRecords, None]:
        """Yield the trace after a byte, with new lines for up to `WAIT`."""
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
        except Unavailable:  # `ask` reports that, and retries
            now = wire.AskRecords(run=self.id, at=at, keeps_alive=request.keeps_alive, printed_at=printed_at)
            answer: wire.Records = await self.executor.ask(wire.RECORDS, now)
            yield answer

    async def records(self) -> AsyncIterator[dict[str, Any]]:
        """Yield all records of the trace in order, as they are made.

        Raises:
            BackendError: As for `parts`.
        """
        async for _, records in self.parts():
            for record in records:
                yield record

    async def records_so_far(self) -> AsyncIterator[dict[str, Any]]:
        """Yield the existing records, without waiting for more.

        Raises:
            BackendError: As for `parts`.
        """
        async for lines in self.lines_so_far():
            for record in _records(lines):
                yield record

    async def lines_so_far(self) -> AsyncGenerator[bytes, None]:
        """Yield the existing lines of the trace, without waiting for more.

        Raises:
            BackendError: As for `parts`.
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
            yield found.lines

    def _check_trace(self, found: str) -> None:
        """Check the SHA-256 of the whole trace.

        Raises:
            BackendLost: The trace differs from the one that the executor has recorded.
        """
        if self.info.trace not in ("", found):
            raise BackendLost(
                f"the trace of the run {self.id} was changed after it was recorded: its SHA-256 is {found}, "
                f"expected {self.info.trace}. Repeat the run, and check who writes into the folder of executor "
                f"'{self.executor.name}'"
            )

    async def end(self) -> Ended:
        """Wait for the end of the run; returns it with all details.

        Raises:
            InvalidScenario, UsageError: The scenario was not run, for the same reasons as by `start`.
            BackendError: The verdict is missing: its process, its simulator or its executor died.
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
        """Wait for the verdict. Does not raise when the scenario fails.

        Raises:
            InvalidScenario, UsageError, BackendError: The run has no verdict; see `end`.
        """
        return (await self.end()).verdict

    async def stop(self, reason: str = "") -> None:
        """Stop the run; `result` waits for its clean-up. A finished run ignores this."""
        request = wire.StopRun(run=self.id, reason=to_text("reason", reason))
        self.info = await self.executor.ask(wire.STOP_RUN, request)

    def subscribe(
        self, event: str, *, capacity: int = CAPACITY, on_full: OnFull = "fail"
    ) -> AbstractAsyncContextManager[EventSubscription]:
        """Subscribe to an event while a block lasts: `async with run.subscribe("robot.arrived") as events`.

        The subscription receives every occurrence from the start of the run, in order; its iteration ends when the
        run is over. Unknown names are not detected: the declarations of the scenario are unknown here.

        Args:
            event: Name of the event: `go` or `x.end` of the entry scenario, `robot.arrived` of an actor, or as in
                traces.
            capacity: Number of buffered occurrences.
            on_full: Behavior when the buffer is full: `fail` raises `SubscriptionOverflow` where occurrences are
                missing, `drop_oldest` counts them in `lost`.

        Raises:
            UsageError: An argument is invalid, or impossible.
        """
        check_buffer(capacity, on_full, "a run on an executor does not wait for its clients")
        return open_subscription(self.records(), to_text("event", event), capacity, on_full)

    async def emit(self, event: str, /, **fields: object) -> Occurrence:
        """Emit an event that was declared with `external`, and wait until it has occurred, at the next instant.

        Requires the same role as `stop`.

        Args:
            event: Name of the event: `operator_ready` of the entry scenario, `robot.released` of an actor.
            fields: Arguments: numbers in SI base units, members of enumerations by name.

        Raises:
            UsageError: The event is unknown or not external, fields do not fit, the run has not started or is
                over, or the executor is too old.
            BackendError: The executor refuses it, or does not answer.
        """
        check_emitting(self.executor)
        request = wire.EmitEvent(
            run=self.id,
            emission=secrets.token_hex(16),
            event=to_text("event", event),
            fields=_packed_fields(event, fields),
            wait=WAIT,
        )
        try:
            while (found := await self.executor.ask(wire.EMIT_EVENT, request, WAIT)).time is None:
                pass
        except BackendRefused as refused:
            if refused.code == wire.NOT_EMITTED:
                raise UsageError(str(refused)) from None
            raise
        return Occurrence(found.time, found.name, json.loads(found.arguments))

    async def remove(self) -> None:
        """Delete the finished run and its files at the executor."""
        await self.executor.ask(wire.REMOVE_RUN, wire.OneRun(run=self.id))

    async def fetch(self, folder: AnyPath, elsewhere: Mapping[str, Path] = MappingProxyType({})) -> list[Path]:
        """Download the output files of the run; returns their local paths.

        Args:
            folder: Local folder.
            elsewhere: Other local paths of some files, by their paths in the output folder.

        Raises:
            UsageError: A file cannot be written.
            BackendError: The executor does not answer.
        """
        into = to_path("folder", folder)
        places = {each.path: into / each.path for each in await self.files()}
        return [await self.fetch_file(name, elsewhere.get(name, place)) for name, place in places.items()]

    async def files(self) -> tuple[wire.OutputInfo, ...]:
        """Return the paths and sizes of the output files of the run.

        Raises:
            BackendError: The executor does not answer, or names a file outside the output folder.
        """
        outputs = await self.executor.ask(wire.LIST_FILES, wire.OneRun(run=self.id))
        try:
            for each in outputs.files:
                check_path(each.path)
        except InvalidPath as error:
            raise BackendError(f"invalid file name from the executor: {error}") from error
        return outputs.files

    async def read_file(self, name: str) -> AsyncGenerator[bytes, None]:
        """Yield the parts of an output file of the run.

        Args:
            name: Path in the output folder of the run.

        Raises:
            BackendError: The file is unknown, or the executor does not answer.
        """
        offset = 0
        while data := (await self._part(name, offset)).data:
            yield data
            offset += len(data)

    async def fetch_file(self, name: str, path: AnyPath) -> Path:
        """Download one output file of the run.

        Args:
            name: Path in the output folder of the run.
            path: Local path.

        Raises:
            UsageError: The file cannot be written.
            BackendError: The file is unknown, or the executor does not answer.
        """
        to_text("name", name)
        path = to_path("path", path)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            async with await anyio.open_file(path, "wb") as file, aclosing(self.read_file(name)) as parts:
                async for data in parts:
                    await file.write(data)
        except OSError as error:
            raise UsageError(f"cannot write {path}: {error.strerror}") from error
        return path

    async def _part(self, name: str, offset: int) -> wire.FilePart:
        return await self.executor.ask(wire.READ_FILE, wire.ReadFile(run=self.id, path=name, offset=offset))


def _packed_fields(event: str, fields: Mapping[str, object]) -> bytes:
    try:
        packed = json.dumps(fields, allow_nan=False).encode()
    except (TypeError, ValueError) as error:
        raise UsageError(f"invalid fields of event `{event}`: {error}") from None
    if len(packed) > wire.MAX_FIELDS:
        raise UsageError(
            f"the fields of event `{event}` have {len(packed)} bytes; expected at most {wire.MAX_FIELDS}"
        )
    return packed


def _records(lines: bytes) -> list[dict[str, Any]]:
    try:
        return [json.loads(line) for line in lines.splitlines()]
    except ValueError as error:
        raise BackendError(f"invalid records from the executor: {error}") from error
