"""A node in its own process, for tests that kill it: `python alone.py ENDPOINT`.

It publishes /chatter ten times a second and serves /wait, but never responds.
"""

import sys

import anyio

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh


async def never(_: Message) -> Message:
    await anyio.sleep_forever()
    raise AssertionError


async def main() -> None:
    async with (
        connect(sys.argv[1], dialect=RmwZenoh()) as system,
        system.node("alone") as node,
        node.publishing("/chatter", "std_msgs/msg/String") as publication,
        node.serving("/wait", "std_srvs/srv/Empty", never),
    ):
        while True:
            publication.publish({"data": "still here"})
            await anyio.sleep(0.1)


if __name__ == "__main__":
    anyio.run(main)
