"""Descriptions of the cameras and listed sensors of a robot, for clients that need their frames and optics."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.bridges.wire import MountedSensor
from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D
from sim_nodes.geometry import roll_pitch_yaw
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.sensor_declarations import (
    ForceTorqueDeclaration,
    GpsDeclaration,
    ImagerDeclaration,
    Mount,
    RangingDeclaration,
    SensorDeclaration,
    SonarDeclaration,
)

CAMERA_RATE = 10.0  # [Hz] of streamed pictures


def describe_sensors(declaration: RobotDeclaration) -> Iterator[MountedSensor]:
    """Yield the descriptions of a robot's cameras and of the sensors of its list."""
    for camera in declaration.cameras:
        yield MountedSensor(
            name=camera.name,
            kind="camera",
            link=camera.link,
            pose=_pose(camera),
            rate=CAMERA_RATE,
            fov=camera.fov,
            width=camera.width,
            height=camera.height,
        )
    for sensor in declaration.sensors:
        yield _described(sensor)


def _described(sensor: SensorDeclaration) -> MountedSensor:
    imager = sensor if isinstance(sensor, ImagerDeclaration) else None
    ranging = sensor if isinstance(sensor, RangingDeclaration) else None
    return MountedSensor(
        name=sensor.name,
        kind=sensor.kind,
        link=sensor.link,
        pose=Pose3D() if isinstance(sensor, ForceTorqueDeclaration) else _pose(sensor),
        rate=sensor.rate,
        fov=0.0 if imager is None else imager.fov,
        width=0 if imager is None else imager.width,
        height=0 if imager is None else imager.height,
        range_min=0.0 if ranging is None else ranging.min_range,
        range_max=0.0 if ranging is None else ranging.max_range,
        aperture=sensor.aperture if isinstance(sensor, SonarDeclaration) else 0.0,
        deviations=(sensor.noise, sensor.noise, sensor.height_noise) if isinstance(sensor, GpsDeclaration) else (),
    )


def _pose(mount: Mount) -> Pose3D:
    roll, pitch, yaw = roll_pitch_yaw(mount.orientation)
    return Pose3D(Position3D(*mount.position), Orientation3D(roll, pitch, yaw))
