"""Goals of ROS actions.

An action is three services and a topic: `send_goal` takes a goal or rejects it, `get_result` responds when it has
ended, `cancel_goal` calls it off, and `feedback` tells of it on the way. A goal is known by 16 random bytes, which
the client draws. Whoever sends a goal is answerable for it: on every path on which it may have been accepted and
has not ended, it is canceled, and its end is waited for within a deadline. That it may go on nevertheless is told.
A server that has not said whether it takes a goal, and does not know it when that is to be canceled, may take it
later: such a goal may go on, and is called off as one of which its sender has lost sight (`recall.py`).
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

import anyio

from seoro.background import background
from seoro.bridges.ros2.clients.errors import GoalRejected
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.clients.numbers import new_number
from seoro.bridges.ros2.clients.recall import CANCEL_GOAL, ENDED, UNKNOWN, is_rejected
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Client
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.errors import BackendError, InvalidUse, SeoroError
from seoro.runtime.contracts import GoalStatus
from seoro.runtime.ros_system import GoalResult

ANSWER_WITHIN = 10.0  # [s] until a server has accepted or rejected a goal
CANCEL_WITHIN = 2.0  # [s] for each step of calling a goal off: all of them fit into the clean-up of an action
FEEDBACK_DEPTH = 100
ENDS = {4: GoalStatus.SUCCEEDED, 5: GoalStatus.CANCELED, 6: GoalStatus.ABORTED}  # action_msgs/msg/GoalStatus
Note = Callable[[str], None]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Doubt:
    """A goal that was called off, and may go on.

    Attributes:
        action: Full name of the action.
        number: The goal.
        is_lost: Whether its server could not be told, or did not know it then, and may have taken it or take it.
    """

    action: str
    number: bytes
    is_lost: bool


Doubtful = Callable[[Doubt], None]


@dataclass(frozen=True)
class _Clients:
    """The clients of one action."""

    send: Client
    result: Client
    cancel: Client


class Goal:
    """A goal that has been sent. Made by `pursuing`.

    Args:
        number: By what it is known.
        clients: Of the action.

    Attributes:
        is_accepted: Whether its server has said that it takes it.
        is_reached: Whether its server has answered when it was to be canceled, and knew it.
        end: Status and result with which it has ended, once its server has reported them.
    """

    def __init__(self, number: bytes, clients: _Clients) -> None:
        self.number = number
        self._clients = clients
        self.is_accepted = False
        self.is_reached = True
        self.end: GoalResult | None = None
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
            self.end = GoalResult(status, Members(response.result))
            if not self._end.done():
                self._end.set_result(self.end)

    async def cancel(self) -> None:
        """Call it off, unless it has ended, and wait until it has; each within a deadline.

        Raises:
            BackendError: It may go on.
        """
        if self.end is not None:
            return
        info = {"goal_id": {"uuid": list(self.number)}}
        self.is_reached = False
        response = await self._clients.cancel.call({"goal_info": info}, CANCEL_WITHIN)
        code = response.return_code
        if code == UNKNOWN and not self.is_accepted:
            raise BackendError("its server does not know it, and may take it later")
        self.is_reached = True
        if code == UNKNOWN:
            return
        if is_rejected(response, self.number):
            raise BackendError(f"its server rejects to cancel it{f' (return code {code})' if code else ''}")
        with anyio.move_on_after(CANCEL_WITHIN), suppress(SeoroError):
            await self.fetch()  # what did so from the beginning has been cancelled, if the block was
        if self.end is None and not (code == ENDED and self._end.done()):
            raise BackendError(f"its server has not said within {CANCEL_WITHIN:g} s that it has ended")


@asynccontextmanager
async def pursuing(
    node: RosNode,
    action: str,
    type_name: str,
    goal: Mapping[str, Any],
    feedback: Callable[[Members], None],
    note: Note | None = None,
    doubtful: Doubtful = lambda _doubt: None,
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
        note: Told that the goal cannot be canceled; without it, that is raised, if nothing went wrong before.
        doubtful: Called with a goal that may go on, before that is told.
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
        sent = Goal(new_number(node.node.session), clients)
        pursued = await _send(clients, goal, action, sent, note or log.warning, doubtful)
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(pursued.fetch)
        tasks.start_soon(_listen, messages, pursued.number, feedback, note or log.warning)
        tell = note
        try:
            yield pursued
        except SeoroError:
            tell = note or log.warning  # what went wrong first is what counts
            raise
        finally:
            with anyio.CancelScope(shield=True):
                await _leave(pursued, action, tell, doubtful)


async def _leave(goal: Goal, action: str, note: Note | None, doubtful: Doubtful) -> None:
    """Call a goal off, and tell if it may go on."""
    try:
        await goal.cancel()
    except SeoroError as error:
        doubtful(Doubt(action, goal.number, is_lost=not goal.is_reached))
        problem = f"the goal of {action} may go on: {error}"
        if note is None:
            raise BackendError(problem) from error
        note(problem)


async def _clients(node: RosNode, stack: AsyncExitStack, action: str, type_name: str) -> _Clients:
    """The clients of an action, once somebody serves it."""
    under = f"{action}/_action"
    clients = _Clients(
        await stack.enter_async_context(node.calling(f"{under}/send_goal", f"{type_name}_SendGoal")),
        await stack.enter_async_context(node.calling(f"{under}/get_result", f"{type_name}_GetResult")),
        await stack.enter_async_context(node.calling(f"{under}/cancel_goal", CANCEL_GOAL)),
    )
    await clients.send.wait_for_server()
    for client in (clients.result, clients.cancel):
        await client.wait_for_server(ANSWER_WITHIN)
    return clients


async def _send(
    clients: _Clients, members: Mapping[str, Any], action: str, goal: Goal, note: Note, doubtful: Doubtful
) -> Goal:
    """Send a goal; if that is cancelled after it has been sent, or has no answer, it is called off."""
    request = {"goal_id": {"uuid": list(goal.number)}, "goal": members}
    sending = asyncio.ensure_future(clients.send.call(request, ANSWER_WITHIN))
    try:
        response = await asyncio.shield(sending)
    except asyncio.CancelledError:
        with anyio.CancelScope(shield=True):
            await _recall(sending, action, goal, note, doubtful)
        raise
    except BackendError:
        with anyio.CancelScope(shield=True):
            # The server may have taken it, and not have been able to say so.
            await _leave(goal, action, lambda _: None, doubtful)
        raise
    if not response.accepted:
        raise GoalRejected(f"the server of {action} rejects the goal")
    goal.is_accepted = True
    return goal


async def _recall(sending: asyncio.Future[Any], action: str, goal: Goal, note: Note, doubtful: Doubtful) -> None:
    """Call a goal off of which it is not known whether the server has accepted it."""
    with anyio.move_on_after(CANCEL_WITHIN), suppress(BackendError):  # it may have been taken nevertheless
        if not (await sending).accepted:
            return
        goal.is_accepted = True
    sending.cancel()
    async with background() as tasks:
        tasks.start_soon(goal.fetch)
        await _leave(goal, action, note, doubtful)


async def _listen(messages: Subscription, number: bytes, feedback: Callable[[Members], None], note: Note) -> None:
    """Pass on what is told of a goal, and not what is told of others; what cannot be read is noted once."""
    noted = False
    async for received in messages:
        try:
            message = messages.decode(received)
        except (BackendError, InvalidUse) as error:
            if not noted:
                note(str(error))
            noted = True
            continue
        if bytes(message.goal_id.uuid) == number:
            feedback(Members(message.feedback))
