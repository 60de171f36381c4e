"""A simulated robot, driven by zenoh-ros2-sdk, another implementation of the rmw_zenoh protocol."""

from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import TypeStore
from tests.bridges.ros2.expose.exposed import exposed

pytestmark = pytest.mark.engine("mujoco")
pytest.importorskip("zenoh_ros2_sdk", reason="zenoh-ros2-sdk is not installed")

VIEWER = Path(__file__).with_name("sdk_viewer.py")
SEPARATOR = "=" * 80 + "\nMSG: "


def write_definitions(types: TypeStore, folder: Path, *names: str) -> None:
    """Write the definitions of types and of their member types as files of packages."""
    for name in names:
        package, _, kind = name.split("/")
        first, *others = types.schema(name).split(SEPARATOR)
        texts = {f"{package}/{kind}": first} | {
            each.partition("\n")[0]: each.partition("\n")[2] for each in others
        }
        for full, text in texts.items():
            file = folder / full.split("/")[0] / "msg" / f"{full.split('/')[1]}.msg"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)


async def test_another_implementation_drives_an_exposed_robot(
    tmp_path: Path, simulator: str, router: str, types: TypeStore
) -> None:
    definitions = tmp_path / "definitions"
    write_definitions(types, definitions, "sensor_msgs/msg/LaserScan", "geometry_msgs/msg/Twist")
    environment = os.environ | {"HOME": str(tmp_path), "ZENOH_CONFIG_OVERRIDE": "scouting/delay=20"}
    async with exposed(simulator, router, types, rate=2.0) as node:
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            str(VIEWER),
            router.rpartition(":")[2],
            str(definitions),
            env=environment,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        try:
            assert process.stdout is not None
            with anyio.fail_after(20.0):
                assert await process.stdout.readline() == b"ready\n"
                assert await process.stdout.readline() == b"rplidar_link 360\n"
                driven = 0.0
                while driven < 0.05:
                    await process.stdout.readline()
                    truth = await node.ask(wire.GET_ENTITY_STATE, wire.EntityName(name="turtlebot4"))
                    driven = truth.pose.position.x
        finally:
            process.kill()
            await process.wait()
