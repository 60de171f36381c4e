"""The sensors of a wheeled base."""

from __future__ import annotations

from functools import partial
from typing import Any

from sim_nodes.noise import Noise
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.drive import Wheels
from sim_nodes.sensors.base import Bumper, Imu, Odometry
from sim_nodes.sensors.lidar import Lidar
from sim_nodes.sensors.sensor_pipeline import Sensor, SensorPipeline


def base_sensors(
    robot: str, declaration: MobileDeclaration, engine: Engine, wheels: Wheels, seed: int
) -> dict[str, SensorPipeline[Any]]:
    """Return the pipelines of a base's sensors by name.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the base.
        engine: Engine that simulates it.
        wheels: Its wheels.
        seed: Seed of the simulation.
    """

    def noise(*purpose: str) -> Noise:
        return Noise(seed, "/".join((robot, *purpose)))

    state = partial(engine.body_state, robot)
    odometry = Odometry(declaration.drive, declaration.odometry, noise("odometry"), wheels.encoders)
    sensors: dict[str, Sensor[Any]] = {}
    if declaration.lidar is not None:
        sensors["lidar"] = Lidar(declaration.lidar, noise("lidar"), robot, engine)
    sensors["odometry"] = odometry
    if declaration.imu is not None:
        sensors["imu"] = Imu(declaration.imu, noise("imu"), noise("imu/bias"), state)
    if declaration.bumper is not None:
        sensors["bumper"] = Bumper(declaration.bumper, state)
    return {
        name: SensorPipeline(sensor, partial(noise, name), always=sensor is odometry)
        for name, sensor in sensors.items()
    }
