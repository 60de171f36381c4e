"""Goals of the actions of a robot as goals of the bridge: accepted or rejected at once, reported at their end."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import anyio

from seoro.bridges.ros2.clients.cancellation import cancel_goal, wait_ended
from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.clients.lifecycle import watching_lifecycle
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.robots.link import DISCOVERY_TIMEOUT, RobotLink
from seoro.bridges.serving.work import GoalAborted, GoalInterrupted
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.errors import BackendError, BackendLost, SeoroError
from seoro.robotics.goal_results import describe_failure
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.ros2 import GoalResult

ACTIVE, FINAL = "active", "finalized"  # lifecycle states: accepts goals; never changes

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ActionGoal:
    """A goal of an action.

    Args:
        action: Name of the action.
        type: Type of the action.
        goal: Members of the goal.
        feedback: Called with feedback.
        part: Part of the robot that moves, such as its gripper.
        judge: Called with the result of a goal unless it has a known failure; returns a description, or raises
            `GoalAborted`.
    """

    action: str
    type: str
    goal: Mapping[str, Any]
    feedback: Callable[[Members], None] = lambda _feedback: None
    part: str = ""
    judge: Callable[[Mapping[str, Any]], str] = lambda _result: ""


async def pursue(link: RobotLink, identifier: str, goal: ActionGoal) -> None:
    """Send a goal to a robot, and return when it is accepted. Its end is reported by its ID.

    A canceled goal that may continue is reported, too.

    Raises:
        RequestRefused: The action has no server, or the robot rejects the goal, or does not answer.
    """
    await _wait_for_server(link, goal)
    answered, refusal = anyio.Event(), ""
    work, state = link.work, link.state

    def note(text: str) -> None:
        log.warning("%s", text)
        work.warn(identifier, text)

    def on_unsettled(unsettled: Goal) -> None:
        work.mark_unsettled(link.name)
        if unsettled.is_lost:
            state.add_unanswered()
        link.tasks.start_soon(_settle, link, goal.type, unsettled)

    async def execute() -> str:
        nonlocal refusal
        number = state.standstills.number
        state.add_unanswered()
        try:
            async with sending_goal(
                link.node, goal.action, goal.type, goal.goal, goal.feedback, note, on_unsettled
            ) as sent:
                state.remove_unanswered()
                answered.set()
                end = await sent.ended()
                if end.status is GoalStatus.CANCELED:
                    state.standstills.check(number)  # the guard cancels goals after a standstill
                return _judge(goal, end)
        except BackendLost as error:
            refusal = str(error)
            raise GoalInterrupted(str(error)) from error
        except SeoroError as error:
            refusal = str(error)
            raise GoalAborted(str(error)) from error
        finally:
            if not answered.is_set():
                state.remove_unanswered()
                refusal = refusal or "the goal was canceled before the robot had accepted it"
                answered.set()

    work.start(identifier, execute, robot=link.name, part=goal.part)
    await answered.wait()
    if refusal:
        raise RequestRefused(Result.OPERATION_FAILED, refusal)


async def _settle(link: RobotLink, type_name: str, goal: Goal) -> None:
    """Wait for the end of a goal that may continue; cancel the goal if it is lost."""
    if goal.is_lost:
        await cancel_goal(link.node, goal.action, goal.goal_id, log.warning)
        link.state.remove_unanswered()
    await wait_ended(link.node, goal.action, type_name, goal.goal_id)
    link.work.mark_settled(link.name)


async def _wait_for_server(link: RobotLink, goal: ActionGoal) -> None:
    """Wait for a server of the action, and until its node is active if it has a life cycle, as in Nav2.

    Such a node reports its state from the start, and serves actions once it is configured. So if an action is
    visible, the state service is, too.
    """
    graph, name = link.node.graph, link.node.resolve(goal.action)
    missing = f"no server of the action {name} ({goal.type}) on the robot"
    with anyio.move_on_after(DISCOVERY_TIMEOUT):
        servers = await graph.wait_for(lambda seen: seen.action_servers(name))
        missing = ""
        for other in sorted({server.node.full_name for server in servers if server.node is not None}):
            if not graph.servers(f"{other}/get_state"):
                continue
            with suppress(BackendError):  # without a response, the result of the goal decides
                async with watching_lifecycle(link.node, other) as states:
                    async for state in states:
                        is_active = state == ACTIVE
                        missing = "" if is_active else f"{other}, the server of {name}, is {state}, not active"
                        if is_active or state == FINAL:
                            break
    if missing:
        raise RequestRefused(Result.INCORRECT_STATE, missing)


def _judge(goal: ActionGoal, end: GoalResult) -> str:
    if end.status is GoalStatus.CANCELED:
        raise GoalAborted(f"{goal.action}: another client has canceled the goal")
    if failure := describe_failure(goal.type, end.result):
        raise GoalAborted(f"{goal.action}: {failure}")
    text = goal.judge(end.result)  # raises if it finds a reason
    if end.status is GoalStatus.ABORTED:
        raise GoalAborted(f"{goal.action}: the robot has aborted the goal")
    return text
