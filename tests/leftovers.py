"""Checks that nothing of a run is left when it is over: no task, timer, subscription or resource."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import Any

import pytest

from seoro.runtime.kernel.channel import Channel, Receiver
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.timers import TimerQueue
from seoro.runtime.run import Execution
from seoro.runtime.verdict import Verdict

Tasks = list["asyncio.Task[Any]"]

_made_by_run: ContextVar[Tasks | None] = ContextVar("_made_by_run", default=None)


class Leftovers:
    """Records the timers, subscriptions and tasks of all runs, and checks each run when it is over."""

    def __init__(self) -> None:
        self.runs = 0
        self.tasks = 0  # of all runs
        self._queues: list[TimerQueue] = []
        self._timers: dict[Scheduler, TimerQueue] = {}
        self._attached: dict[tuple[Channel, Receiver], None] = {}

    def install(self, patch: pytest.MonkeyPatch) -> None:
        """Record and check the runs of this process."""
        make_queue, make_scheduler = TimerQueue.__init__, Scheduler.__init__
        attach, detach, run = Channel.attach, Channel.detach, Execution.run

        def queue_made(queue: TimerQueue) -> None:
            make_queue(queue)
            self._queues.append(queue)

        def scheduler_made(scheduler: Scheduler, *args: Any, **kwargs: Any) -> None:
            make_scheduler(scheduler, *args, **kwargs)
            self._timers[scheduler] = self._queues.pop()

        def attached(channel: Channel, receiver: Receiver) -> None:
            self._attached[channel, receiver] = None
            attach(channel, receiver)

        def detached(channel: Channel, receiver: Receiver) -> None:
            self._attached.pop((channel, receiver), None)
            detach(channel, receiver)

        async def checked_run(execution: Execution) -> Verdict:
            with _recorded_tasks() as tasks:
                try:
                    return await run(execution)
                finally:
                    self._check(execution, tasks)

        patch.setattr(TimerQueue, "__init__", queue_made)
        patch.setattr(Scheduler, "__init__", scheduler_made)
        patch.setattr(Channel, "attach", attached)
        patch.setattr(Channel, "detach", detached)
        patch.setattr(Execution, "run", checked_run)

    def _check(self, execution: Execution, tasks: Tasks) -> None:
        self.runs += 1
        self.tasks += len(tasks)
        assert [task for task in tasks if not task.done()] == [], "tasks are left"
        if execution.fault is not None:
            return  # a defect may keep the rest from being cleaned up
        services = execution._services
        timers = self._timers.pop(services.scheduler)
        left = {
            "timers": len(timers),
            "subscriptions": [c.name for c, _ in self._attached if c.scheduler is services.scheduler],
            "waits": list(services.waits),
            "open-ended behaviors": list(services.open_ended),
            "overrides": list(services.overriding),
            "exclusive uses": [use for use, users in services.common.uses._queues.items() if users],
            "background resources": services.common.lasting._hosts,
        }
        assert not any(left.values()), f"something is left: {left}"


class _RecordingFactory:
    """A task factory that records the tasks that a run creates.

    Args:
        around: The factory that creates them; None for the default.
    """

    def __init__(self, around: Callable[..., Any] | None) -> None:
        self._around = around

    def __call__(self, loop: asyncio.AbstractEventLoop, coroutine: Any, **options: Any) -> asyncio.Task[Any]:
        make = self._around or _make_task
        task: asyncio.Task[Any] = make(loop, coroutine, **options)
        context = options.get("context") or copy_context()
        if _made_by_run in context and (made := context[_made_by_run]) is not None:
            made.append(task)
        return task


def _make_task(loop: asyncio.AbstractEventLoop, coroutine: Any, **options: Any) -> asyncio.Task[Any]:
    return asyncio.Task(coroutine, loop=loop, **options)


@contextmanager
def _recorded_tasks() -> Iterator[Tasks]:
    """Within the block, record the tasks that are created in it, and by these, at any remove."""
    loop = asyncio.get_running_loop()
    if not isinstance(loop.get_task_factory(), _RecordingFactory):
        loop.set_task_factory(_RecordingFactory(loop.get_task_factory()))
    tasks: Tasks = []
    token = _made_by_run.set(tasks)
    try:
        yield tasks
    finally:
        _made_by_run.reset(token)


@pytest.fixture(autouse=True)
def leftovers(monkeypatch: pytest.MonkeyPatch) -> Leftovers:
    """Checks every run of a test when it is over. To be imported where it is to be used."""
    found = Leftovers()
    found.install(monkeypatch)
    return found
