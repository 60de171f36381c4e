"""A robot in a process of its own: `python -m tests.actions.ros2.robot ENDPOINT`.

Its node `robot` prints a line when it is ready. The parameters, life cycle, services and action of the node behave
according to their names. Its node `talker` publishes all the time. The robot ends with its stdin.
"""

import asyncio
import math
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from typing import Any

import anyio

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import PRESETS, RmwZenoh
from seoro.errors import ActionFailed

Members = Mapping[str, Any]
FIBONACCI = "example_interfaces/action/Fibonacci"
STATES = {"unconfigured": 1, "inactive": 2, "active": 3, "finalized": 4}
ACCEPTED, EXECUTING, SUCCEEDED, CANCELED, ABORTED = 1, 2, 4, 5, 6


class Fibonacci:
    """The action `/fibonacci`: it counts up to its order, one number each 50 ms.

    An order of 13 is rejected, and 7 is aborted. An order of 10 rejects to be canceled, and succeeds then.
    """

    def __init__(self) -> None:
        self.goals: dict[bytes, tuple[asyncio.Event, asyncio.Future[Members], int]] = {}
        self.feedback: Publication | None = None
        self.texts: Publication | None = None

    async def send(self, request: Message) -> Members:
        if request.goal.order == 13:
            return {"accepted": False}
        number = bytes(request.goal_id.uuid)
        cancel, end = asyncio.Event(), asyncio.get_running_loop().create_future()
        self.goals[number] = cancel, end, request.goal.order
        if request.goal.order == 10:
            self.publish_text("goal accepted")
        else:
            self.task = asyncio.ensure_future(self.count(number, request.goal.order))
        return {"accepted": True}

    async def count(self, number: bytes, order: int) -> None:
        cancel, end, _ = self.goals[number]
        sequence = [0, 1]
        assert self.feedback is not None
        while len(sequence) < order and not cancel.is_set():
            sequence.append(sequence[-1] + sequence[-2])
            feedback = {"goal_id": {"uuid": list(number)}, "feedback": {"sequence": sequence}}
            self.feedback.publish(feedback)
            if len(sequence) == 7 == order:
                break
            await asyncio.sleep(0.05)
        status = CANCELED if cancel.is_set() else ABORTED if order == 7 else SUCCEEDED
        end.set_result({"status": status, "result": {"sequence": sequence}})
        if cancel.is_set():
            self.publish_text("goal canceled")

    async def result(self, request: Message) -> Members:
        return await self.goals[bytes(request.goal_id.uuid)][1]

    async def active(self, request: Message) -> Members:
        return {"message": str(sum(not end.done() for _, end, _ in self.goals.values()))}

    async def cancel(self, request: Message) -> Members:
        goal = self.goals.get(bytes(request.goal_info.goal_id.uuid))
        if goal is None:
            return {"return_code": 2}
        if goal[2] == 10:
            if not goal[1].done():
                goal[1].set_result({"status": SUCCEEDED, "result": {}})
                self.publish_text("goal not canceled")
            return {"return_code": 1}
        goal[0].set()
        return {"goals_canceling": [request.goal_info]}

    def publish_text(self, text: str) -> None:
        assert self.texts is not None
        self.texts.publish({"data": text})

    async def serve(self, node: RosNode, stack: AsyncExitStack) -> None:
        under = "/fibonacci/_action"
        topic = node.publishing(f"{under}/feedback", f"{FIBONACCI}_FeedbackMessage")
        self.feedback = await stack.enter_async_context(topic)
        for name, type_name, handler in (
            ("/goals", "std_srvs/srv/Trigger", self.active),
            ("get_result", f"{FIBONACCI}_GetResult", self.result),
            ("cancel_goal", "action_msgs/srv/CancelGoal", self.cancel),
            ("send_goal", f"{FIBONACCI}_SendGoal", self.send),
        ):
            await stack.enter_async_context(
                node.serving(name if name[0] == "/" else f"{under}/{name}", type_name, handler)
            )


class Robot:
    """Services and action of the node `robot`."""

    def __init__(self, publish_text: Callable[[str], None]) -> None:
        self.publish_text = publish_text
        self.speed = 0.5
        self.state = "unconfigured"
        self.state_known = asyncio.Event()  # to checks of the life cycle
        self.transitions: Publication | None = None

    async def add(self, request: Message) -> Members:
        return {"sum": request.a + request.b}

    async def never(self, request: Message) -> Members:
        self.publish_text("asked")
        await asyncio.sleep(1000.0)
        return {}

    async def fail(self, request: Message) -> Members:
        raise ActionFailed("the gripper is stuck")

    async def types(self, request: Message) -> Members:
        return {"types": [3 if name == "speed" else 0 for name in request.names]}

    async def set(self, request: Message) -> Members:
        [parameter] = request.parameters
        if parameter.name != "speed":
            return {"results": [{"reason": "it has not been declared"}]}
        value = parameter.value
        if value.type != 3 or value.double_value > 1.0:
            return {"results": [{"reason": "a speed is a number up to 1"}]}
        self.speed = value.double_value
        return {"results": [{"successful": True}]}

    async def get(self, request: Message) -> Members:
        return {"values": [{"type": 3, "double_value": self.speed}]}

    async def get_state(self, request: Message) -> Members:
        self.state_known.set()
        return {"current_state": {"id": STATES[self.state], "label": self.state}}

    async def change(self, request: Message) -> Members:
        """A transition by the label of its goal; one with an `id` waits until the present state was asked for."""
        if request.transition.id:
            await self.state_known.wait()
        self.state_known.clear()
        before, self.state = self.state, request.transition.label
        assert self.transitions is not None
        way = {"id": 10, "label": "on the way"}
        start, end = ({"id": STATES[name], "label": name} for name in (before, self.state))
        self.transitions.publish({"start_state": start, "goal_state": way})
        self.transitions.publish({"start_state": way, "goal_state": end})
        return {"success": True}

    async def serve(self, node: RosNode, stack: AsyncExitStack) -> None:
        events = node.publishing("~/transition_event", "lifecycle_msgs/msg/TransitionEvent")
        self.transitions = await stack.enter_async_context(events)
        for name, type_name, handler in (
            ("/add", "example_interfaces/srv/AddTwoInts", self.add),
            ("/never", "std_srvs/srv/Empty", self.never),
            ("/fail", "std_srvs/srv/Empty", self.fail),
            ("~/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes", self.types),
            ("~/get_parameters", "rcl_interfaces/srv/GetParameters", self.get),
            ("~/set_parameters", "rcl_interfaces/srv/SetParameters", self.set),
            ("~/get_state", "lifecycle_msgs/srv/GetState", self.get_state),
            ("~/change_state", "lifecycle_msgs/srv/ChangeState", self.change),
        ):
            await stack.enter_async_context(node.serving(name, type_name, handler))


def transform(parent: str, child: str, x: float, stamp: float) -> Members:
    header = {"stamp": {"sec": int(stamp), "nanosec": int(stamp % 1 * 1e9)}, "frame_id": parent}
    placed = {"translation": {"x": x}, "rotation": {"w": 1.0}}
    return {"header": header, "child_frame_id": child, "transform": placed}


async def talk(node: RosNode) -> None:
    """Publish, twenty times a second: a count, a scan 30 ms old, a distance that grows, and transforms.

    `base_link` moves ahead in `odom`, up to 1 m and again from 0, and `odom` is at 10 m in `map`; `box` rests.
    """
    async with (
        node.publishing(
            "/tf_static", "tf2_msgs/msg/TFMessage", PRESETS["system_default_transient_local"]
        ) as static,
        node.publishing("/tf", "tf2_msgs/msg/TFMessage") as moving,
        node.publishing("/r1/odom", "nav_msgs/msg/Odometry") as other,
        node.publishing("/lost/odom", "nav_msgs/msg/Odometry") as lost,
        node.publishing("/count", "std_msgs/msg/Int64") as count,
        node.publishing("/scan", "sensor_msgs/msg/LaserScan", PRESETS["sensor_data"]) as scan,
        node.publishing("/odom", "nav_msgs/msg/Odometry") as odometry,
    ):
        static.publish({"transforms": [transform("map", "odom", 10.0, 0.0)]})
        for number in range(100_000):
            count.publish({"data": number})
            stamp = time.time() - 0.03
            header = {"stamp": {"sec": int(stamp), "nanosec": int(stamp % 1 * 1e9)}, "frame_id": "laser"}
            scan.publish({"header": header, "ranges": [1.0, 2.5]})
            odometry.publish({"pose": {"pose": {"position": {"x": number * 0.05}}}})
            lost.publish({"pose": {"pose": {"position": {"x": math.nan}}}})
            other.publish({"pose": {"pose": {"position": {"y": 3.0}}}})
            base = transform("odom", "base_link", number % 20 * 0.05, stamp)
            moving.publish({"transforms": [base, transform("odom", "box", 1.0, stamp)]})
            await anyio.sleep(0.05)


async def main() -> None:
    async with (
        AsyncExitStack() as stack,
        connect(sys.argv[1], dialect=RmwZenoh()) as system,
        system.node("robot") as robot,
        system.node("talker") as talker,
        robot.publishing("/echo", "std_msgs/msg/String", PRESETS["system_default_transient_local"]) as texts,
        robot.publishing("/rosout", "rcl_interfaces/msg/Log") as rosout,
        robot.subscribing("/texts", "std_msgs/msg/String") as subscription,
        anyio.create_task_group() as tasks,
    ):
        action = Fibonacci()
        action.texts = texts
        await action.serve(robot, stack)
        await Robot(action.publish_text).serve(robot, stack)
        tasks.start_soon(talk, talker)

        async def echo() -> None:
            async for received in subscription:
                text = subscription.decode(received).data
                texts.publish({"data": text})
                rosout.publish({"name": "robot", "msg": f"received {text}"})

        tasks.start_soon(echo)
        texts.publish({"data": "ready"})
        print("ready", flush=True)  # noqa: T201 - for who has started it
        await anyio.to_thread.run_sync(sys.stdin.readline, abandon_on_cancel=True)
        tasks.cancel_scope.cancel()


if __name__ == "__main__":
    anyio.run(main)
