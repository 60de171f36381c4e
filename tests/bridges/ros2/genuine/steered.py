"""A genuine ROS 2 node that tests steer, for an environment with rclpy: `steered.py NAME [--ros-args ...]`.

It reads requests from stdin, one JSON object a line with `id` and `do`. It prints an answer with the same `id` to
each one, and events. Numbers that JSON lacks are the texts `nan`, `inf` and `-inf`.
"""

import array
import importlib
import json
import math
import os
import pathlib
import random
import sys
import threading
import time

import numpy
import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, ParameterEvent, SetParametersResult
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from spinning import Spinning

OUTPUT = threading.Lock()
LENGTH = 3  # of generated sequences without bounds


def print_line(**fields):
    with OUTPUT:
        sys.stdout.write(json.dumps(fields) + "\n")
        sys.stdout.flush()


def interface(name):
    """Import `package/kind/Name`."""
    package, kind, type_name = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), type_name)


def qos(reliability="reliable", durability="volatile", history="keep_last", depth=10, **more):
    times = {name: Duration(nanoseconds=more[name]) for name in ("deadline", "lifespan") if more.get(name)}
    if more.get("lease"):
        times["liveliness_lease_duration"] = Duration(nanoseconds=more["lease"])
    if more.get("liveliness"):
        times["liveliness"] = LivelinessPolicy[more["liveliness"].upper()]
    return QoSProfile(
        reliability=ReliabilityPolicy[reliability.upper()],
        durability=DurabilityPolicy[durability.upper()],
        history=HistoryPolicy[history.upper()],
        depth=depth,
        **times,
    )


def described(profile):
    """Return the policies of a profile that the graph has."""
    return {
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "history": profile.history.name.lower(),
        "depth": profile.depth,
        "deadline": profile.deadline.nanoseconds,
        "lifespan": profile.lifespan.nanoseconds,
        "liveliness": profile.liveliness.name.lower(),
        "lease": profile.liveliness_lease_duration.nanoseconds,
    }


# ---------------------------------------------------------------------------------------------- messages as JSON


def to_json(value):
    if hasattr(value, "get_fields_and_field_types"):
        return {name: to_json(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return value[0]
    if isinstance(value, (list, tuple, array.array, numpy.ndarray)):
        return [to_json(each) for each in value]
    if isinstance(value, numpy.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def fill(message, values):
    """Set the members of a message from JSON."""
    for name, value in values.items():
        setattr(message, name, from_json(getattr(message, name), message, name, value))
    return message


def from_json(present, message, name, value):
    kind = message.get_fields_and_field_types()[name]
    if hasattr(present, "get_fields_and_field_types"):
        return fill(present, value)
    if isinstance(value, list):
        element = (
            kind.partition("<")[2].split(",")[0].rstrip(">")
            if kind.startswith("sequence")
            else kind.partition("[")[0]
        )
        if element == "octet":
            return [bytes([each]) for each in value]
        if "/" in element:
            package, type_name = element.split("/")
            made = interface(f"{package}/msg/{type_name}")
            return [fill(made(), each) for each in value]
        return [number(each) for each in value]
    if kind == "octet":
        return bytes([value])
    return number(value)


def number(value):
    return float(value) if value in ("nan", "inf", "-inf") else value


SCALARS = {
    "boolean": lambda draw: draw.random() < 0.5,
    "octet": lambda draw: bytes([draw.randrange(256)]),
    "float": lambda draw: draw.choice((draw.randrange(-(2**20), 2**20) / 64, 0.0, -0.0, math.inf, -math.inf)),
    "double": lambda draw: draw.choice((draw.uniform(-1e9, 1e9), 1e-300, math.inf)),
    "string": lambda draw: draw.choice(("", "grüße", "x" * 300, "a b\n'\"")),
    "wstring": lambda draw: draw.choice(("", "grüße", "wide")),
}
BITS = {f"{sign}int{bits}": (sign, bits) for sign in ("", "u") for bits in (8, 16, 32, 64)}


def scalar(kind, draw):
    if kind in BITS:
        sign, bits = BITS[kind]
        low, high = (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        return draw.choice((low, high, draw.randint(low, high)))
    base, _, bound = kind.partition("<")
    if base in ("string", "wstring") and bound:
        return SCALARS[base](draw)[: int(bound.rstrip(">"))]
    if "/" in kind:
        package, type_name = kind.split("/")
        return example(interface(f"{package}/msg/{type_name}"), draw)
    return SCALARS[base](draw)


def example(message_type, draw):
    """Make a message with drawn values."""
    message = message_type()
    for name, kind in message_type.get_fields_and_field_types().items():
        setattr(message, name, drawn(kind, draw))
    return message


def drawn(kind, draw):
    if kind.startswith("sequence<"):
        inner = kind[len("sequence<") : -1]
        element, _, bound = inner.partition(", ")
        return [scalar(element, draw) for _ in range(draw.randint(0, min(LENGTH, int(bound or LENGTH))))]
    if kind.endswith("]"):
        element, _, count = kind[:-1].rpartition("[")
        return [scalar(element, draw) for _ in range(int(count))]
    return scalar(kind, draw)


# ---------------------------------------------------------------------------------------------------- the node


class Steered:
    def __init__(self, node, spinning):
        self.node = node
        self.call_in_turn = spinning.call
        self.made = {}  # publishers, subscriptions, servers and clients by name
        self.goals = {}
        self.group = ReentrantCallbackGroup()

    def publisher(self, topic, type, **policies):  # noqa: A002 - a name of the requests
        kind = interface(type)
        self.made[topic] = self.call_in_turn(lambda: self.node.create_publisher(kind, topic, qos(**policies)))

    def publish(self, topic, messages, pause=0.0):
        publisher = self.made[topic]
        for message in messages:
            publisher.publish(fill(publisher.msg_type(), message))
            time.sleep(pause)

    def publish_bytes(self, topic, size, count=1, pause=0.0):
        """Publish messages of std_msgs/UInt8MultiArray with a number of bytes, which count up."""
        publisher = self.made[topic]
        for index in range(count):
            message = publisher.msg_type()
            message.data = array.array("B", bytes([index % 256]) * size)
            publisher.publish(message)
            time.sleep(pause)

    def publish_examples(self, topic, seed, count):
        """Publish drawn messages; returns them."""
        publisher, draw = self.made[topic], random.Random(seed)
        messages = [example(publisher.msg_type, draw) for _ in range(count)]
        for message in messages:
            publisher.publish(message)
        return [to_json(message) for message in messages]

    def types(self):
        """Return the types of messages that are installed."""
        found = []
        entries = [entry for folder in sys.path for entry in pathlib.Path(folder).glob("*/msg/__init__.py")]
        for package in {entry.parts[-3] for entry in entries}:
            module = importlib.import_module(f"{package}.msg")
            found += [f"{package}/msg/{name}" for name, kind in vars(module).items() if isinstance(kind, type)]
        return sorted(found)

    def examples(self, type, seed, count):  # noqa: A002 - a name of the requests
        draw, kind = random.Random(seed), interface(type)
        return [to_json(example(kind, draw)) for _ in range(count)]

    def subscribe(self, topic, type, sizes=False, **policies):  # noqa: A002 - a name of the requests
        def receive(message):
            print_line(event="message", topic=topic, message=len(message.data) if sizes else to_json(message))

        kind = interface(type)
        # Not in the reentrant group, so that messages are printed in order.
        self.made[topic] = self.call_in_turn(
            lambda: self.node.create_subscription(kind, topic, receive, qos(**policies))
        )

    def matched(self, topic):
        return {
            "publishers": self.node.count_publishers(topic),
            "subscriptions": self.node.count_subscribers(topic),
        }

    def graph(self):
        return {
            "nodes": sorted(
                f"{space.rstrip('/')}/{name}" for name, space in self.node.get_node_names_and_namespaces()
            ),
            "topics": dict(self.node.get_topic_names_and_types()),
            "services": dict(self.node.get_service_names_and_types()),
        }

    def endpoints(self, topic):
        return {
            side: [
                {
                    "node": f"{info.node_namespace.rstrip('/')}/{info.node_name}",
                    "type": info.topic_type,
                    "hash": str(info.topic_type_hash),
                    "qos": described(info.qos_profile),
                }
                for info in found
            ]
            for side, found in (
                ("publishers", self.node.get_publishers_info_by_topic(topic)),
                ("subscriptions", self.node.get_subscriptions_info_by_topic(topic)),
            )
        }

    def many(self, nodes, endpoints):
        """Make nodes with publishers."""
        kind = interface("std_msgs/msg/String")
        for number in range(nodes):
            node = rclpy.create_node(f"many_{number}", start_parameter_services=False, enable_rosout=False)
            self.made[node.get_name()] = node
            for index in range(endpoints):
                self.made[f"{number}/{index}"] = node.create_publisher(kind, f"many/t{number}_{index}", 1)

    # services

    def serve(self, service, type, delay=0.0, fails=False, response=None):  # noqa: A002 - a name of the requests
        kind = interface(type)

        def handle(request, answer):
            print_line(event="request", service=service, request=to_json(request))
            time.sleep(delay)
            if fails:
                raise RuntimeError("the callback failed")
            return fill(answer, response or {})

        self.made[service] = self.call_in_turn(
            lambda: self.node.create_service(kind, service, handle, callback_group=self.group)
        )

    def call(self, service, type, requests):  # noqa: A002 - a name of the requests
        kind = interface(type)
        client = self.call_in_turn(lambda: self.node.create_client(kind, service, callback_group=self.group))
        if not client.wait_for_service(60.0):
            raise RuntimeError(f"no server of {service}")
        futures = [client.call_async(fill(kind.Request(), request)) for request in requests]
        found = [to_json(wait_for(future)) for future in futures]
        self.call_in_turn(lambda: self.node.destroy_client(client))
        return found

    # parameters

    def declare(self, name, value, read_only=False, low=None, high=None, refused=None):
        descriptor = ParameterDescriptor(read_only=read_only)
        if low is not None:
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        self.node.declare_parameter(name, value, descriptor)

        def check(parameters):
            for each in parameters:
                if each.name == name and each.value == refused:
                    return SetParametersResult(successful=False, reason=f"{name} is refused here")
            return SetParametersResult(successful=True)

        if refused is not None:
            self.node.add_on_set_parameters_callback(check)

    def set_parameter(self, name, value):
        self.call_in_turn(lambda: self.node.set_parameters([Parameter(name, value=value)]))

    def parameter(self, name):
        return self.node.get_parameter(name).value

    def follow_parameters(self):
        def receive(event):
            print_line(
                event="parameters",
                node=event.node,
                changed=[each.name for each in (*event.new_parameters, *event.changed_parameters)],
            )

        self.made["parameters"] = self.call_in_turn(
            lambda: self.node.create_subscription(ParameterEvent, "/parameter_events", receive, 100)
        )

    # actions

    def act(self, action, type, order="succeed", feedback=(), result=None, cancels=True, lasts=0.0):  # noqa: A002
        """Serve an action: goals have feedback, and end after a time with `order`, unless they are canceled."""
        kind = interface(type)

        def execute(goal):
            print_line(event="goal", action=action, goal=to_json(goal.request))
            for each in feedback:
                goal.publish_feedback(fill(kind.Feedback(), each))
            end = time.monotonic() + lasts
            while time.monotonic() < end:
                if goal.is_cancel_requested:
                    goal.canceled()
                    print_line(event="canceled", action=action)
                    return kind.Result()
                time.sleep(0.01)
            goal.abort() if order == "abort" else goal.succeed()
            return fill(kind.Result(), result or {})

        def answer_cancel(_):
            print_line(event="cancel", action=action)
            return CancelResponse.ACCEPT if cancels else CancelResponse.REJECT

        self.made[action] = self.call_in_turn(
            lambda: ActionServer(
                self.node,
                kind,
                action,
                execute,
                goal_callback=lambda _: GoalResponse.REJECT if order == "reject" else GoalResponse.ACCEPT,
                cancel_callback=answer_cancel,
                callback_group=self.group,
            )
        )

    def send_goal(self, action, type, goal, name="goal", cancel_after_feedback=False):  # noqa: A002
        """Send a goal; events report its acceptance, feedback and result."""
        kind = interface(type)
        key = f"client of {action}"
        if key not in self.made:
            self.made[key] = self.call_in_turn(
                lambda: ActionClient(self.node, kind, action, callback_group=self.group)
            )
        client = self.made[key]
        if not client.wait_for_server(60.0):
            raise RuntimeError(f"no server of {action}")

        def follow():
            def on_feedback(message):
                print_line(event="feedback", goal=name, feedback=to_json(message.feedback))
                if cancel_after_feedback and name in self.goals:
                    self.goals[name].cancel_goal_async()

            handle = wait_for(client.send_goal_async(fill(kind.Goal(), goal), on_feedback))
            print_line(event="accepted", goal=name, accepted=handle.accepted)
            if handle.accepted:
                self.goals[name] = handle
                found = wait_for(handle.get_result_async())
                print_line(event="result", goal=name, status=found.status, result=to_json(found.result))

        threading.Thread(target=follow, daemon=True).start()

    def cancel_goal(self, name="goal"):
        return [
            each.goal_id.uuid.tolist() for each in wait_for(self.goals[name].cancel_goal_async()).goals_canceling
        ]

    # clocks and life

    def time(self):
        return self.node.get_clock().now().nanoseconds

    def use_sim_time(self):
        self.set_parameter("use_sim_time", True)


def wait_for(future):
    while not future.done():
        time.sleep(0.002)
    return future.result()


class Life(LifecycleNode):
    """A lifecycle node; its parameter `failures` is the number of activations that fail."""

    def __init__(self, name):
        super().__init__(name)
        self.declare_parameter("failures", 0)

    def on_configure(self, state):
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        left = self.get_parameter("failures").value
        if left:
            self.set_parameters([Parameter("failures", value=left - 1)])
            return TransitionCallbackReturn.FAILURE
        return super().on_activate(state)


def serve_requests(steered):
    for line in sys.stdin:
        request = json.loads(line)
        number, do = request.pop("id"), request.pop("do")
        threading.Thread(target=answer, args=(steered, number, do, request), daemon=True).start()
    os._exit(0)  # rclpy may hang in its exit


def answer(steered, number, do, request):
    try:
        print_line(id=number, answer=getattr(steered, do)(**request))
    except Exception as error:
        print_line(id=number, error=repr(error))


def main():
    rclpy.init(args=sys.argv)
    name = sys.argv[1]
    node = Life(name) if name == "life" else rclpy.create_node(name)
    spinning = Spinning(node, threads=8)
    threading.Thread(target=serve_requests, args=(Steered(node, spinning),), daemon=True).start()
    print_line(event="ready")
    spinning.run()


if __name__ == "__main__":
    main()
