"""Actions of `osc.ros`.

Actions without an actor use the ROS 2 system of the run (`--ros`). Two of them also work without one:
`topic_publish` for robots in a simulator, `set_node_parameter` for faults of their sensors. Actions of an actor
use its simulator or, if no simulator has a robot for it, the ROS 2 system.
"""

# ruff: noqa: F401 - the library consists of what this module contains

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
