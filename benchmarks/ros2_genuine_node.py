"""Genuine ROS 2 nodes of `ros2_genuine.py`, in an environment with rclpy: `ros2_genuine_node.py ROLE [ARGUMENT]`.

They print `ready`, and results as JSON.
"""

import array
import json
import math
import os
import sys
import time

import rclpy
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

DEEP = QoSProfile(depth=100)
BEAMS = 360
GRAPH_PERIOD = 0.02  # [s] between looks at the graph


def print_line(text):
    """Print a line at once."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def echo(node):
    """Return each message of /ping_KIND on /pong_KIND, and each velocity of /cmd_vel on /seen_vel."""
    for kind in (Header, Image):
        pong = node.create_publisher(kind, f"pong_{kind.__name__}", DEEP)
        node.create_subscription(kind, f"ping_{kind.__name__}", pong.publish, DEEP)
    seen = node.create_publisher(Twist, "seen_vel", DEEP)
    node.create_subscription(Twist, "cmd_vel", seen.publish, DEEP)


def ping(node, kind, size, rate, count):
    """Publish on /ping_KIND, and print the times until the echoes [ns]."""
    if kind == "Header":
        type_, message = Header, Header(frame_id="x" * int(size))
        number, read = (lambda value: message.stamp.__setattr__("sec", value)), (lambda echoed: echoed.stamp.sec)
    else:
        type_, message = Image, Image(data=array.array("B", bytes(int(size))))
        number, read = (lambda value: message.__setattr__("height", value)), (lambda echoed: echoed.height)
    publisher = node.create_publisher(type_, f"ping_{kind}", DEEP)
    sent, taken = {}, {}

    def take(echoed):
        taken[read(echoed)] = time.perf_counter_ns()

    node.create_subscription(type_, f"pong_{kind}", take, DEEP)
    period, count = 1.0 / float(rate), int(count)
    start = time.monotonic() + 1.0

    def send():
        if time.monotonic() < start or len(sent) == count:
            return
        number(len(sent))
        sent[len(sent)] = time.perf_counter_ns()
        publisher.publish(message)

    def finish():
        if len(sent) == count and (len(taken) == count or time.monotonic() > start + count * period + 2.0):
            print_line(
                json.dumps([taken.get(each, 0) - at if each in taken else None for each, at in sent.items()])
            )
            os._exit(0)

    node.create_timer(period, send)
    node.create_timer(0.1, finish)


def robot(node):
    """Be a robot: odometry at 50 Hz, a scan at 10 Hz, and transforms at 100 Hz; note velocities."""
    odometry = node.create_publisher(Odometry, "odom", DEEP)
    scans = node.create_publisher(LaserScan, "scan", DEEP)
    frames = node.create_publisher(TFMessage, "tf", DEEP)
    node.create_subscription(
        Twist, "cmd_vel", lambda twist: print_line(f"velocity {time.monotonic()} {twist.linear.x}"), DEEP
    )

    def stamp():
        return node.get_clock().now().to_msg()

    def move():
        message = Odometry(child_frame_id="base_link")
        message.header.frame_id, message.header.stamp = "odom", stamp()
        message.pose.pose.orientation.w = 1.0
        odometry.publish(message)

    def scan():
        message = LaserScan(angle_min=-math.pi, angle_max=math.pi, angle_increment=2 * math.pi / BEAMS)
        message.header.frame_id, message.header.stamp = "laser", stamp()
        message.range_max, message.ranges = 10.0, [3.0] * BEAMS
        scans.publish(message)

    def turn():
        transform = TransformStamped(child_frame_id="base_link")
        transform.header.frame_id, transform.header.stamp = "odom", stamp()
        transform.transform.rotation.w = 1.0
        frames.publish(TFMessage(transforms=[transform]))

    node.create_timer(0.02, move)
    node.create_timer(0.1, scan)
    node.create_timer(0.01, turn)


def watch(node):
    """Print which other nodes are in the graph, whenever that changes."""
    seen = []

    def look():
        nonlocal seen
        found = sorted({f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces()})
        if found != seen:
            seen = found
            print_line(f"graph {time.monotonic()} {' '.join(found)}")

    node.create_timer(GRAPH_PERIOD, look)


def main():
    """Run a node of a role."""
    role, *arguments = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node(f"genuine_{role}")
    {"echo": echo, "ping": ping, "robot": robot, "watch": watch}[role](node, *arguments)
    print_line("ready")
    try:
        rclpy.spin(node)
    finally:
        os._exit(0)


if __name__ == "__main__":
    main()
