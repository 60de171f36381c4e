"""Frames of a robot, over real sessions and a router."""

from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.tf import UnknownFrame
from seoro.bridges.ros2.tf.listener import MOVING, STATIC, TYPE, listen
from tests.bridges.ros2.systems import two_nodes


def message(parent: str, child: str, second: int, x: float) -> dict[str, Any]:
    return {
        "transforms": [
            {
                "header": {"frame_id": parent, "stamp": {"sec": second}},
                "child_frame_id": child,
                "transform": {"translation": {"x": x}, "rotation": {"w": 1.0}},
            }
        ]
    }


@pytest.mark.parametrize("namespace", ["", "robot1"])
async def test_frames_of_a_robot_are_followed(router: str, types: TypeStore, namespace: str) -> None:
    with anyio.fail_after(30.0):
        prefix = f"/{namespace}" if namespace else ""
        async with (
            two_nodes(router, types) as (there, here),
            there.publishing(f"{prefix}/tf_static", TYPE, STATIC) as static,
            there.publishing(f"{prefix}/tf", TYPE, MOVING) as moving,
        ):
            static.publish(message("base_link", "laser", 0, 0.5))  # before the listener starts
            async with listen(here, namespace) as listener:
                await listener.wait_for(lambda buffer: "laser" in buffer.frames)
                with pytest.raises(UnknownFrame, match="unknown frame `odom`"):
                    listener.buffer.lookup("laser", "odom")
                await moving.wait_for_subscription()
                moving.publish(message("odom", "base_link", 3, 2.0))
                found = await listener.wait_for(lambda buffer: buffer.find("laser", "odom"))
                assert found is not None
                assert found.transform.translation == (2.5, 0.0, 0.0)
                with pytest.raises(TimeoutError):
                    await listener.wait_for(lambda buffer: buffer.find("laser", "map"), 0.01)
