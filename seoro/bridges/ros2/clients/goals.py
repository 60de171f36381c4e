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
from dataclasses import dataclass, field
from typing import Any

import anyio

from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL, ENDED, UNKNOWN, is_rejected
from seoro.bridges.ros2.clients.editions import adapt, check_fits
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


@dataclass(eq=False)
class Goal:
    """A sent goal. Made by `sending_goal`.

    Attributes:
        action: Full name of the action.
        goal_id: ID of the goal.
        is_accepted: Whether the server has accepted the goal.
        is_lost: Whether the server could not be reached to cancel the goal, or did not know it: it may accept it.
        end: Final status and result, once the server has reported them.
    """

    action: str
    goal_id: bytes
    _sending: Client
    _result: Client
    _canceling: Client
    _on_unsettled: OnUnsettled
    is_accepted: bool = False
    is_lost: bool = False
    end: GoalResult | None = None
    _end: asyncio.Future[GoalResult] = field(default_factory=lambda: asyncio.get_running_loop().create_future())

    async def ended(self) -> GoalResult:
        """Wait for the end of the goal.

        Raises:
            BackendError: The server has disappeared, or has sent an invalid response.
        """
        return await asyncio.shield(self._end)

    async def fetch_result(self) -> None:
        """Request the result of the goal, and wait for it."""
        try:
            response = await self._result.call({"goal_id": {"uuid": self.goal_id}})
            status = FINAL.get(response.status)
            if status is None:
                raise BackendError(f"the server of {self._result.service} does not know the goal any more")
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
        self.is_lost = True
        request = {"goal_info": {"goal_id": {"uuid": self.goal_id}}}
        response = await self._canceling.call(request, CANCEL_TIMEOUT)
        code = response.return_code
        if code == UNKNOWN and not self.is_accepted:
            raise BackendError("its server does not know it, and may accept it later")
        self.is_lost = False
        if code == UNKNOWN:
            return
        if is_rejected(response, self.goal_id):
            raise BackendError(f"its server rejects to cancel it{f' (return code {code})' if code else ''}")
        with anyio.move_on_after(CANCEL_TIMEOUT), suppress(SeoroError):
            await self.fetch_result()  # the first request may have been cancelled with the block
        if self.end is None and not (code == ENDED and self._end.done()):
            raise BackendError(f"its server has not reported its end within {CANCEL_TIMEOUT:g} s")

    async def cancel_unfinished(self, note: Note | None) -> None:
        """Cancel the goal, and report if it may continue."""
        try:
            await self.cancel()
        except SeoroError as error:
            self._on_unsettled(self)
            problem = f"the goal of {self.action} may continue: {error}"
            if note is None:
                raise BackendError(problem) from error
            note(problem)

    async def send(self, members: Mapping[str, Any], note: Note) -> None:
        """Send the goal; cancel it if the task is cancelled meanwhile, or if the server does not answer."""
        request = {"goal_id": {"uuid": self.goal_id}, "goal": members}
        sending = asyncio.ensure_future(self._sending.call(request, ANSWER_TIMEOUT))
        try:
            response = await asyncio.shield(sending)
        except asyncio.CancelledError:
            with anyio.CancelScope(shield=True):
                await self._cancel_unacknowledged(sending, note)
            raise
        except BackendError:
            with anyio.CancelScope(shield=True):
                # The server may have accepted the goal without an answer.
                await self.cancel_unfinished(lambda _: None)
            raise
        if not response.accepted:
            raise GoalRejected(f"the server of {self.action} rejects the goal")
        self.is_accepted = True

    async def _cancel_unacknowledged(self, sending: asyncio.Future[Any], note: Note) -> None:
        """Cancel the goal, which the server may have accepted."""
        with anyio.move_on_after(CANCEL_TIMEOUT), suppress(BackendError):  # without an answer, it may be accepted
            if not (await sending).accepted:
                return
            self.is_accepted = True
        sending.cancel()
        async with background() as tasks:
            tasks.start_soon(self.fetch_result)
            await self.cancel_unfinished(note)


OnUnsettled = Callable[[Goal], None]


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
    check_fits(node.system.types, f"{type_name}_Goal", goal)
    below, report = f"{action}/_action", note or log.warning
    services = {
        "send_goal": f"{type_name}_SendGoal",
        "get_result": f"{type_name}_GetResult",
        "cancel_goal": CANCEL_GOAL,
    }
    async with AsyncExitStack() as stack:
        sending, result, canceling = [
            await stack.enter_async_context(node.calling(f"{below}/{service}", kind))
            for service, kind in services.items()
        ]
        await sending.wait_for_server()
        for client in (result, canceling):
            await client.wait_for_server(ANSWER_TIMEOUT)
        durability = Durability.TRANSIENT_LOCAL if late else Durability.VOLATILE
        topic, message = f"{below}/feedback", f"{type_name}_FeedbackMessage"
        subscribing = node.subscribing(topic, message, Qos(durability=durability, depth=FEEDBACK_DEPTH))
        messages = await stack.enter_async_context(subscribing)
        sent = Goal(action, new_goal_id(node.node.session), sending, result, canceling, on_unsettled)
        await sent.send(adapt(sending.server_types(), f"{type_name}_Goal", goal), report)
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(sent.fetch_result)
        tasks.start_soon(_forward_feedback, messages, sent.goal_id, feedback, report)
        on_problem = note
        try:
            yield sent
        except SeoroError:
            on_problem = report  # the first error counts
            raise
        finally:
            with anyio.CancelScope(shield=True):
                await sent.cancel_unfinished(on_problem)


async def _forward_feedback(
    messages: Subscription, goal_id: bytes, feedback: Callable[[Members], None], note: Note
) -> None:
    async for _, message in messages.decoded(note):
        if bytes(message.goal_id.uuid) == goal_id:
            feedback(Members(message.feedback))
