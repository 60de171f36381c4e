"""A robot with sensors of the test's choice, in a room of known size."""

from __future__ import annotations

import shutil
from pathlib import Path

from seoro.bridges import wire
from tests.sim_nodes.client import ROBOT, Client

ROBOTS = Path(__file__).parents[3] / "sim_nodes" / "robots"
ROOM = """name: room
extent: [-5, -5, 5, 5]
wall_height: 2.0
wall_thickness: 0.2
walls:
  - {name: ahead, points: [[3.1, -4.0], [3.1, 4.0]]}
  - {name: left, points: [[-4.0, 2.1], [2.0, 2.1]]}
robots: [{name: turtlebot4, robot: robot.yaml}]
"""


def room_with(folder: Path, sensors: str, more: str = "") -> str:
    """Write a room and a robot with sensors, and return the path of the world.

    The robot is at the origin; there are walls at x = 3 m and at y = 2 m.

    Args:
        folder: Folder of the files.
        sensors: Content of the list `sensors` of the robot's declaration, in YAML.
        more: Further content of the world file.
    """
    shutil.copy(ROBOTS / "turtlebot4.urdf", folder)
    text = (ROBOTS / "turtlebot4.yaml").read_text()
    (folder / "robot.yaml").write_text(f"{text}sensors:\n{sensors}")
    (folder / "room.yaml").write_text(ROOM + more)
    return str(folder / "room.yaml")


def next_sample(client: Client, sensor: str, robot: str = ROBOT) -> wire.SensorSample:
    """Return the next sample of a sensor."""
    client.ask(wire.WATCH_SENSOR, wire.WatchSensor(id="sample", robot=robot, sensor=sensor))
    client.run_until("sample")
    return latest(client, sensor, robot)


def latest(client: Client, sensor: str, robot: str = ROBOT) -> wire.SensorSample:
    """Return the latest sample of a sensor."""
    return client.ask(wire.GET_SENSOR_SAMPLE, wire.SensorName(robot=robot, sensor=sensor))
