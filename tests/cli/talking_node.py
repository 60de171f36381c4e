"""A ROS 2 node that publishes texts, with a router of its own: `python talking_node.py ENDPOINT`."""

import sys

import anyio

from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import open_session


async def main(endpoint: str) -> None:
    async with (
        open_session(listen=endpoint),
        connect(endpoint, dialect=RmwZenoh()) as system,
        system.node("talker") as node,
        node.publishing("/chatter", "std_msgs/msg/String"),
    ):
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        await anyio.sleep_forever()


if __name__ == "__main__":
    anyio.run(main, sys.argv[1])
