"""Conversion of samples of simulated robots to ROS 2 messages (REP 103 and 105)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from seoro.bridges import wire
from seoro.bridges.ros2.geometry import header, pose_message, stamp, transform_message, vector_message

MAP, ODOM = "map", "odom"

DISCHARGING = 2  # `POWER_SUPPLY_STATUS_DISCHARGING`

Fields = dict[str, Any]


def clock(time: float) -> Fields:
    """Make a `rosgraph_msgs/Clock` from a time [s]."""
    return {"clock": stamp(time)}


def laser_scan(scan: wire.LaserScan, lidar: wire.LidarDescription, time: float) -> Fields:
    """Make a `sensor_msgs/LaserScan` in the frame of the link of the lidar."""
    bearings = scan.bearings
    increment = (bearings[-1] - bearings[0]) / (len(bearings) - 1) if len(bearings) > 1 else 0.0
    first = bearings[0] - lidar.yaw
    return {
        "header": header(lidar.link, time),
        "angle_min": first,
        "angle_max": first + increment * (len(bearings) - 1),
        "angle_increment": increment,
        "scan_time": 1.0 / lidar.rate,
        "range_min": lidar.range_min,
        "range_max": lidar.range_max,
        "ranges": np.array(scan.ranges, dtype=np.float32),
    }


def odometry(sample: wire.OdometrySample, base: str, time: float) -> Fields:
    """Make a `nav_msgs/Odometry`, without covariances."""
    return {
        "header": header(ODOM, time),
        "child_frame_id": base,
        "pose": {"pose": pose_message(sample.pose)},
        "twist": {
            "twist": {"linear": {"x": sample.linear, "y": sample.lateral}, "angular": {"z": sample.angular}}
        },
    }


def imu(sample: wire.ImuSample, base: str, time: float) -> Fields:
    """Make a `sensor_msgs/Imu`, without an orientation, which the sensor does not measure."""
    unknown = np.zeros(9)
    unknown[0] = -1.0
    return {
        "header": header(base, time),
        "orientation_covariance": unknown,
        "angular_velocity": vector_message(sample.angular_rate),
        "linear_acceleration": vector_message(sample.acceleration),
    }


def battery_state(charge: float, base: str, time: float) -> Fields:
    """Make a `sensor_msgs/BatteryState` of a charge from 0 to 1; unknown fields are NaN."""
    unknown = ("voltage", "temperature", "current", "charge", "capacity", "design_capacity")
    return {
        "header": header(base, time),
        **dict.fromkeys(unknown, math.nan),
        "percentage": charge,
        "power_supply_status": DISCHARGING,
        "present": True,
    }


def estimated_pose(pose: wire.StreamedPose, time: float) -> Fields:
    """Make a `geometry_msgs/PoseWithCovarianceStamped` in the map, as AMCL publishes it."""
    covariance = np.zeros(36)
    covariance[[0, 7]] = pose.deviation**2 / 2.0  # equal for both axes
    return {"header": header(MAP, time), "pose": {"pose": pose_message(pose.base), "covariance": covariance}}


def occupancy_grid(grid: wire.OccupancyGrid) -> Fields:
    """Make a `nav_msgs/OccupancyGrid`, as a map server publishes it."""
    info = {
        "resolution": grid.resolution,
        "width": grid.columns,
        "height": grid.rows,
        "origin": pose_message(wire.Pose3D(wire.Position3D(grid.x, grid.y))),
    }
    return {"header": header(MAP, 0.0), "info": info, "data": np.frombuffer(grid.cells, dtype=np.int8)}


def joint_state(joints: wire.JointStates, time: float) -> Fields:
    """Make a `sensor_msgs/JointState`."""
    return {
        "header": header("", time),
        "name": list(joints.names),
        "position": np.array(joints.positions),
        "velocity": np.array(joints.velocities),
        "effort": np.array(joints.efforts),
    }


def transform(parent: str, child: str, pose: wire.Pose3D, time: float) -> Fields:
    """Make a `geometry_msgs/TransformStamped`."""
    return {"header": header(parent, time), "child_frame_id": child, "transform": transform_message(pose)}
