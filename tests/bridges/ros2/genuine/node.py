"""A genuine ROS 2 node, for an environment with rclpy: `node.py KIND [ARGUMENT] [--ros-args ...]`.

It prints a line for each event.
"""

import os
import sys
import time

import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from std_msgs.msg import String
from std_srvs.srv import SetBool
from test_msgs.action import Fibonacci
from test_msgs.msg import BasicTypes as Basic
from test_msgs.srv import BasicTypes


def print_line(text):
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def talk(node, text):
    publisher = node.create_publisher(String, "chatter", 10)
    node.create_timer(0.05, lambda: publisher.publish(String(data=text or "hello")))


def listen(node, _):
    node.create_subscription(String, "chatter", lambda message: print_line(f"received {message.data}"), 10)


def write_log(node, text):
    node.create_timer(0.1, lambda: node.get_logger().info(text))


def serve(node, _):
    def enable(request, response):
        response.success, response.message = request.data, "on" if request.data else "off"
        return response

    def echo(request, response):
        response.string_value = request.string_value.upper()
        return response

    node.create_service(SetBool, "enable", enable)
    node.create_service(BasicTypes, "basic", echo)
    publisher = node.create_publisher(Basic, "basics", 1)
    node.create_timer(0.05, lambda: publisher.publish(Basic(int32_value=42)))


def act(node, cancels):
    """Serve /fibonacci; a goal lasts 0.1 s for each unit of its order."""

    def execute(goal):
        end = time.monotonic() + goal.request.order / 10
        print_line("accepted")
        while time.monotonic() < end:
            if goal.is_cancel_requested:
                goal.canceled()
                print_line("canceled")
                return Fibonacci.Result()
            time.sleep(0.01)
        goal.succeed()
        print_line("succeeded")
        return Fibonacci.Result(sequence=[0, 1, 1])

    def cancel(_):
        print_line("asked to cancel")
        return CancelResponse.ACCEPT

    answers = {"cancel_callback": cancel} if cancels == "cancels" else {}  # rclpy rejects by default
    node.server = ActionServer(
        node,
        Fibonacci,
        "fibonacci",
        execute,
        goal_callback=lambda goal: GoalResponse.REJECT if goal.order > 900 else GoalResponse.ACCEPT,
        callback_group=ReentrantCallbackGroup(),
        **answers,
    )


KINDS = {"talker": talk, "listener": listen, "logger": write_log, "server": serve, "actor": act}


def main():
    rclpy.init(args=sys.argv)
    kind, argument = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""
    node = rclpy.create_node(kind)
    KINDS[kind](node, argument)
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    print_line("ready")
    try:
        executor.spin()
    finally:
        os._exit(0)  # rclpy may hang in its exit


if __name__ == "__main__":
    main()
