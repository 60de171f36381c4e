"""A robot for tests of the command line, with a router of its own: `python ros_robot.py ENDPOINT`.

It prints the messages on /cmd_vel.
"""

import sys
from collections.abc import Mapping
from itertools import count, islice
from typing import Any

import anyio

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import PRESETS, Qos, RmwZenoh
from seoro.bridges.session import open_session

PARAMETERS: dict[str, dict[str, Any]] = {
    "max_particles": {"type": 2, "integer_value": 2000},
    "robot_model": {"type": 4, "string_value": "differential"},
    "weights": {"type": 8, "double_array_value": [0.5, 0.25]},
}
SUCCEEDED, CANCELED = 4, 5
ENDLESS = 50  # order of a goal that goes on until it is canceled
KEPT = 60  # of one whose server rejects to cancel it, as rclpy does by default, and goes on
HASTY = 70  # of one that succeeds when it is to be canceled
called_off: dict[bytes, anyio.Event] = {}
orders: dict[bytes, int] = {}


async def enable(request: Message) -> Mapping[str, Any]:
    return {"success": bool(request.data), "message": "on" if request.data else "off"}


async def types_of(request: Message) -> Mapping[str, Any]:
    return {"types": [PARAMETERS[name]["type"] if name in PARAMETERS else 0 for name in request.names]}


async def values_of(request: Message) -> Mapping[str, Any]:
    known = [PARAMETERS[name] for name in request.names if name in PARAMETERS]
    return {"values": known if len(known) == len(request.names) else []}


async def names_of(_: Message) -> Mapping[str, Any]:
    return {"result": {"names": list(PARAMETERS)}}


async def set_values(request: Message) -> Mapping[str, Any]:
    [parameter] = request.parameters
    if parameter.value.integer_value < 1:
        return {"results": [{"successful": False, "reason": "it has to be positive"}]}
    PARAMETERS[parameter.name] = {"type": 2, "integer_value": parameter.value.integer_value}
    return {"results": [{"successful": True}]}


async def accept_goal(request: Message) -> Mapping[str, Any]:
    number = bytes(request.goal_id.uuid)
    orders[number], called_off[number] = request.goal.order, anyio.Event()
    return {"accepted": request.goal.order < 100}


async def end_goal(request: Message) -> Mapping[str, Any]:
    number = bytes(request.goal_id.uuid)
    if orders[number] == KEPT:
        await anyio.sleep_forever()
    if orders[number] in (ENDLESS, HASTY):
        await called_off[number].wait()
    if orders[number] == ENDLESS:
        return {"status": CANCELED, "result": {"sequence": []}}
    return {"status": SUCCEEDED, "result": {"sequence": [0, 1, 1, 2, 3]}}


async def cancel_goal(request: Message) -> Mapping[str, Any]:
    number = bytes(request.goal_info.goal_id.uuid)
    called_off[number].set()
    return {"goals_canceling": [] if orders[number] == KEPT else [request.goal_info]}


SERVICES = (
    ("/enable", "std_srvs/srv/SetBool", enable),
    ("/robot/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes", types_of),
    ("/robot/get_parameters", "rcl_interfaces/srv/GetParameters", values_of),
    ("/robot/list_parameters", "rcl_interfaces/srv/ListParameters", names_of),
    ("/robot/set_parameters", "rcl_interfaces/srv/SetParameters", set_values),
    ("/fibonacci/_action/send_goal", "example_interfaces/action/Fibonacci_SendGoal", accept_goal),
    ("/fibonacci/_action/get_result", "example_interfaces/action/Fibonacci_GetResult", end_goal),
    ("/fibonacci/_action/cancel_goal", "action_msgs/srv/CancelGoal", cancel_goal),
)


async def main(endpoint: str) -> None:
    async with (
        open_session(listen=endpoint, gossip=True),
        connect(endpoint, dialect=RmwZenoh()) as system,
        system.node("robot") as node,
        node.publishing("/scan", "sensor_msgs/msg/LaserScan", PRESETS["sensor_data"]) as scan,
        node.publishing("/chatter", "std_msgs/msg/String") as chatter,
        node.publishing("/burst", "std_msgs/msg/Int64", Qos(depth=1)) as burst,
        node.subscribing("/cmd_vel", "geometry_msgs/msg/Twist") as commands,
        anyio.create_task_group() as tasks,
    ):
        for name, kind, handler in SERVICES:
            tasks.start_soon(serve, node, name, kind, handler)
        tasks.start_soon(print_commands, commands)
        await system.graph.wait_for(lambda graph: len(graph.services(hidden=True)) == len(SERVICES))
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        numbers = count()
        while True:
            for number in islice(numbers, 5):
                burst.publish({"data": number})
            scan.publish({"header": {"frame_id": "lidar"}, "range_max": 12.0, "ranges": [1.5] * 360})
            chatter.publish({"data": "hello"})
            await anyio.sleep(0.02)


async def serve(node: RosNode, name: str, kind: str, handler: Any) -> None:
    async with node.serving(name, kind, handler):
        await anyio.sleep_forever()


async def print_commands(commands: Subscription) -> None:
    async for received in commands:
        sys.stdout.write(f"{commands.decode(received).linear.x}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    anyio.run(main, sys.argv[1])
