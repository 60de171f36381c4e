"""Goals of ROS actions.

An action is three services and a topic. `send_goal` accepts or rejects a goal, `get_result` responds at its end,
`cancel_goal` cancels it, and `feedback` reports progress. The client chooses the ID of its goal. It is
responsible for the goal: whenever the goal may be active, it is canceled, and its end is awaited within a
deadline. A goal that may continue is reported. If a server has not answered `send_goal` and does not know the goal
to cancel, it may accept the goal later. Such a goal is canceled like one that has lost its client
(`cancellation.py`).
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

import anyio

from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL, ENDED, UNKNOWN, is_rejected
from seoro.bridges.ros2.clients.goal_ids import new_goal_id
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.errors import GoalRejected
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Client
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.concurrency.background import background
from seoro.errors import BackendError, SeoroError
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.ros2 import GoalResult

ANSWER_TIMEOUT = 10.0  # [s] for a server to accept or reject a goal
CANCEL_TIMEOUT = 2.0  # [s] for each step of canceling a goal, so that all fit into the clean-up of an action
FEEDBACK_DEPTH = 100
FINAL = {4: GoalStatus.SUCCEEDED, 5: GoalStatus.CANCELED, 6: GoalStatus.ABORTED}  # action_msgs/msg/GoalStatus
Note = Callable[[str], None]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class UnsettledGoal:
    """A goal that may continue although it was canceled.

    Attributes:
        action: Full name of the action.
        goal_id: ID of the goal.
        is_lost: Whether its server was unreachable, or did not know the goal, and may still accept it.
    """

    action: str
    goal_id: bytes
    is_lost: bool


OnUnsettled = Callable[[UnsettledGoal], None]


@dataclass(frozen=True)
class _Clients:
    """Clients of the services of an action."""

    send: Client
    result: Client
    cancel: Client


class Goal:
    """A sent goal. Made by `sending_goal`.

    Args:
        goal_id: ID of the goal.
        clients: Clients of the action.

    Attributes:
        is_accepted: Whether the server has accepted the goal.
        is_reached: Whether the server has answered the request to cancel, and knew the goal.
        end: Final status and result, once the server has reported them.
    """

    def __init__(self, goal_id: bytes, clients: _Clients) -> None:
        self.goal_id = goal_id
        self._clients = clients
        self.is_accepted = False
        self.is_reached = True
        self.end: GoalResult | None = None
        self._end: asyncio.Future[GoalResult] = asyncio.get_running_loop().create_future()

    async def ended(self) -> GoalResult:
        """Wait for the end of the goal.

        Raises:
            BackendError: The server has disappeared, or has sent an invalid response.
        """
        return await asyncio.shield(self._end)

    async def fetch_result(self) -> None:
        """Request the result of the goal, and wait for it."""
        try:
            response = await self._clients.result.call({"goal_id": {"uuid": list(self.goal_id)}})
            status = FINAL.get(response.status)
            if status is None:
                raise BackendError(f"the server of {self._clients.result.service} does not know the goal any more")
        except SeoroError as error:
            if not self._end.done():
                self._end.set_exception(error)
                self._end.exception()  # the sender may not wait for the end
        else:
            self.end = GoalResult(status, Members(response.result))
            if not self._end.done():
                self._end.set_result(self.end)

    async def cancel(self) -> None:
        """Cancel the goal unless it has ended, and wait for its end, each within a deadline.

        Raises:
            BackendError: The goal may continue.
        """
        if self.end is not None:
            return
        info = {"goal_id": {"uuid": list(self.goal_id)}}
        self.is_reached = False
        response = await self._clients.cancel.call({"goal_info": info}, CANCEL_TIMEOUT)
        code = response.return_code
        if code == UNKNOWN and not self.is_accepted:
            raise BackendError("its server does not know it, and may accept it later")
        self.is_reached = True
        if code == UNKNOWN:
            return
        if is_rejected(response, self.goal_id):
            raise BackendError(f"its server rejects to cancel it{f' (return code {code})' if code else ''}")
        with anyio.move_on_after(CANCEL_TIMEOUT), suppress(SeoroError):
            await self.fetch_result()  # the first request may have been cancelled with the block
        if self.end is None and not (code == ENDED and self._end.done()):
            raise BackendError(f"its server has not reported its end within {CANCEL_TIMEOUT:g} s")


@asynccontextmanager
async def sending_goal(
    node: RosNode,
    action: str,
    type_name: str,
    goal: Mapping[str, Any],
    feedback: Callable[[Members], None],
    note: Note | None = None,
    on_unsettled: OnUnsettled = lambda _goal: None,
    *,
    late: bool = False,
) -> AsyncIterator[Goal]:
    """Send a goal; if it is still active at the end of the block, it is canceled.

    Args:
        node: Sending node.
        action: Name of the action.
        type_name: Type of the action.
        goal: Members of the goal.
        feedback: Called with feedback.
        note: Called if the goal cannot be canceled; None to raise an error instead, unless the block raised one.
        on_unsettled: Called with a goal that may continue, before that is reported.
        late: Whether to request feedback that was published before.

    Raises:
        UsageError: The name, the type or the goal is invalid.
        GoalRejected: The server rejects the goal.
        CallFailed: The server does not respond.
    """
    action, type_name = node.resolve(action), node.system.types.canonical(type_name)
    node.system.types.encode(f"{type_name}_Goal", goal)  # checks names and types before any wait
    async with AsyncExitStack() as stack:
        clients = await _clients(node, stack, action, type_name)
        durability = Durability.TRANSIENT_LOCAL if late else Durability.VOLATILE
        topic, message = f"{action}/_action/feedback", f"{type_name}_FeedbackMessage"
        subscribing = node.subscribing(topic, message, Qos(durability=durability, depth=FEEDBACK_DEPTH))
        messages = await stack.enter_async_context(subscribing)
        sent = Goal(new_goal_id(node.node.session), clients)
        await _send(clients, goal, action, sent, note or log.warning, on_unsettled)
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(sent.fetch_result)
        tasks.start_soon(_forward_feedback, messages, sent.goal_id, feedback, note or log.warning)
        on_problem = note
        try:
            yield sent
        except SeoroError:
            on_problem = note or log.warning  # the first error counts
            raise
        finally:
            with anyio.CancelScope(shield=True):
                await _cancel_unfinished(sent, action, on_problem, on_unsettled)


async def _cancel_unfinished(goal: Goal, action: str, note: Note | None, on_unsettled: OnUnsettled) -> None:
    """Cancel a goal, and report if it may continue."""
    try:
        await goal.cancel()
    except SeoroError as error:
        on_unsettled(UnsettledGoal(action, goal.goal_id, is_lost=not goal.is_reached))
        problem = f"the goal of {action} may continue: {error}"
        if note is None:
            raise BackendError(problem) from error
        note(problem)


async def _clients(node: RosNode, stack: AsyncExitStack, action: str, type_name: str) -> _Clients:
    """Return the clients of an action, once it has a server."""
    under = f"{action}/_action"
    clients = _Clients(
        await stack.enter_async_context(node.calling(f"{under}/send_goal", f"{type_name}_SendGoal")),
        await stack.enter_async_context(node.calling(f"{under}/get_result", f"{type_name}_GetResult")),
        await stack.enter_async_context(node.calling(f"{under}/cancel_goal", CANCEL_GOAL)),
    )
    await clients.send.wait_for_server()
    for client in (clients.result, clients.cancel):
        await client.wait_for_server(ANSWER_TIMEOUT)
    return clients


async def _send(
    clients: _Clients, members: Mapping[str, Any], action: str, goal: Goal, note: Note, on_unsettled: OnUnsettled
) -> None:
    """Send a goal; cancel the goal if the task is cancelled meanwhile, or if the server does not answer."""
    request = {"goal_id": {"uuid": list(goal.goal_id)}, "goal": members}
    sending = asyncio.ensure_future(clients.send.call(request, ANSWER_TIMEOUT))
    try:
        response = await asyncio.shield(sending)
    except asyncio.CancelledError:
        with anyio.CancelScope(shield=True):
            await _cancel_unacknowledged(sending, action, goal, note, on_unsettled)
        raise
    except BackendError:
        with anyio.CancelScope(shield=True):
            # The server may have accepted the goal without an answer.
            await _cancel_unfinished(goal, action, lambda _: None, on_unsettled)
        raise
    if not response.accepted:
        raise GoalRejected(f"the server of {action} rejects the goal")
    goal.is_accepted = True


async def _cancel_unacknowledged(
    sending: asyncio.Future[Any], action: str, goal: Goal, note: Note, on_unsettled: OnUnsettled
) -> None:
    """Cancel a goal that the server may have accepted."""
    with anyio.move_on_after(CANCEL_TIMEOUT), suppress(BackendError):  # without an answer, it may be accepted
        if not (await sending).accepted:
            return
        goal.is_accepted = True
    sending.cancel()
    async with background() as tasks:
        tasks.start_soon(goal.fetch_result)
        await _cancel_unfinished(goal, action, note, on_unsettled)


async def _forward_feedback(
    messages: Subscription, goal_id: bytes, feedback: Callable[[Members], None], note: Note
) -> None:
    async for _, message in messages.decoded(note):
        if bytes(message.goal_id.uuid) == goal_id:
            feedback(Members(message.feedback))
