"""The sensors of a base that drives, as far as they are declared."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from sim_nodes.noise import Noise
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.wheels import Wheels
from sim_nodes.sensors.bumper import Bumper
from sim_nodes.sensors.feed import Feed
from sim_nodes.sensors.imu import Imu
from sim_nodes.sensors.lidar import Lidar
from sim_nodes.sensors.odometry import Odometry
from sim_nodes.sensors.sensor import Sensor


def base_sensors(
    robot: str, declaration: MobileDeclaration, engine: Engine, wheels: Wheels, seed: int
) -> dict[str, Feed[Any]]:
    """The ways of the samples of a base's sensors, by the sensors' names.

    Args:
        robot: Name of the robot.
        declaration: What is declared of its base.
        engine: The engine that it is in.
        wheels: Its wheels.
        seed: Seed of the simulation.
    """

    def noise(purpose: str) -> Noise:
        return Noise(seed, f"{robot}/{purpose}")

    state = partial(engine.body_state, robot)
    lidar = Lidar(declaration.lidar, noise("lidar"), partial(engine.cast_rays, robot))
    odometry = Odometry(declaration.drive, declaration.odometry, noise("odometry"), wheels.encoders)
    sensors: dict[str, Sensor[Any]] = {"lidar": lidar, "odometry": odometry}
    if declaration.imu is not None:
        sensors["imu"] = Imu(declaration.imu, noise("imu"), noise("imu/bias"), state)
    if declaration.bumper is not None:
        sensors["bumper"] = Bumper(declaration.bumper, state)
    return {
        name: Feed(sensor, partial(_noise_of_faults, noise, name), always=sensor is odometry)
        for name, sensor in sensors.items()
    }


def _noise_of_faults(noise: Callable[[str], Noise], sensor: str, purpose: str) -> Noise:
    return noise(f"{sensor}/{purpose}")
