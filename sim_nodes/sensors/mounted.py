"""The sensors of the list `sensors` of a robot."""

from __future__ import annotations

from functools import partial
from typing import Any, assert_never

from sim_nodes.noise import Noise
from sim_nodes.physics import Engine, PlacedRobot
from sim_nodes.robots.sensor_declarations import Lidar3dDeclaration, SensorDeclaration, SonarDeclaration
from sim_nodes.sensors.ranging import Lidar3d, Sonar
from sim_nodes.sensors.sensor_pipeline import Sensor, SensorPipeline


def mounted_sensors(robot: PlacedRobot, engine: Engine, seed: int) -> dict[str, SensorPipeline[Any]]:
    """Return the pipelines of the sensors of a robot's list by name.

    Args:
        robot: The robot.
        engine: Engine that simulates it.
        seed: Seed of the simulation.
    """
    pipelines = {}
    for declaration in robot.declaration.sensors:
        noise = Noise(seed, f"{robot.name}/{declaration.name}")
        sensor = _sensor(robot.name, declaration, noise, engine)
        pipelines[declaration.name] = SensorPipeline(sensor, partial(_noise, seed, robot.name, declaration.name))
    return pipelines


def _noise(seed: int, robot: str, sensor: str, purpose: str) -> Noise:
    return Noise(seed, f"{robot}/{sensor}/{purpose}")


def _sensor(robot: str, declaration: SensorDeclaration, noise: Noise, engine: Engine) -> Sensor[Any]:
    match declaration:
        case Lidar3dDeclaration():
            return Lidar3d(robot, declaration, noise, engine)
        case SonarDeclaration():
            return Sonar(robot, declaration, noise, engine)
        case _:
            assert_never(declaration)
