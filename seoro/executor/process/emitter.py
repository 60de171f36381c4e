"""Emitter of the events that clients send to a run, in its process."""

from __future__ import annotations

import json
from collections.abc import Callable

from anyio.abc import TaskGroup

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import decode, encode
from seoro.embed.runs import Run
from seoro.errors import UsageError
from seoro.runtime.trace.jsonl import to_json


class Emitter:
    """Emits the requested events in a run.

    Args:
        run: The run.
        tasks: Task group for emissions, which wait for their instants.
        report: Sends the outcome of an emission to the executor.
    """

    def __init__(self, run: Run, tasks: TaskGroup, report: Callable[[bytes], object]) -> None:
        self._run = run
        self._tasks = tasks
        self._report = report

    def emit(self, data: bytes) -> None:
        """Emit the event of an encoded `messages.EmitEvent`."""
        self._tasks.start_soon(self._emit, decode(wire.EmitEvent, data))

    async def _emit(self, request: wire.EmitEvent) -> None:
        try:
            found = await self._run.emit(request.event, **_fields(request))
        except UsageError as error:
            emitted = wire.Emitted(emission=request.emission, refused=_text(error))
        else:
            shown = to_json(dict(found.arguments)).encode()
            emitted = wire.Emitted(emission=request.emission, time=found.time, name=found.name, arguments=shown)
        self._report(encode(emitted))


def _fields(request: wire.EmitEvent) -> dict[str, object]:
    """Return the arguments of an event.

    Raises:
        UsageError: The arguments are not a JSON object.
    """
    try:
        fields = json.loads(request.fields)
    except (ValueError, RecursionError) as error:
        raise UsageError(f"invalid fields of event `{request.event}`: {error}") from None
    if not isinstance(fields, dict):
        raise UsageError(f"invalid fields of event `{request.event}`: expected a JSON object")
    return fields


def _text(error: UsageError) -> str:
    return f"{error.message} (help: {error.help})" if error.help else error.message
