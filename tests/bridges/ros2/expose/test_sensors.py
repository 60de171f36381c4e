from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seoro.bridges.ros2.expose.sensors import SENSOR_DATA
from seoro.bridges.ros2.geometry import seconds
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import LATCHED, Qos
from tests.bridges.ros2.expose.exposed import Exposed, exposed, first
from tests.sim_nodes.engines import needs_pictures
from tests.sim_nodes.sensors.bench import room_with

pytestmark = pytest.mark.engine("mujoco")

SENSORS = """  - {kind: lidar_3d, name: top, link: base_link, z: 0.5, rings: 4, beams: 36, lowest: 0.0,
     max_range: 30.0}
  - {kind: sonar, name: nose, link: base_link, x: 0.2, z: 0.5, max_range: 4.0, aperture: 0.1}
  - {kind: force_torque, name: mast, link: rplidar_link}
  - {kind: gps, name: gps, link: base_link, z: 0.4, noise: 0.5, height_noise: 1.0}
"""
PIXELS = """  - {kind: rgbd_camera, name: deep, link: base_link, x: 0.25, z: 0.5, fov: 1.2, width: 96, height: 64,
     max_range: 6.0}
  - {kind: segmentation, name: eye, link: base_link, x: 0.25, z: 0.5, fov: 1.2, width: 96, height: 64}
"""
PLACE = "geo_origin: {latitude: 48.1, longitude: 11.6, altitude: 520.0}\n"
FOCAL = 32.0 / math.tan(0.6)  # [pixels]
CAMERA_INFO, IMAGE = "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/Image"


@asynccontextmanager
async def subscribed(
    node: Exposed, topics: dict[str, str], qos: Qos = SENSOR_DATA
) -> AsyncIterator[dict[str, Any]]:
    """Yield the first messages of topics of the robot, by topic."""
    async with AsyncExitStack() as stack:
        found: dict[str, Subscription] = {
            topic: await stack.enter_async_context(node.ros.subscribing(f"/turtlebot4/{topic}", kind, qos))
            for topic, kind in topics.items()
        }
        yield {topic: (await first(each))[0] for topic, each in found.items()}


def points_of(cloud: Any) -> Any:
    count = cloud.point_step // 4
    return np.frombuffer(cloud.data.tobytes(), "<f4").reshape(cloud.height, cloud.width, count)


async def test_listed_sensors_are_published(simulator: str, router: str, types: TypeStore, tmp_path: Path) -> None:
    topics = {
        "top/points": "sensor_msgs/msg/PointCloud2",
        "nose/range": "sensor_msgs/msg/Range",
        "mast/wrench": "geometry_msgs/msg/WrenchStamped",
        "gps/fix": "sensor_msgs/msg/NavSatFix",
    }
    async with (
        exposed(simulator, router, types, room_with(tmp_path, SENSORS, PLACE), rate=1.0) as node,
        subscribed(node, topics) as found,
        subscribed(node, {"tf_static": "tf2_msgs/msg/TFMessage"}, LATCHED) as fixed,
    ):
        cloud = found["top/points"]
        assert (cloud.height, cloud.width, cloud.header.frame_id) == (4, 36, "top_frame")
        assert [field.name for field in cloud.fields] == ["x", "y", "z"]
        assert points_of(cloud)[0, 18] == pytest.approx([3.0, 0.0, 0.0], abs=0.05)
        assert not cloud.is_dense  # some beams leave the room
        echo = found["nose/range"]
        assert (echo.radiation_type, echo.field_of_view, echo.max_range) == (0, pytest.approx(0.1), 4.0)
        assert echo.range == pytest.approx(2.8, abs=0.05)
        assert found["mast/wrench"].header.frame_id == "rplidar_link"
        assert found["mast/wrench"].wrench.force.z < -1.0  # its weight
        fix = found["gps/fix"]
        assert (fix.latitude, fix.longitude) == pytest.approx((48.1, 11.6), abs=1e-4)
        assert fix.position_covariance.tolist() == [0.25, 0, 0, 0, 0.25, 0, 0, 0, 1.0]
        frames = {each.child_frame_id: each for each in fixed["tf_static"].transforms}
        assert frames["top_frame"].transform.translation.z == pytest.approx(0.5)
        assert "mast_frame" not in frames


async def test_pictures_and_depths_are_published_in_optical_frames(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    needs_pictures("mujoco")
    topics = {
        "front/image_raw": IMAGE,
        "front/camera_info": CAMERA_INFO,
        "deep/depth/image_raw": IMAGE,
        "deep/points": "sensor_msgs/msg/PointCloud2",
        "eye/labels": IMAGE,
        "eye/label_info": "vision_msgs/msg/LabelInfo",
        "eye/detections": "vision_msgs/msg/Detection2DArray",
    }
    async with (
        exposed(simulator, router, types, room_with(tmp_path, PIXELS), rate=1.0) as node,
        subscribed(node, topics) as found,
        subscribed(node, {"tf_static": "tf2_msgs/msg/TFMessage"}, LATCHED) as fixed,
    ):
        picture, info = found["front/image_raw"], found["front/camera_info"]
        assert (picture.width, picture.height, picture.step, picture.encoding) == (640, 480, 1920, "rgb8")
        assert picture.header.frame_id == info.header.frame_id == "front_optical_frame"
        assert seconds(picture.header.stamp) * 10 == pytest.approx(round(seconds(picture.header.stamp) * 10))
        assert info.k[[0, 2, 4, 5]] == pytest.approx([240 / math.tan(0.48), 319.5, 240 / math.tan(0.48), 239.5])
        depth = found["deep/depth/image_raw"]
        assert (depth.encoding, depth.step) == ("32FC1", 4 * 96)
        ahead = np.frombuffer(depth.data.tobytes(), "<f4").reshape(64, 96)[32, 48]
        assert ahead == pytest.approx(2.75, abs=0.02)
        cloud = points_of(found["deep/points"])
        x, y, z, _ = cloud[32, 48]
        assert (x, y, z) == pytest.approx((0.5 / FOCAL * 2.75, 0.5 / FOCAL * 2.75, 2.75), abs=0.02)
        below = cloud[63, 48]
        assert below[1] == pytest.approx(0.5, abs=0.02)  # the floor, downwards
        rgb = int(np.array(cloud[63, 48, 3], "<f4").view("<u4"))
        assert min(rgb >> 16, rgb >> 8 & 255, rgb & 255) > 100  # bright tiles
        labels = np.frombuffer(found["eye/labels"].data.tobytes(), "<u2").reshape(64, 96)
        names = {each.class_id: each.class_name for each in found["eye/label_info"].class_map}
        assert names[int(labels[32, 48])] == "ahead"
        [box] = [each for each in found["eye/detections"].detections if each.id == "ahead"]
        assert box.results[0].hypothesis.class_id == "ahead"
        assert box.bbox.size_x > 40
        optical = {each.child_frame_id: each for each in fixed["tf_static"].transforms}["deep_optical_frame"]
        assert optical.header.frame_id == "deep_frame"
        turn = optical.transform.rotation
        assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx((-0.5, 0.5, -0.5, 0.5))
