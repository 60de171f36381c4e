"""What robots of a simulator sense, as messages of ROS 2 (REP 103 and 105)."""

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
    """A `rosgraph_msgs/Clock` of a time [s]."""
    return {"clock": stamp(time)}


def laser_scan(scan: wire.LaserScan, lidar: wire.LidarDescription, time: float) -> Fields:
    """A `sensor_msgs/LaserScan`, in the frame of the link that the lidar is on."""
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
    """A `nav_msgs/Odometry`; it says nothing of how far it is off."""
    return {
        "header": header(ODOM, time),
        "child_frame_id": base,
        "pose": {"pose": pose_message(sample.pose)},
        "twist": {"twist": {"linear": {"x": sample.linear}, "angular": {"z": sample.angular}}},
    }


def imu(sample: wire.ImuSample, base: str, time: float) -> Fields:
    """A `sensor_msgs/Imu`, without an orientation, which such a unit does not know."""
    unknown = np.zeros(9)
    unknown[0] = -1.0
    return {
        "header": header(base, time),
        "orientation_covariance": unknown,
        "angular_velocity": vector_message(sample.angular_rate),
        "linear_acceleration": vector_message(sample.acceleration),
    }


def battery_state(charge: float, base: str, time: float) -> Fields:
    """A `sensor_msgs/BatteryState` of a charge from 0 to 1; what simulated ones do not have is no number."""
    unknown = math.nan
    return {
        "header": header(base, time),
        "voltage": unknown,
        "temperature": unknown,
        "current": unknown,
        "charge": unknown,
        "capacity": unknown,
        "design_capacity": unknown,
        "percentage": charge,
        "power_supply_status": DISCHARGING,
        "present": True,
    }


def believed_pose(told: wire.StreamedPose, time: float) -> Fields:
    """A `geometry_msgs/PoseWithCovarianceStamped` in the map, as AMCL publishes it."""
    covariance = np.zeros(36)
    covariance[[0, 7]] = told.deviation**2 / 2.0  # both axes alike
    return {"header": header(MAP, time), "pose": {"pose": pose_message(told.base), "covariance": covariance}}


def occupancy_grid(grid: wire.OccupancyGrid) -> Fields:
    """A `nav_msgs/OccupancyGrid`, as a map server publishes it."""
    info = {
        "resolution": grid.resolution,
        "width": grid.columns,
        "height": grid.rows,
        "origin": pose_message(wire.Pose(position=wire.Vector3(x=grid.x, y=grid.y))),
    }
    return {"header": header(MAP, 0.0), "info": info, "data": np.frombuffer(grid.cells, dtype=np.int8)}


def joint_state(joints: wire.JointStates, time: float) -> Fields:
    """A `sensor_msgs/JointState`."""
    return {
        "header": header("", time),
        "name": list(joints.names),
        "position": np.array(joints.positions),
        "velocity": np.array(joints.velocities),
        "effort": np.array(joints.efforts),
    }


def transform(parent: str, child: str, pose: wire.Pose, time: float) -> Fields:
    """A `geometry_msgs/TransformStamped`."""
    return {"header": header(parent, time), "child_frame_id": child, "transform": transform_message(pose)}
