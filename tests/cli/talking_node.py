"""A ROS 2 node that publishes texts, with a router of its own: `python talking_node.py ENDPOINT [ACTION TYPE]`.

It serves an action that accepts no goal.
"""

import sys
from collections.abc import Mapping
from contextlib import AsyncExitStack
from functools import partial
from typing import Any

import anyio

from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import open_session


async def refuse(_: object) -> Mapping[str, Any]:
    return {"accepted": False}


async def main(endpoint: str, action: str = "", type_name: str = "") -> None:
    async with (
        open_session(listen=endpoint, gossip=True),
        connect(endpoint, dialect=RmwZenoh()) as system,
        system.node("talker") as node,
        node.publishing("/chatter", "std_msgs/msg/String"),
        AsyncExitStack() as stack,
    ):
        if action:
            served = node.serving(f"{action}/_action/send_goal", f"{type_name}_SendGoal", refuse)
            await stack.enter_async_context(served)
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        await anyio.sleep_forever()


if __name__ == "__main__":
    anyio.run(partial(main, *sys.argv[1:]))
