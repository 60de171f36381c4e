"""States of lifecycle nodes that appear and leave."""

from __future__ import annotations

from functools import partial
from typing import Any

import anyio
import pytest
from anyio import TASK_STATUS_IGNORED
from anyio.abc import TaskStatus

from seoro.bridges.ros2.clients.lifecycle import GONE, watching_lifecycle
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

INACTIVE, ACTIVE = {"id": 2, "label": "inactive"}, {"id": 3, "label": "active"}


async def live(
    robot: RosNode, end: anyio.Event, state: dict[str, Any], *, task_status: TaskStatus[None] = TASK_STATUS_IGNORED
) -> None:
    """Serve a state until the end."""

    async def get_state(_request: object) -> dict[str, Any]:
        return {"current_state": state}

    async with robot.serving("~/get_state", "lifecycle_msgs/srv/GetState", get_state):
        task_status.started()
        await end.wait()


async def test_states_of_a_node_that_leaves_and_returns_are_reported(router: str, types: TypeStore) -> None:
    transitions, end = "lifecycle_msgs/msg/TransitionEvent", anyio.Event()
    async with (
        two_nodes(router, types) as (robot, here),
        robot.publishing("~/transition_event", transitions) as events,
        anyio.create_task_group() as tasks,
    ):
        await tasks.start(partial(live, robot, end, INACTIVE))
        async with watching_lifecycle(here, "/robot") as states:
            with anyio.fail_after(30.0):
                assert await anext(states) == "inactive"
                await events.wait_for_subscription(10.0)
                events.publish({"start_state": INACTIVE, "goal_state": ACTIVE})
                assert await anext(states) == "active"
                end.set()
                assert await anext(states) == GONE
                await tasks.start(partial(live, robot, anyio.Event(), INACTIVE))
                assert await anext(states) == "inactive"
        tasks.cancel_scope.cancel()
