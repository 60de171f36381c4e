"""A genuine mobile robot, for an environment with rclpy: `mobile.py [OPTIONS as JSON] [--ros-args ...]`.

It drives by `cmd_vel`, has odometry, a lidar, an IMU, a camera and a battery, is localised by `initialpose`, and
drives to goals of `navigate_to_pose`. Options: `without` lists names that it lacks, `stamped` selects
`TwistStamped`, `ahead` [s] sets its clock.
"""

import json
import math
import os
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Twist, TwistStamped
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, CameraInfo, Imu, LaserScan
from spinning import Spinning
from tf2_msgs.msg import TFMessage

TICK = 0.05  # [s]
SPEED = 0.4  # [m/s] of goals
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Robot:
    def __init__(self, node, without=(), stamped=False, ahead=0.0):
        self.node, self.ahead = node, ahead
        self.x = self.y = self.yaw = self.linear = self.angular = 0.0
        self.offset = None  # of odom in the map
        self.commanded = 0.0
        self.lock = threading.Lock()
        node.declare_parameter("max_linear_speed", 0.5)
        made = {
            "odom": lambda: node.create_publisher(Odometry, "odom", 10),
            "tf": lambda: node.create_publisher(TFMessage, "tf", 100),
            "tf_static": lambda: node.create_publisher(TFMessage, "tf_static", LATCHED),
            "scan": lambda: node.create_publisher(LaserScan, "scan", qos_profile_sensor_data),
            "imu": lambda: node.create_publisher(Imu, "imu", qos_profile_sensor_data),
            "camera": lambda: node.create_publisher(CameraInfo, "camera/camera_info", qos_profile_sensor_data),
            "battery": lambda: node.create_publisher(BatteryState, "battery_state", 10),
            "amcl_pose": lambda: node.create_publisher(PoseWithCovarianceStamped, "amcl_pose", LATCHED),
        }
        self.publishers = {name: make() for name, make in made.items() if name not in without}
        if "cmd_vel" not in without:
            node.create_subscription(TwistStamped if stamped else Twist, "cmd_vel", self.command, 10)
        if "amcl_pose" not in without:
            node.create_subscription(PoseWithCovarianceStamped, "initialpose", self.localise, 10)
        if "navigate_to_pose" not in without:
            self.server = ActionServer(
                node,
                NavigateToPose,
                "navigate_to_pose",
                self.navigate,
                cancel_callback=lambda _: CancelResponse.ACCEPT,
                callback_group=ReentrantCallbackGroup(),
            )
        self.put("tf_static", TFMessage(transforms=[self.transform("base_link", "laser", 0.1, 0.0, 0.0)]))
        node.create_timer(TICK, self.step)

    def put(self, name, message):
        if name in self.publishers:
            self.publishers[name].publish(message)

    def stamp(self, header, frame):
        now = time.time_ns() + round(self.ahead * 1e9)
        header.frame_id, header.stamp.sec, header.stamp.nanosec = frame, now // 10**9, now % 10**9

    def transform(self, parent, child, x, y, yaw):
        found = TransformStamped(child_frame_id=child)
        self.stamp(found.header, parent)
        found.transform.translation.x, found.transform.translation.y = x, y
        found.transform.rotation.z, found.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        return found

    def command(self, message):
        twist = message.twist if hasattr(message, "twist") else message
        self.linear, self.angular, self.commanded = twist.linear.x, twist.angular.z, time.monotonic()

    def localise(self, message):
        place = message.pose.pose.position
        self.offset = (place.x - self.x, place.y - self.y)
        self.stamp(message.header, "map")
        self.put("amcl_pose", message)

    def navigate(self, goal):
        target = goal.request.pose.pose.position
        while True:
            x, y = (a + b for a, b in zip(self.offset or (0.0, 0.0), (self.x, self.y), strict=True))
            left = math.dist((x, y), (target.x, target.y))
            if goal.is_cancel_requested:
                goal.canceled()
                break
            if left < 0.02:
                goal.succeed()
                break
            step = min(left, SPEED * TICK)
            with self.lock:
                self.x += (target.x - x) / left * step
                self.y += (target.y - y) / left * step
            goal.publish_feedback(NavigateToPose.Feedback(distance_remaining=left))
            time.sleep(TICK)
        return NavigateToPose.Result()

    def step(self):
        if time.monotonic() > self.commanded + 0.5:
            self.linear = self.angular = 0.0
        with self.lock:
            self.yaw += self.angular * TICK
            self.x += self.linear * math.cos(self.yaw) * TICK
            self.y += self.linear * math.sin(self.yaw) * TICK
        base = self.transform("odom", "base_link", self.x, self.y, self.yaw)
        moving = [base]
        if self.offset is not None:
            moving.append(self.transform("map", "odom", *self.offset, 0.0))
        self.put("tf", TFMessage(transforms=moving))
        odometry = Odometry(header=base.header, child_frame_id="base_link")
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = self.x, self.y
        odometry.pose.pose.orientation = base.transform.rotation
        odometry.twist.twist.linear.x, odometry.twist.twist.angular.z = self.linear, self.angular
        self.put("odom", odometry)
        for name, message, frame in (
            ("scan", LaserScan(range_max=12.0, ranges=[3.0] * 180), "laser"),
            ("imu", Imu(), "imu_link"),
            ("camera", CameraInfo(width=640, height=480), "camera"),
            ("battery", BatteryState(percentage=0.8), ""),
        ):
            self.stamp(message.header, frame)
            self.put(name, message)


def main():
    rclpy.init(args=sys.argv)
    options = json.loads(sys.argv[1]) if sys.argv[1:2] and sys.argv[1].startswith("{") else {}
    node = rclpy.create_node("driver")
    robot = Robot(node, **options)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    try:
        Spinning(node, threads=4).run()
    finally:
        del robot
        os._exit(0)  # rclpy may hang in its exit


if __name__ == "__main__":
    main()
