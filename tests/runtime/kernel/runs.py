"""Runs of tasks on the kernel alone, without a scenario."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from typing import Any

from seoro.runtime.kernel.clock import Clock, VirtualClock
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task, TaskFunction

LIMIT = 20.0  # [s] of the machine's clock; a run that hangs takes longer


async def run(function: TaskFunction, *args: Any, clock: Clock | None = None, **options: Any) -> Task:
    """Run a root task to its end, and return it.

    Args:
        function: Function of the root task.
        args: Arguments of the function.
        clock: Clock of the run; by default, a virtual clock.
        options: Options of the scheduler.
    """
    scheduler = Scheduler(clock or VirtualClock(), **options)
    root = scheduler.start_root(function, *args)
    async with asyncio.timeout(LIMIT):
        await scheduler.run()
    return root


def scheduler_of(task: Task) -> Scheduler:
    """Return the scheduler of a task."""
    assert isinstance(task.scheduler, Scheduler)
    return task.scheduler


async def outside(task: Task, awaitable: Awaitable[Any]) -> None:
    """Await something of the outside world in a task."""
    scheduler, future = scheduler_of(task), asyncio.ensure_future(awaitable)
    scheduler.leave(task, future)
    try:
        await future
        await scheduler.readmit(task)
    finally:
        task.parked, task.cancel_seen_next = None, False


def other_tasks() -> set[asyncio.Task[Any]]:
    """Return the running asyncio tasks except the current one."""
    current = asyncio.current_task()
    return {task for task in asyncio.all_tasks() if task is not current}
