"""Conversion of samples of cameras and listed sensors to ROS 2 messages.

Images have the optical frame of REP 103: z ahead, x to the right, y down. Pixels are counted at their centres.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seoro.bridges import wire
from seoro.bridges.ros2.geometry import header, vector_message

Fields = dict[str, Any]
FLOAT32, UINT32 = 7, 6  # types of `sensor_msgs/PointField`
ULTRASOUND = 0
FIX, GPS_SERVICE, DIAGONAL_KNOWN = 0, 1, 2  # of `sensor_msgs/NavSatFix`
FLOAT_SIZE = 4  # [bytes]


def image(data: bytes, encoding: str, shape: tuple[int, int], frame: str, time: float) -> Fields:
    """Make a `sensor_msgs/Image`.

    Args:
        data: Pixels by row from the top, little-endian.
        encoding: Encoding of a pixel, such as `rgb8`.
        shape: Width and height [pixels].
        frame: Optical frame.
        time: Time of the image [s].
    """
    width, height = shape
    return {
        "header": header(frame, time),
        "height": height,
        "width": width,
        "encoding": encoding,
        "step": len(data) // height,
        "data": np.frombuffer(data, dtype=np.uint8),
    }


def focal_length(sensor: wire.MountedSensor) -> float:
    """Return the focal length of a pinhole camera with square pixels [pixels]."""
    return sensor.height / 2.0 / math.tan(sensor.fov / 2.0)


def camera_info(sensor: wire.MountedSensor, frame: str, time: float) -> Fields:
    """Make a `sensor_msgs/CameraInfo` of a camera without distortion."""
    focal, u, v = focal_length(sensor), (sensor.width - 1) / 2.0, (sensor.height - 1) / 2.0
    return {
        "header": header(frame, time),
        "height": sensor.height,
        "width": sensor.width,
        "distortion_model": "plumb_bob",
        "d": np.zeros(5),
        "k": np.array([focal, 0.0, u, 0.0, focal, v, 0.0, 0.0, 1.0]),
        "r": np.eye(3).ravel(),
        "p": np.array([focal, 0.0, u, 0.0, 0.0, focal, v, 0.0, 0.0, 0.0, 1.0, 0.0]),
    }


def lidar_cloud(cloud: wire.PointCloud, frame: str, time: float) -> Fields:
    """Make a `sensor_msgs/PointCloud2` with a row for each ring; points without a return are NaN."""
    return _cloud(np.frombuffer(cloud.points, "<f4").reshape(cloud.rings, cloud.beams, 3), frame, time)


def depth_cloud(sample: wire.DepthSample, sensor: wire.MountedSensor, frame: str, time: float) -> Fields:
    """Make a `sensor_msgs/PointCloud2` with a point for each pixel, also with its colour, if it has one.

    Points without a distance are NaN.
    """
    depths = np.frombuffer(sample.depths, "<f4").reshape(sample.height, sample.width)
    z = np.where(np.isfinite(depths), depths, np.float32(np.nan))
    rows, columns = np.mgrid[: sample.height, : sample.width]
    focal = focal_length(sensor)
    x = (columns - (sample.width - 1) / 2.0) / focal * z
    y = (rows - (sample.height - 1) / 2.0) / focal * z
    points = np.stack([x, y, z], axis=-1).astype("<f4")
    if not sample.picture:
        return _cloud(points, frame, time)
    red, green, blue = (
        np.frombuffer(sample.picture, np.uint8).reshape(sample.height, sample.width, 3).T.astype("<u4")
    )
    colours = (red << 16 | green << 8 | blue).T.astype("<u4").view("<f4")
    return _cloud(np.dstack([points, colours]), frame, time)


def _cloud(points: NDArray[np.float32], frame: str, time: float) -> Fields:
    height, width, count = points.shape
    names = ("x", "y", "z", "rgb")[:count]
    return {
        "header": header(frame, time),
        "height": height,
        "width": width,
        "fields": [
            {"name": name, "offset": FLOAT_SIZE * index, "datatype": FLOAT32, "count": 1}
            for index, name in enumerate(names)
        ],
        "point_step": FLOAT_SIZE * count,
        "row_step": FLOAT_SIZE * count * width,
        "data": np.frombuffer(points.tobytes(), dtype=np.uint8),
        "is_dense": bool(np.isfinite(points[..., :3]).all()),
    }


def sonar_range(echo: wire.RangeSample, sensor: wire.MountedSensor, frame: str, time: float) -> Fields:
    """Make a `sensor_msgs/Range`; infinite without an echo (REP 117)."""
    return {
        "header": header(frame, time),
        "radiation_type": ULTRASOUND,
        "field_of_view": sensor.aperture,
        "min_range": sensor.range_min,
        "max_range": sensor.range_max,
        "range": echo.range,
    }


def wrench(sample: wire.WrenchSample, frame: str, time: float) -> Fields:
    """Make a `geometry_msgs/WrenchStamped` in the frame of the link of the sensor."""
    found = {"force": vector_message(sample.force), "torque": vector_message(sample.torque)}
    return {"header": header(frame, time), "wrench": found}


def satellite_fix(fix: wire.NavSatFix, sensor: wire.MountedSensor, frame: str, time: float) -> Fields:
    """Make a `sensor_msgs/NavSatFix` with the variances of the declared noise, without the drift."""
    return {
        "header": header(frame, time),
        "status": {"status": FIX, "service": GPS_SERVICE},
        "latitude": fix.latitude,
        "longitude": fix.longitude,
        "altitude": fix.altitude,
        "position_covariance": np.diag([deviation**2 for deviation in sensor.deviations]).ravel(),
        "position_covariance_type": DIAGONAL_KNOWN,
    }


def detections(sample: wire.SegmentationSample, frame: str, time: float) -> Fields:
    """Make a `vision_msgs/Detection2DArray` with the boxes of all entities, whose classes are their names."""
    return {"header": header(frame, time), "detections": [_detection(seen, frame, time) for seen in sample.seen]}


def _detection(seen: wire.SeenEntity, frame: str, time: float) -> Fields:
    centre = {"x": (seen.left + seen.right - 1) / 2.0, "y": (seen.top + seen.bottom - 1) / 2.0}
    return {
        "header": header(frame, time),
        "results": [{"hypothesis": {"class_id": seen.entity, "score": 1.0}}],
        "bbox": {
            "center": {"position": centre},
            "size_x": float(seen.right - seen.left),
            "size_y": float(seen.bottom - seen.top),
        },
        "id": seen.entity,
    }


def label_info(sample: wire.SegmentationSample, frame: str, time: float) -> Fields:
    """Make a `vision_msgs/LabelInfo` with the names of the numbers in a label image."""
    names = [{"class_id": number, "class_name": name} for number, name in enumerate(sample.names, start=1)]
    return {"header": header(frame, time), "class_map": names, "threshold": 0.0}
