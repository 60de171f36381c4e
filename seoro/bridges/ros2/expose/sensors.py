"""Cameras and listed sensors of simulated robots as ROS 2 topics, published on demand."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2.expose import messages, sensor_messages
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import PRESETS
from seoro.bridges.session import Mailbox
from seoro.concurrency.background import background
from seoro.errors import BackendRefused

SENSOR_DATA = PRESETS["sensor_data"]
IMAGE, INFO, CLOUD = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/PointCloud2"
PICTURE = {"image_raw": IMAGE, "camera_info": INFO}
DEPTH = {"depth/image_raw": IMAGE, "depth/camera_info": INFO, "points": CLOUD}
TOPICS: Mapping[str, Mapping[str, str]] = {
    "camera": PICTURE,
    "depth_camera": DEPTH,
    "rgbd_camera": PICTURE | DEPTH,
    "lidar_3d": {"points": CLOUD},
    "sonar": {"range": "sensor_msgs/msg/Range"},
    "force_torque": {"wrench": "geometry_msgs/msg/WrenchStamped"},
    "gps": {"fix": "sensor_msgs/msg/NavSatFix"},
    "segmentation": {
        "labels": IMAGE,
        "label_info": "vision_msgs/msg/LabelInfo",
        "detections": "vision_msgs/msg/Detection2DArray",
        "camera_info": INFO,
    },
}
"""Types of the topics below the name of a sensor, by its kind."""
OPTICAL = wire.Orientation3D(roll=-math.pi / 2, yaw=-math.pi / 2)

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class SensorTopics:
    """Topics of one sensor.

    Attributes:
        robot: Name of the robot.
        sensor: Description of the sensor.
        topics: Publishers by the names of their topics below the sensor.
    """

    robot: str
    sensor: wire.MountedSensor
    topics: Mapping[str, Publication]

    @property
    def camera(self) -> str:
        """Name of its camera at the node; empty for other sensors."""
        return f"{self.robot}/{self.sensor.name}" if self.sensor.kind == "camera" else ""

    @property
    def frame(self) -> str:
        """Frame of its measurements: x ahead; that of a force-torque sensor is its link."""
        return self.sensor.link if self.sensor.kind == "force_torque" else f"{self.sensor.name}_frame"

    @property
    def optical_frame(self) -> str:
        """Frame of its images: z ahead."""
        return f"{self.sensor.name}_optical_frame"

    def transforms(self) -> Iterator[dict[str, Any]]:
        """Yield the static transforms of its frames."""
        sensor = self.sensor
        if self.frame != sensor.link:
            yield messages.transform(sensor.link, self.frame, sensor.pose, 0.0)
        if sensor.width:
            yield messages.transform(self.frame, self.optical_frame, wire.Pose3D(orientation=OPTICAL), 0.0)

    def subscribed(self, graph: RosGraph) -> SensorTopics:
        """Return the topics that have subscriptions."""
        return replace(
            self, topics={name: each for name, each in self.topics.items() if graph.subscriptions(each.topic)}
        )

    def publish_picture(self, picture: wire.StreamedPicture) -> None:
        """Publish the picture of a camera."""
        self._publish_image(
            "image_raw", picture.pixels, "rgb8", (picture.width, picture.height), picture.time, "camera_info"
        )

    def publish_sample(self, sample: wire.SensorSample) -> None:
        """Publish a sample."""
        time = sample.time
        if sample.cloud is not None:
            self._publish("points", sensor_messages.lidar_cloud(sample.cloud, self.frame, time))
        if sample.echo is not None:
            self._publish("range", sensor_messages.sonar_range(sample.echo, self.sensor, self.frame, time))
        if sample.wrench is not None:
            self._publish("wrench", sensor_messages.wrench(sample.wrench, self.frame, time))
        if sample.fix is not None:
            self._publish("fix", sensor_messages.satellite_fix(sample.fix, self.sensor, self.frame, time))
        if sample.depth is not None:
            self._publish_depth(sample.depth, time)
        if sample.segmentation is not None:
            self._publish_segments(sample.segmentation, time)

    def _publish_depth(self, depth: wire.DepthSample, time: float) -> None:
        shape = (depth.width, depth.height)
        self._publish_image("depth/image_raw", depth.depths, "32FC1", shape, time, "depth/camera_info")
        if depth.picture:
            self._publish_image("image_raw", depth.picture, "rgb8", shape, time, "camera_info")
        if "points" in self.topics:
            self._publish("points", sensor_messages.depth_cloud(depth, self.sensor, self.optical_frame, time))

    def _publish_segments(self, found: wire.SegmentationSample, time: float) -> None:
        frame = self.optical_frame
        self._publish("label_info", sensor_messages.label_info(found, frame, time))
        self._publish("detections", sensor_messages.detections(found, frame, time))
        self._publish_image("labels", found.labels, "mono16", (found.width, found.height), time, "camera_info")

    def _publish_image(
        self, topic: str, data: bytes, encoding: str, shape: tuple[int, int], time: float, info: str
    ) -> None:
        frame = self.optical_frame
        self._publish(topic, sensor_messages.image(data, encoding, shape, frame, time))
        self._publish(info, sensor_messages.camera_info(self.sensor, frame, time))

    def _publish(self, topic: str, message: dict[str, Any]) -> None:
        if topic in self.topics:
            self.topics[topic].publish(message)


async def publish_on_demand(node: ExposedNode, graph: RosGraph, sensors: Sequence[SensorTopics]) -> None:
    """Publish sensors while their topics have subscriptions, without end.

    Args:
        node: Simulator node, which renders only while a stream uses a sensor.
        graph: Graph of the ROS 2 system.
        sensors: Topics of all sensors.
    """
    while True:
        wanted = await graph.wait_for(partial(_subscribed, sensors))
        try:
            async with node.streaming(_stream_of(wanted, node.new_id())) as updates, background() as tasks:
                tasks.start_soon(_publish_updates, updates, wanted)
                await graph.wait_for(partial(_differs, sensors, wanted))
        except BackendRefused as refused:
            names = ", ".join(f"{each.robot}/{each.sensor.name}" for each in wanted)
            log.warning("%s: not published: %s", names, refused)
            await graph.wait_for(partial(_differs, sensors, wanted))


def _subscribed(sensors: Sequence[SensorTopics], graph: RosGraph) -> tuple[SensorTopics, ...]:
    """Return the sensors with subscriptions, each with these topics only."""
    return tuple(found for each in sensors if (found := each.subscribed(graph)).topics)


def _differs(sensors: Sequence[SensorTopics], wanted: tuple[SensorTopics, ...], graph: RosGraph) -> bool:
    return _subscribed(sensors, graph) != wanted


def _stream_of(sensors: Sequence[SensorTopics], identifier: str) -> wire.OpenStream:
    sensed = [each for each in sensors if not each.camera]
    return wire.OpenStream(
        id=identifier,
        sensors=tuple(wire.SensorName(robot=each.robot, sensor=each.sensor.name) for each in sensed),
        cameras=tuple(each.camera for each in sensors if each.camera),
    )


async def _publish_updates(updates: Mailbox[wire.StreamUpdate], sensors: Sequence[SensorTopics]) -> None:
    by_name = {(each.robot, each.sensor.name): each for each in sensors}
    cameras = {each.camera: each for each in sensors if each.camera}
    async for update in updates:
        for streamed in update.samples:
            by_name[streamed.robot, streamed.sensor].publish_sample(streamed.sample)
        for picture in update.pictures:
            cameras[picture.camera].publish_picture(picture)
