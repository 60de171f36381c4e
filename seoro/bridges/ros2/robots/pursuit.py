"""Goals of a robot's actions as goals of the bridge: accepted or refused at once, told when they end."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import anyio

from seoro.bridges.ros2.clients.goals import Doubt, pursuing
from seoro.bridges.ros2.clients.lifecycle import following_lifecycle
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.clients.recall import recall, wait_ended
from seoro.bridges.ros2.robots.link import FOUND_WITHIN, Link
from seoro.bridges.serving.work import Aborted, Interrupted, Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.errors import BackendError, BackendLost, SeoroError
from seoro.runtime.contracts import GoalStatus
from seoro.runtime.ros_system import GoalResult

ACTIVE, FINAL = "active", "finalized"  # states of a life cycle: in which goals are taken, and which is never left

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ActionGoal:
    """A goal of an action.

    Args:
        action: Name of the action.
        type: Its type.
        goal: The goal.
        feedback: Called with feedback.
        part: Of the robot that is at work, such as its gripper.
        judge: Called with the result of a goal that has ended; says something of it, or raises `Aborted`.
    """

    action: str
    type: str
    goal: Mapping[str, Any]
    feedback: Callable[[Members], None] = lambda _feedback: None
    part: str = ""
    judge: Callable[[Mapping[str, Any]], str] = lambda _result: ""


async def pursue(link: Link, work: Work, identifier: str, robot: str, goal: ActionGoal) -> None:
    """Send a goal to a robot; its end is told by its id, and that it may go on though it was called off.

    Raises:
        RequestRefused: Nobody serves the action, or the robot rejects the goal, or does not answer.
    """
    await _find(link, goal)
    answer = _Answer()

    def note(text: str) -> None:
        log.warning("%s", text)
        work.caution(identifier, text)

    def doubt(of: Doubt) -> None:
        work.doubt(robot)
        if of.is_lost:
            link.unanswered.begin()
        link.tasks.start_soon(_settle, link, work, robot, goal.type, of)

    async def carry() -> str:
        number = link.standstills.number
        link.unanswered.begin()
        try:
            async with pursuing(
                link.node, goal.action, goal.type, goal.goal, goal.feedback, note, doubt
            ) as pursued:
                link.unanswered.end()
                answer.known.set()
                end = await pursued.ended()
                if end.status is GoalStatus.CANCELED:
                    link.standstills.check(number)  # in which the guard does that
                return _judged(goal, end)
        except BackendLost as error:
            answer.refusal = str(error)
            raise Interrupted(str(error)) from error
        except SeoroError as error:
            answer.refusal = str(error)
            raise Aborted(str(error)) from error
        finally:
            if not answer.known.is_set():
                link.unanswered.end()
                answer.refusal = answer.refusal or "the goal was canceled before the robot had accepted it"
                answer.known.set()

    work.start(identifier, carry, robot=robot, part=goal.part)
    await answer.known.wait()
    if answer.refusal:
        raise RequestRefused(Result.OPERATION_FAILED, answer.refusal)


async def _settle(link: Link, work: Work, robot: str, type_name: str, doubt: Doubt) -> None:
    """Follow a goal of a robot that may go on, and call it off if it is lost; it counts as one until its end."""
    if doubt.is_lost:
        await recall(link.node, doubt.action, doubt.number, log.warning)
        link.unanswered.end()
    await wait_ended(link.node, doubt.action, type_name, doubt.number)
    work.settle(robot)


@dataclass
class _Answer:
    """What a robot says to a goal: when it is known, and why it is not taken."""

    known: anyio.Event = field(default_factory=anyio.Event)
    refusal: str = ""


async def _find(link: Link, goal: ActionGoal) -> None:
    """Wait until the action is served, and until who does that is active if it has a life cycle, as Nav2 has.

    A node that has one tells its state from its beginning, and serves actions once it is configured: where an
    action is seen, so is the service that tells the state.
    """
    graph, name = link.node.graph, link.node.resolve(goal.action)
    missing = f"nobody on the robot serves the action {name} ({goal.type})"
    with anyio.move_on_after(FOUND_WITHIN):
        servers = await graph.wait_for(lambda seen: seen.action_servers(name))
        missing = ""
        for other in sorted({server.node.full_name for server in servers if server.node is not None}):
            if not graph.servers(f"{other}/get_state"):
                continue
            with suppress(BackendError):  # it does not tell; then its answer to the goal will
                async with following_lifecycle(link.node, other) as states:
                    async for state in states:
                        is_active = state == ACTIVE
                        missing = "" if is_active else f"{other}, which serves {name}, is {state}, not active"
                        if is_active or state == FINAL:
                            break
    if missing:
        raise RequestRefused(Result.INCORRECT_STATE, missing)


def _judged(goal: ActionGoal, end: GoalResult) -> str:
    match end.status:
        case GoalStatus.SUCCEEDED:
            return goal.judge(end.result)
        case GoalStatus.CANCELED:
            raise Aborted(f"{goal.action}: somebody else has canceled the goal")
        case GoalStatus.ABORTED:
            goal.judge(end.result)  # which may know more of why
            raise Aborted(f"{goal.action}: the robot has aborted the goal{_reason(end.result)}")


def _reason(result: Mapping[str, Any]) -> str:
    """Why, as far as Nav2 and MoveIt say."""
    code, message = result.get("error_code"), result.get("error_msg") or result.get("error_string")
    number = code.get("val") if isinstance(code, Mapping) else code
    text = f": {message}" if message else ""
    return f" (error {number}){text}" if number else text
