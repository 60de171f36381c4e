"""Goals of ROS actions.

An action is three services and a topic: `send_goal` takes a goal or rejects it, `get_result` responds when it has
ended, `cancel_goal` calls it off, and `feedback` tells of it on the way. A goal is known by 16 random bytes, which
the client draws. Whoever sends a goal is answerable for it: on every path on which it may have been accepted and
has not ended, it is canceled, and its end is waited for within a deadline.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

import anyio

from seoro.background import background
from seoro.bridges.ros2.clients.errors import GoalRejected
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Client
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.errors import BackendError, SeoroError
from seoro.runtime.contracts import GoalStatus
from seoro.runtime.ros_system import GoalResult

ANSWER_WITHIN = 10.0  # [s] until a server has accepted or rejected a goal
CANCEL_WITHIN = 2.0  # [s] for each step of calling a goal off: all of them fit into the clean-up of an action
FEEDBACK_DEPTH = 100
ENDS = {4: GoalStatus.SUCCEEDED, 5: GoalStatus.CANCELED, 6: GoalStatus.ABORTED}  # action_msgs/msg/GoalStatus
REFUSALS = {
    1: "it rejects that",
    2: "it does not know the goal",
    3: "the goal has ended",
}  # action_msgs/srv/CancelGoal
ENDED = 3


@dataclass(frozen=True)
class _Clients:
    """The clients of one action."""

    send: Client
    result: Client
    cancel: Client


class Goal:
    """A goal that its server has accepted. Made by `pursuing`.

    Args:
        number: By what it is known.
        clients: Of the action.
    """

    def __init__(self, number: bytes, clients: _Clients) -> None:
        self.number = number
        self._clients = clients
        self._end: asyncio.Future[GoalResult] = asyncio.get_running_loop().create_future()

    async def ended(self) -> GoalResult:
        """Wait for its end.

        Raises:
            BackendError: The server is gone, or says what it cannot say.
        """
        return await asyncio.shield(self._end)

    async def fetch(self) -> None:
        """Ask for its result, and wait for it."""
        try:
            response = await self._clients.result.call({"goal_id": {"uuid": list(self.number)}})
            status = ENDS.get(response.status)
            if status is None:
                raise BackendError(f"the server of {self._clients.result.service} does not know the goal any more")
        except SeoroError as error:
            if not self._end.done():
                self._end.set_exception(error)
                self._end.exception()  # whoever sent it may not wait for its end
        else:
            if not self._end.done():
                self._end.set_result(GoalResult(status, Members(response.result)))

    async def cancel(self) -> None:
        """Call it off, unless it has ended, and wait until it has; each within a deadline."""
        if self._end.done():
            return
        info = {"goal_id": {"uuid": list(self.number)}}
        response = await self._clients.cancel.call({"goal_info": info}, CANCEL_WITHIN)
        code = response.return_code
        if code and code != ENDED:
            raise BackendError(f"a goal cannot be canceled: {REFUSALS.get(code, f'return code {code}')}")
        with anyio.move_on_after(CANCEL_WITHIN), suppress(SeoroError):
            await self.fetch()  # what did so from the beginning has been cancelled, if the block was


@asynccontextmanager
async def pursuing(
    node: RosNode,
    action: str,
    type_name: str,
    goal: Mapping[str, Any],
    feedback: Callable[[Members], None],
    note: Callable[[str], None] | None = None,
    *,
    late: bool = False,
) -> AsyncIterator[Goal]:
    """Send a goal, and pursue it for as long as the block lasts; if it has not ended then, it is canceled.

    Args:
        node: Who sends it.
        action: Name of the action.
        type_name: Its type.
        goal: The goal.
        feedback: Called with what the server tells on the way.
        note: Told that the goal cannot be canceled; without it, that is raised.
        late: Whether to ask for feedback that was published before.

    Raises:
        InvalidUse: The name, the type or the goal are wrong.
        GoalRejected: The server does not take it.
        CallFailed: The server does not respond.
    """
    action, type_name = node.resolve(action), node.system.types.canonical(type_name)
    node.system.types.encode(
        f"{type_name}_Goal", goal
    )  # so that what is wrong is said before anything is waited for
    async with AsyncExitStack() as stack:
        clients = await _clients(node, stack, action, type_name)
        durability = Durability.TRANSIENT_LOCAL if late else Durability.VOLATILE
        topic, message = f"{action}/_action/feedback", f"{type_name}_FeedbackMessage"
        told = node.subscribing(topic, message, Qos(durability=durability, depth=FEEDBACK_DEPTH))
        messages = await stack.enter_async_context(told)
        pursued = await _send(clients, goal, action)
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(pursued.fetch)
        tasks.start_soon(_listen, messages, pursued.number, feedback)
        try:
            yield pursued
        finally:
            with anyio.CancelScope(shield=True):
                await _cancel(pursued, note)


async def _cancel(goal: Goal, note: Callable[[str], None] | None) -> None:
    try:
        await goal.cancel()
    except SeoroError as error:
        if note is None:
            raise
        note(str(error))


async def _clients(node: RosNode, stack: AsyncExitStack, action: str, type_name: str) -> _Clients:
    """The clients of an action, once somebody serves it."""
    under = f"{action}/_action"
    clients = _Clients(
        await stack.enter_async_context(node.calling(f"{under}/send_goal", f"{type_name}_SendGoal")),
        await stack.enter_async_context(node.calling(f"{under}/get_result", f"{type_name}_GetResult")),
        await stack.enter_async_context(node.calling(f"{under}/cancel_goal", "action_msgs/srv/CancelGoal")),
    )
    await clients.send.wait_for_server()
    for client in (clients.result, clients.cancel):
        await client.wait_for_server(ANSWER_WITHIN)
    return clients


async def _send(clients: _Clients, goal: Mapping[str, Any], action: str) -> Goal:
    """Send a goal; if that is cancelled after it has been sent, it is called off."""
    number = secrets.token_bytes(16)
    request = {"goal_id": {"uuid": list(number)}, "goal": goal}
    sending = asyncio.ensure_future(clients.send.call(request, ANSWER_WITHIN))
    try:
        response = await asyncio.shield(sending)
    except asyncio.CancelledError:
        with anyio.CancelScope(shield=True), suppress(SeoroError):
            await _recall(sending, Goal(number, clients))
        raise
    if not response.accepted:
        raise GoalRejected(f"the server of {action} rejects the goal")
    return Goal(number, clients)


async def _recall(sending: asyncio.Future[Any], goal: Goal) -> None:
    """Call a goal off of which it is not known whether the server has accepted it."""
    with anyio.move_on_after(CANCEL_WITHIN):
        if not (await sending).accepted:
            return
    sending.cancel()
    async with background() as tasks:
        tasks.start_soon(goal.fetch)
        await goal.cancel()


async def _listen(messages: Subscription, number: bytes, feedback: Callable[[Members], None]) -> None:
    """Pass on what is told of a goal, and not what is told of others."""
    async for received in messages:
        message = messages.decode(received)
        if bytes(message.goal_id.uuid) == number:
            feedback(Members(message.feedback))
