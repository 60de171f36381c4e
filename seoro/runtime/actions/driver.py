"""Driver of an action's coroutine; it notifies the scheduler when the action waits for the outside world.

An action is ordinary asyncio code. Its awaits surface here as futures. For a future of the scheduler,
the task is parked already; otherwise the task is outside until the future is done.

A cancellation is thrown into the action once. Everything that it awaits after that, in `finally` blocks and exits
of `async with`, is its clean-up: it is driven as before, within a grace period of the machine's clock.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Generator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, cast

from seoro.lang.plan import InvokeAction
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.outside import wait_outside
from seoro.runtime.execution.blocking import Meter, place_of_thread
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.functions.actions import BoundAction
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.values import Actor, Value
from seoro.runtime.verdict import RunStatus


class ActionDriver:
    """Awaitable that runs an action to its end; it reports blocking code and overruns of the clean-up.

    After an overrun the action is cancelled again, and abandoned after another grace period.

    Args:
        bound: The action.
        instance: Its instance, with the values of its parameters.
        plan: Its invocation.
        context: Context of the invocation.
    """

    __slots__ = ("_bound", "_context", "_coroutine", "_ctx", "_deadline", "_meter", "_overruns", "_plan", "_task")

    def __init__(
        self, bound: BoundAction, instance: Instance, plan: InvokeAction, context: ExecutionContext
    ) -> None:
        self._bound = bound
        self._plan = plan
        self._context = context
        self._task = context.task
        common = context.services.common
        # No reference back to this object, so that it is freed without the garbage collector.
        self._meter = Meter(common.share, partial(common.warn_of_blocking, plan.action, plan.span))
        self._ctx = ActionContext(context, plan, self._meter)
        self._coroutine = call_action(bound, self._ctx, instance.actor, instance.fields)
        self._meter.attach(self._coroutine)
        self._deadline: asyncio.TimerHandle | None = None
        self._overruns = 0

    def __await__(self) -> Generator[Any, None, None]:
        error: BaseException | None = None
        self._task.on_cancel = self._cancelled
        try:
            while True:
                try:
                    awaited = self._resume(error)
                except StopIteration:
                    return
                error = yield from wait_outside(self._context.scheduler, self._task, awaited)
        except BaseException:
            with suppress(RuntimeError):  # an abandoned coroutine may ignore this too
                self._coroutine.close()
            raise
        finally:
            self._task.on_cancel = None
            if self._deadline is not None:
                self._deadline.cancel()

    def _resume(self, error: BaseException | None) -> Any:
        if error is not None and self._overruns > 1:
            raise error
        self._meter.begin()
        try:
            return self._coroutine.send(None) if error is None else self._coroutine.throw(error)
        finally:
            self._meter.end()

    def _give_up(self) -> None:
        """End the run as an error because the clean-up takes too long, and cancel the action again."""
        self._overruns += 1
        name, ctx = self._plan.action, self._ctx
        text = f"the clean-up of `{name}` took longer than {ctx.grace:g} s"
        where = self._meter.place
        if ctx.thread is not None:
            text = f"the thread of `{name}` has not ended {ctx.grace:g} s after it was cancelled"
            where = place_of_thread(ctx.thread, self._bound.function)
        self._task.overran = True
        text = f"{text}; it is at {where}" if where else text
        self._context.services.decide(RunStatus.ERROR, text, self._plan.span)
        self._context.scheduler.deliver_cancel(self._task)
        self._set_deadline()

    def _cancelled(self) -> None:
        """Start the grace period when the cancellation is delivered, possibly without a step here."""
        if self._deadline is None:
            self._set_deadline()
            self._context.services.trace.record("behavior.cancel", self._task.past.cause, id=self._context.number)

    def _set_deadline(self) -> None:
        self._deadline = asyncio.get_running_loop().call_later(self._ctx.grace, self._give_up)


def call_action(
    bound: BoundAction, context: ActionContext, actor: Actor | None, fields: Mapping[str, Value]
) -> Coroutine[Any, Any, None]:
    """Call the function of an action. Values refused by the types of the function are a fault of the function.

    Args:
        bound: The action.
        context: Context of the invocation.
        actor: Actor of the invocation, if it has one.
        fields: Values of the parameters; others are ignored.
    """
    converted = {name: convert(fields[name]) for name, convert in bound.converters.items()}
    leading = (actor,) if bound.declaration.has_actor else ()
    if bound.mark.thread:
        from seoro.runtime.actions.threads import run_in_thread  # noqa: PLC0415 - few actions have threads

        return run_in_thread(context, lambda inside: bound.function(inside, *leading, **converted))
    # It is `async`: checked when the scenario was loaded.
    return cast(Coroutine[Any, Any, None], bound.function(context, *leading, **converted))
