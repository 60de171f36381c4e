"""Orphaned goals at a robot, with invalid messages on its topics."""

from __future__ import annotations

import logging
from contextlib import AsyncExitStack
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL
from seoro.bridges.ros2.clients.goal_ids import new_goal_id
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.orphaned_goals import STATUSES, GoalSenders, cancel_orphaned_goals
from seoro.bridges.ros2.wire import LATCHED
from seoro.concurrency.background import background
from tests.bridges.ros2.systems import STRING, two_nodes

pytestmark = pytest.mark.anyio

JUNK = b"\0\1\0\0abc"
DEADLINE = 30.0  # [s]


CANCELS = "/spin: the server cancels a goal without a client"
REJECTS = "/spin: a goal without a client continues: its server rejects to cancel it"


@pytest.mark.parametrize("takes", [True, False], ids=["takes it", "rejects as rclpy"])
async def test_an_invalid_status_is_reported_once_and_hides_no_goals(
    takes: bool, router: str, types: TypeStore
) -> None:
    canceled, notes = anyio.Event(), list[str]()

    async def cancel_goal(request: Any) -> dict[str, Any]:
        canceled.set()
        return {"goals_canceling": [request.goal_info] if takes else []}

    async with (
        two_nodes(router, types) as (there, here),
        there.serving("/spin/_action/cancel_goal", CANCEL_GOAL, cancel_goal),
        there.publishing("/spin/_action/status", STATUSES, LATCHED) as statuses,
        background() as tasks,
    ):
        senders, number = GoalSenders(here.graph), new_goal_id(there.node.session)
        goal = {"goal_info": {"goal_id": {"uuid": list(number)}}, "status": 2}
        with anyio.fail_after(DEADLINE):
            await tasks.start(cancel_orphaned_goals, here, "/spin", senders, notes.append)
            await statuses.wait_for_subscription()
            statuses.publish({"status_list": [goal]})
            await here.graph.wait_for(lambda _: bool(senders._active.get("/spin")))
            statuses.send(JUNK)
            statuses.send(JUNK)
            while not notes:
                await anyio.sleep(0.01)
            senders.disown(there.node.session, ["/spin"])
            await canceled.wait()
            while len(notes) < 2:
                await anyio.sleep(0.01)
    assert notes[0].startswith("invalid message on /spin/_action/status: ")
    assert notes[1:] == [CANCELS if takes else REJECTS]


async def test_a_publisher_of_another_type_does_not_hide_goals(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        there.publishing("/spin/_action/status", STRING),
        background() as tasks,
    ):
        senders, number = GoalSenders(here.graph), new_goal_id(there.node.session)
        goal = {"goal_info": {"goal_id": {"uuid": list(number)}}, "status": 2}
        with anyio.fail_after(DEADLINE):
            await here.graph.wait_for(lambda graph: graph.publishers("/spin/_action/status"))
            await tasks.start(cancel_orphaned_goals, here, "/spin", senders, lambda _: None)
            async with there.publishing("/spin/_action/status", STATUSES, LATCHED) as statuses:
                statuses.publish({"status_list": [goal]})
                await here.graph.wait_for(lambda _: bool(senders._active.get("/spin")))
                assert len(senders._active["/spin"]) == 1


async def test_invalid_messages_of_a_topic_are_reported_once(
    router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    received: list[str] = []
    async with (
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        AsyncExitStack() as stack,
        background() as tasks,
    ):
        await Link(here, stack, tasks).listen("/chatter", STRING, lambda message: received.append(message.data))
        with anyio.fail_after(DEADLINE):
            await chatter.wait_for_subscription()
            while "end" not in received:
                chatter.send(JUNK)
                chatter.publish({"data": "end" if received else "begin"})
                await anyio.sleep(0.01)
    assert caplog.text.count("invalid message on /chatter: ") == 1
