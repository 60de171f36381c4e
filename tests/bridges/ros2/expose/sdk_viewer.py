"""A node of another rmw_zenoh implementation that drives a robot: `python sdk_viewer.py PORT FOLDER`.

The folder contains the definitions as PACKAGE/msg/NAME.msg, so that the node does not search the network for them.
On each scan, the node prints a line and commands the robot to drive ahead.
"""

import sys
from pathlib import Path

from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber, get_message_class, get_registry


def report(*words: object) -> None:
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def main() -> None:
    get_registry().messages_dir = Path(sys.argv[2])
    where = {"router_port": int(sys.argv[1]), "domain_id": 0}
    commands = ROS2Publisher("/turtlebot4/cmd_vel", msg_type="geometry_msgs/msg/Twist", **where)
    vector = get_message_class("geometry_msgs/msg/Vector3")

    def take(scan: object) -> None:
        report(scan.header.frame_id, len(scan.ranges))  # type: ignore[attr-defined]
        commands.publish(linear=vector(x=0.2, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0))

    ROS2Subscriber("/turtlebot4/scan", msg_type="sensor_msgs/msg/LaserScan", callback=take, **where)
    report("ready")
    sys.stdin.read()


if __name__ == "__main__":
    main()
