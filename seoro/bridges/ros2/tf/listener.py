"""Subscriptions to the transforms of a ROS 2 system."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final, TypeVar

from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.tf.buffer import TransformBuffer
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.session import Bound
from seoro.concurrency.background import background
from seoro.concurrency.condition import Condition

T = TypeVar("T")

TYPE: Final = "tf2_msgs/msg/TFMessage"
MOVING: Final = Qos(depth=100)  # profile of tf2
STATIC: Final = Qos(durability=Durability.TRANSIENT_LOCAL, depth=100)
WAITING: Final = Bound(10_000)


class TransformListener:
    """Listener to transforms. Made by `listen`.

    Args:
        buffer: Buffer of the transforms.
        on_note: Called with undecodable messages.

    Attributes:
        buffer: Buffer of the transforms.
    """

    def __init__(self, buffer: TransformBuffer, on_note: Callable[[str], None]) -> None:
        self.buffer = buffer
        self._on_note = on_note
        self._changes = Condition()

    async def wait_for(self, condition: Callable[[TransformBuffer], T], timeout: float | None = None) -> T:
        """Wait until a condition holds; check it now and after each message.

        Args:
            condition: Function whose first true result is returned.
            timeout: Time limit [s] of the machine's clock; None for no limit.

        Raises:
            TimeoutError: The condition did not hold in time.
        """
        return await self._changes.wait_for(lambda: condition(self.buffer), timeout)

    async def follow(self, subscription: Subscription, is_static: bool) -> None:
        """Add the transforms of all messages to the buffer, until the subscription ends."""
        async for _, message in subscription.decoded(self._on_note):
            self.buffer.put_message(message, is_static=is_static)
            self._changes.notify_all()


@asynccontextmanager
async def listen(
    node: RosNode, namespace: str = "", *, on_note: Callable[[str], None] = lambda text: None
) -> AsyncIterator[TransformListener]:
    """Follow the frames of a system during the block.

    Args:
        node: Subscribing node.
        namespace: Namespace of `tf` and `tf_static`; empty for the root.
        on_note: Called with invalid data, and when the time was set back.

    Raises:
        InvalidName: The namespace is invalid.
        WrongType: The topics have another type.
    """
    listener = TransformListener(TransformBuffer(on_note=on_note), on_note)
    prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    async with (
        node.subscribing(f"{prefix}/tf_static", TYPE, STATIC, WAITING) as static,
        node.subscribing(f"{prefix}/tf", TYPE, MOVING, WAITING) as moving,
        background() as tasks,
    ):
        tasks.start_soon(listener.follow, static, True)
        tasks.start_soon(listener.follow, moving, False)
        yield listener
