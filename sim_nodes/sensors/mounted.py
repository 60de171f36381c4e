"""The sensors of the list `sensors` of a robot."""

from __future__ import annotations

from functools import partial
from typing import Any, assert_never

from sim_nodes.geodesy import GeoPoint
from sim_nodes.geometry import Vector, compose_frames
from sim_nodes.noise import Noise
from sim_nodes.physics import Engine, PlacedRobot
from sim_nodes.robots.sensor_declarations import (
    DepthCameraDeclaration,
    ForceTorqueDeclaration,
    GpsDeclaration,
    Lidar3dDeclaration,
    SegmentationDeclaration,
    SensorDeclaration,
    SonarDeclaration,
)
from sim_nodes.sensors.gps import Gps
from sim_nodes.sensors.imaging import DepthCamera, Segmentation
from sim_nodes.sensors.load import ForceTorque
from sim_nodes.sensors.ranging import Lidar3d, Sonar
from sim_nodes.sensors.sensor_pipeline import Sensor, SensorPipeline


def mounted_sensors(
    robot: PlacedRobot, engine: Engine, seed: int, origin: GeoPoint | None
) -> dict[str, SensorPipeline[Any]]:
    """Return the pipelines of the sensors of a robot's list by name.

    Args:
        robot: The robot.
        engine: Engine that simulates it.
        seed: Seed of the simulation.
        origin: Place of the world on the earth, if declared.
    """
    pipelines = {}
    for declaration in robot.declaration.sensors:
        noise = Noise(seed, f"{robot.name}/{declaration.name}")
        sensor = _sensor(robot.name, declaration, noise, engine, origin)
        pipelines[declaration.name] = SensorPipeline(sensor, partial(_noise, seed, robot.name, declaration.name))
    return pipelines


def _noise(seed: int, robot: str, sensor: str, purpose: str) -> Noise:
    return Noise(seed, f"{robot}/{sensor}/{purpose}")


def _sensor(
    robot: str, declaration: SensorDeclaration, noise: Noise, engine: Engine, origin: GeoPoint | None
) -> Sensor[Any]:
    match declaration:
        case Lidar3dDeclaration():
            return Lidar3d(robot, declaration, noise, engine)
        case SonarDeclaration():
            return Sonar(robot, declaration, noise, engine)
        case DepthCameraDeclaration():
            return DepthCamera(robot, declaration, noise, engine)
        case SegmentationDeclaration():
            return Segmentation(robot, declaration, engine)
        case ForceTorqueDeclaration():
            return ForceTorque(declaration, noise, partial(engine.joint_load, robot, declaration.link))
        case GpsDeclaration():
            assert origin is not None, "the loader of worlds has checked it"
            return Gps(declaration, noise, origin, partial(_position, engine, robot, declaration))
        case _:
            assert_never(declaration)


def _position(engine: Engine, robot: str, declaration: GpsDeclaration) -> Vector:
    """Return the position of a receiver in the map [m]."""
    mount = (declaration.position, declaration.orientation)
    return compose_frames(engine.link_pose(robot, declaration.link), mount)[0]
