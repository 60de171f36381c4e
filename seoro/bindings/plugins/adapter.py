"""Function of an action that runs an object of a class with `setup`, `execute`, `update` and `shutdown`.

The object lives in a thread, so that a blocking method stops nothing else. It is updated ten times per second of
the run's clock until its status is final. `shutdown` is called once, on every path. After a failure, a
cancellation or an exception, it is called at once. After a success it is called at the end of the run, since
what the object has started may continue.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Collection, Coroutine, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import field
from functools import partial
from typing import Any, Final

from seoro.bindings.plugins.calling import call_in_thread
from seoro.bindings.plugins.model import Blackboard, Clock, Logger, Model
from seoro.bindings.plugins.ros_node import ros_node
from seoro.bindings.plugins.values import passed
from seoro.errors import ActionFailed
from seoro.lang.frozen import Value
from seoro.lang.plan import ValueType
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.threads import ThreadContext, run_in_thread
from seoro.runtime.values.values import Actor

ACTOR: Final = "associated_actor"  # parameter of classes for the actor
PERIOD: Final = 0.1  # [s] between two updates
SHUTDOWN: Final = 10.0  # [s] for `shutdown`, beyond the grace period
_EXPECTED: Final = ("SUCCESS", "FAILURE", "RUNNING", "INVALID")


class ActionClass(Value):
    """Class that implements an action.

    Args:
        type: The class.
        action: Name of the action.
        constructor: Parameters of its constructor.
        executed: Parameters of its `execute`.
        variables: Variables of the actor, with their types.
        optional: Parameters that the class receives as None if they are empty.
    """

    type: type[Any]
    action: str
    constructor: tuple[str, ...]
    executed: tuple[str, ...]
    variables: Mapping[str, ValueType] = field(default_factory=dict)
    optional: frozenset[str] = frozenset()

    def values(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Convert the values of the parameters."""
        values = {name: passed(value) for name, value in fields.items()}
        return {name: None if name in self.optional and not value else value for name, value in values.items()}


def adapt(made: ActionClass) -> Callable[..., Coroutine[Any, Any, None]]:
    """Make the function that runs objects of a class."""

    async def run(ctx: ActionContext, *leading: Actor, **fields: Any) -> None:
        actor = leading[0] if leading else None
        driven = _Driven(made, ctx, actor, made.values(fields))
        ctx.extend_grace(SHUTDOWN)
        driven.node = await ros_node(ctx)
        kept = await ctx.keep(driven.shutting_down(), SHUTDOWN)
        try:
            await run_in_thread(ctx, driven.run)
        except BaseException:
            await kept.close()
            raise

    run.__name__, run.__qualname__, run.__module__ = (
        made.type.__name__,
        made.type.__qualname__,
        made.type.__module__,
    )
    return run


class _Driven:
    """Object of a class for one invocation.

    Args:
        made: The class.
        ctx: Context of the action.
        actor: Its actor, if any.
        arguments: Values of the parameters.
    """

    def __init__(
        self, made: ActionClass, ctx: ActionContext, actor: Actor | None, arguments: Mapping[str, Any]
    ) -> None:
        self._made = made
        self._name = ctx.label or made.action
        self._actor = actor
        self._arguments = dict(arguments)
        self._model = Model(self._name, actor, self._arguments, ctx.source)
        self._ctx = ctx
        self._loop = asyncio.get_running_loop()
        self._object: Any = None
        self._feedback = ""
        self._succeeded = False
        self.node: Any = None  # of rclpy

    @asynccontextmanager
    async def shutting_down(self) -> AsyncIterator[None]:
        """Call `shutdown` at the exit. Its exceptions do not replace those of the action."""
        yield
        shutdown = getattr(self._object, "shutdown", None)
        if not callable(shutdown):
            return
        try:
            await call_in_thread(partial(self._call, shutdown))
        except Exception as error:
            if self._succeeded:
                raise
            self._ctx.relay([f"`shutdown` raised {type(error).__name__}: {error}"], "warning")

    def run(self, ctx: ThreadContext) -> None:
        """Make the object, and update it until its status is final. Called in a thread.

        Raises:
            ActionFailed: Its status is a failure.
        """
        self._make(ctx)
        made = self._object
        is_tree = callable(getattr(made, "tick_once", None))
        try:
            if not is_tree and callable(getattr(made, "execute", None)):
                self._call(partial(made.execute, **self._given(self._made.executed)))
            while True:
                status = self._tree_status() if is_tree else self._status(self._call(made.update))
                self._report(ctx)
                if status == "SUCCESS":
                    self._succeeded = True
                    return
                if status != "RUNNING":
                    reason = f": {self._feedback}" if self._feedback else ""
                    raise ActionFailed(f"{self._made.type.__name__} returned {status}{reason}")
                ctx.sleep(PERIOD)
        except asyncio.CancelledError:
            if is_tree:
                self._call(partial(made.stop, type(made.status)["INVALID"]))
            raise

    def _make(self, ctx: ThreadContext) -> None:
        made = self._object = self._call(lambda: self._made.type(**self._given(self._made.constructor)))
        logger = Logger(partial(self._log, ctx))
        if callable(getattr(made, "_set_base_properities", None)):
            made._set_base_properities(self._name, self._model, logger)
        if self._actor is not None and self._made.variables:
            made.blackboard = Blackboard(ctx, self._actor, self._made.variables)
        if callable(getattr(made, "create_subtree", None)):
            self._call(made.create_subtree)
        folder = self._ctx.output_folder
        options = {
            "logger": logger,
            "input_dir": str(self._ctx.file.parent),
            "output_dir": str(folder) if folder is not None else None,
            "tick_period": PERIOD,
            "clock": Clock(lambda: ctx.now),
            "host_clock": Clock(time.monotonic),
            **({"node": self.node} if self.node is not None else {}),
        }
        nodes = made.iterate() if callable(getattr(made, "iterate", None)) else (made,)
        for node in list(nodes):
            if callable(getattr(node, "setup", None)):
                self._call(partial(node.setup, **options))

    def _given(self, names: Collection[str]) -> dict[str, Any]:
        actor = {ACTOR: passed(self._actor)} if self._actor is not None else {}
        return {name: value for name, value in {**self._arguments, **actor}.items() if name in names}

    def _log(self, ctx: ThreadContext, message: str, level: str = "info") -> None:
        """Write into the trace; also after the action, by `shutdown`."""
        if not ctx.cancelled:
            ctx.log(message, level)
            return
        with suppress(RuntimeError):  # the event loop may be closed, too
            self._loop.call_soon_threadsafe(self._ctx.relay, [message], level)

    def _tree_status(self) -> str:
        self._call(self._object.tick_once)
        return self._status(self._object.status)

    def _status(self, returned: Any) -> str:
        """Return the name of a status; an object may also keep it as its attribute `status`.

        Raises:
            TypeError: It is not a status.
        """
        status = getattr(self._object, "status", None) if returned is None else returned
        name = str(getattr(status, "name", status)).upper()
        if name not in _EXPECTED:
            raise TypeError(f"expected one of {', '.join(_EXPECTED)} from `update`, found {status!r}")
        return name

    def _report(self, ctx: ThreadContext) -> None:
        feedback = str(getattr(self._object, "feedback_message", "") or "")
        if feedback and feedback != self._feedback:
            self._log(ctx, feedback)
        self._feedback = feedback

    def _call(self, method: Callable[[], Any]) -> Any:
        """Call a method. Its own refusals are failures, all other exceptions are faults of the class.

        Raises:
            ActionFailed: It raised an `ActionError`.
        """
        try:
            return method()
        except Exception as error:
            if any(base.__name__ == "ActionError" for base in type(error).__mro__):
                raise ActionFailed(str(getattr(error, "msg", "") or error)) from error
            raise
