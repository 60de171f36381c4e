"""Actions of `osc.ros`.

Those without an actor are carried out in the ROS 2 system of the run (`--ros`). Two of them have a meaning without
one: `topic_publish` for robots in a simulator, `set_node_parameter` for faults of their sensors. Those of an actor
are carried out where it lives: in the simulator, or, if no simulator has a robot for it, in the ROS 2 system.
"""

from seoro.actions.ros_bags import bag_play, bag_record
from seoro.actions.ros_calls import action_call, service_call, set_node_parameter
from seoro.actions.ros_checks import assert_topic_latency, check_data, log_check
from seoro.actions.ros_external import check_data_external
from seoro.actions.ros_frames import assert_tf_moving, odometry_distance_traveled, tf_close_to
from seoro.actions.ros_lifecycle import assert_lifecycle_state
from seoro.actions.ros_programs import ros_launch, ros_run
from seoro.actions.ros_topics import topic_monitor, topic_publish, wait_for_data
from seoro.actions.ros_waits import (
    wait_for_nodes,
    wait_for_service_server,
    wait_for_services,
    wait_for_topic_publisher,
    wait_for_topic_subscription,
    wait_for_topics,
)

__all__ = [
    "action_call",
    "assert_lifecycle_state",
    "assert_tf_moving",
    "assert_topic_latency",
    "bag_play",
    "bag_record",
    "check_data",
    "check_data_external",
    "log_check",
    "odometry_distance_traveled",
    "ros_launch",
    "ros_run",
    "service_call",
    "set_node_parameter",
    "tf_close_to",
    "topic_monitor",
    "topic_publish",
    "wait_for_data",
    "wait_for_nodes",
    "wait_for_service_server",
    "wait_for_services",
    "wait_for_topic_publisher",
    "wait_for_topic_subscription",
    "wait_for_topics",
]
