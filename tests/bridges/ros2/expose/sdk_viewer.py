"""Drives and watches a robot by another implementation of rmw_zenoh's wire: `python sdk_viewer.py PORT FOLDER`.

Definitions are in the folder, as PACKAGE/msg/NAME.msg, since it would look for them on the network. With every
scan that it gets, and tells of, it has the robot drive ahead.
"""

import sys
from pathlib import Path

from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber, get_message_class, get_registry


def tell(*words: object) -> None:
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def main() -> None:
    get_registry().messages_dir = Path(sys.argv[2])
    where = {"router_port": int(sys.argv[1]), "domain_id": 0}
    commands = ROS2Publisher("/turtlebot4/cmd_vel", msg_type="geometry_msgs/msg/Twist", **where)
    vector = get_message_class("geometry_msgs/msg/Vector3")

    def take(scan: object) -> None:
        tell(scan.header.frame_id, len(scan.ranges))  # type: ignore[attr-defined]
        commands.publish(linear=vector(x=0.2, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0))

    ROS2Subscriber("/turtlebot4/scan", msg_type="sensor_msgs/msg/LaserScan", callback=take, **where)
    tell("ready")
    sys.stdin.read()


if __name__ == "__main__":
    main()
