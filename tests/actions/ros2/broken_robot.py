"""A robot that does what robots should not: `python -m tests.actions.ros2.broken_robot ENDPOINT FOLDER`.

FOLDER is for another definition of `std_msgs/msg/String`. It prints a line when it is ready, and ends with its
stdin. Its action `/broken` handles goals by their order:

    1: accepts a goal, and never reports its end, even after a cancellation.
    2: accepts a goal, and never answers requests to cancel.
    3: as 1, and publishes invalid feedback.
    4: returns an invalid result.
    5: never answers.
"""

import sys
import time
from collections.abc import Mapping
from contextlib import AsyncExitStack
from functools import partial
from pathlib import Path
from typing import Any

import anyio

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import PRESETS, RmwZenoh

Members = Mapping[str, Any]
FIBONACCI = "example_interfaces/action/Fibonacci"
SILENT, STUBBORN, GARBLED, NO_RESULT, MUTE = range(1, 6)
GARBAGE = b"\0\1\0\0\xff\xff\xff\xffx"


async def never(_: Message) -> Members:
    """Accept a request, and never answer it."""
    await anyio.sleep_forever()
    raise AssertionError


class Broken:
    """The action `/broken`; it publishes the goals of cancel requests on `/canceled`.

    Args:
        feedback: Publication of feedback.
        canceled: Publication of cancel requests.
    """

    def __init__(self, feedback: Publication, canceled: Publication) -> None:
        self._feedback = feedback
        self._canceled = canceled
        self._orders: dict[bytes, int] = {}

    async def send(self, request: Message) -> Members:
        order = self._orders[bytes(request.goal_id.uuid)] = request.goal.order
        if order == MUTE:
            await anyio.sleep_forever()
        if order == GARBLED:
            self._feedback.send(GARBAGE)
        return {"accepted": True}

    async def result(self, request: Message) -> Members:
        if self._orders[bytes(request.goal_id.uuid)] == NO_RESULT:
            return {"status": 77}
        return await never(request)

    async def cancel(self, request: Message) -> Members:
        order = self._orders.get(bytes(request.goal_info.goal_id.uuid), 0)
        self._canceled.publish({"data": order})
        if order == STUBBORN:
            await anyio.sleep_forever()
        return {"goals_canceling": [request.goal_info]}


async def serve(node: RosNode, stack: AsyncExitStack) -> None:
    """Serve the action, and what never answers."""
    under = "/broken/_action"
    feedback = await stack.enter_async_context(
        node.publishing(f"{under}/feedback", f"{FIBONACCI}_FeedbackMessage")
    )
    latched = PRESETS["system_default_transient_local"]
    canceled = await stack.enter_async_context(node.publishing("/canceled", "std_msgs/msg/Int64", latched))
    broken = Broken(feedback, canceled)
    for name, type_name, handler in (
        (f"{under}/get_result", f"{FIBONACCI}_GetResult", broken.result),
        (f"{under}/cancel_goal", "action_msgs/srv/CancelGoal", broken.cancel),
        (f"{under}/send_goal", f"{FIBONACCI}_SendGoal", broken.send),
        ("~/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes", never),
        ("~/get_state", "lifecycle_msgs/srv/GetState", never),
    ):
        await stack.enter_async_context(node.serving(name, type_name, handler))


async def talk(node: RosNode, stack: AsyncExitStack) -> None:
    """Publish unreadable messages, and messages with stamps an hour old, twenty times a second."""
    old = await stack.enter_async_context(node.publishing("/old", "sensor_msgs/msg/LaserScan"))
    publications = [
        await stack.enter_async_context(node.publishing(topic, type_name))
        for topic, type_name in (
            ("/garbage", "std_msgs/msg/String"),
            ("/bad/tf", "tf2_msgs/msg/TFMessage"),
            ("/bad/odom", "nav_msgs/msg/Odometry"),
        )
    ]
    while True:
        for publication in publications:
            publication.send(GARBAGE)
        old.publish({"header": {"stamp": {"sec": int(time.time()) - 3600}}})
        await anyio.sleep(0.05)


async def pour(node: RosNode) -> None:
    """Publish images of 10 MB as fast as possible while a subscription exists."""
    image = {"width": 2000, "height": 1667, "encoding": "rgb8", "step": 6000, "data": bytes(2000 * 1667 * 3)}
    payload = node.system.types.encode("sensor_msgs/msg/Image", image)
    async with node.publishing("/flood", "sensor_msgs/msg/Image", PRESETS["sensor_data"]) as flood:
        while True:
            await node.graph.wait_for(lambda graph: graph.subscriptions("/flood"))
            await anyio.to_thread.run_sync(partial(flood.send, payload))


async def strange(endpoint: str, folder: Path) -> None:
    """Publish by another definition."""
    file = folder / "std_msgs" / "msg" / "String.msg"
    file.parent.mkdir(parents=True)
    file.write_text("string data\nuint8 priority\n")
    async with connect(endpoint, dialect=RmwZenoh()) as system:
        types = system.types.add_folder(folder)
        async with (
            connect(endpoint, types=types, dialect=RmwZenoh()) as other,
            other.node("stranger") as node,
            node.publishing("/strange", "std_msgs/msg/String") as publication,
        ):
            while True:
                publication.publish({"data": "strange"})
                await anyio.sleep(0.05)


async def main() -> None:
    async with (
        AsyncExitStack() as stack,
        connect(sys.argv[1], dialect=RmwZenoh()) as system,
        system.node("broken") as node,
        anyio.create_task_group() as tasks,
    ):
        await serve(node, stack)
        tasks.start_soon(talk, node, stack)
        tasks.start_soon(pour, node)
        tasks.start_soon(strange, sys.argv[1], Path(sys.argv[2]))
        await node.graph.wait_for(lambda graph: graph.publishers("/strange") and graph.publishers("/flood"))
        print("ready", flush=True)  # noqa: T201 - for who has started it
        await anyio.to_thread.run_sync(sys.stdin.readline, abandon_on_cancel=True)
        tasks.cancel_scope.cancel()


if __name__ == "__main__":
    anyio.run(main)
