"""A genuine ROS 2 node, for an environment with rclpy: `node.py KIND [ARGUMENT] [--ros-args ...]`.

It prints a line for each event.
"""

import json
import os
import struct
import sys
import time

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image, NavSatFix, PointCloud2, Range
from spinning import Spinning
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


SENSED = {
    "front/image_raw": (
        Image,
        lambda image: [image.width, image.height, image.step, image.encoding, len(image.data), max(image.data)],
    ),
    "front/camera_info": (CameraInfo, lambda info: [info.width, info.height, info.k[0], info.p[6]]),
    "top/points": (
        PointCloud2,
        lambda cloud: [
            *(field.name for field in cloud.fields),
            *struct.unpack_from("<3f", cloud.data, cloud.point_step * (cloud.width // 2)),
        ],
    ),
    "nose/range": (Range, lambda echo: [echo.radiation_type, echo.max_range, echo.range]),
    "mast/wrench": (WrenchStamped, lambda sample: [sample.header.frame_id, sample.wrench.force.z]),
    "gps/fix": (
        NavSatFix,
        lambda fix: [fix.status.status, fix.latitude, fix.longitude, fix.position_covariance[8]],
    ),
}


def sense(node, namespace):
    """Print the content of the first message of each sensor of a robot, in one line."""
    seen = {}

    def subscribe(topic, kind, read):
        def receive(message):
            if topic not in seen:
                seen[topic] = read(message)
                if len(seen) == len(SENSED):
                    print_line(f"sensed {json.dumps(seen)}")

        node.create_subscription(kind, f"{namespace}/{topic}", receive, qos_profile_sensor_data)

    for topic, (kind, read) in SENSED.items():
        subscribe(topic, kind, read)


def press(node, topic):
    """Publish a force that grows by 1 N at each message."""
    publisher = node.create_publisher(WrenchStamped, topic, qos_profile_sensor_data)
    message = WrenchStamped()

    def publish():
        message.wrench.force.z -= 1.0
        publisher.publish(message)

    node.create_timer(0.05, publish)


KINDS = {
    "talker": talk,
    "listener": listen,
    "logger": write_log,
    "server": serve,
    "actor": act,
    "viewer": sense,
    "presser": press,
}


def main():
    rclpy.init(args=sys.argv)
    kind, argument = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""
    node = rclpy.create_node(kind)
    KINDS[kind](node, argument)
    print_line("ready")
    try:
        Spinning(node, threads=4).run()
    finally:
        os._exit(0)  # rclpy may hang in its exit


if __name__ == "__main__":
    main()
