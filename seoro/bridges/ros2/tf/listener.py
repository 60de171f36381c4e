"""Following the frames of a ROS 2 system."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final, TypeVar

from seoro.background import background
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.tf.buffer import TransformBuffer
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.session import Bound
from seoro.changes import Changes
from seoro.errors import BackendError, InvalidUse

T = TypeVar("T")

TYPE: Final = "tf2_msgs/msg/TFMessage"
MOVING: Final = Qos(depth=100)  # as tf2 asks for
STATIC: Final = Qos(durability=Durability.TRANSIENT_LOCAL, depth=100)
WAITING: Final = Bound(10_000)


class TransformListener:
    """Frames that are followed. Made by `listen`.

    Args:
        buffer: Where they are.
        on_note: Is told of what cannot be read.

    Attributes:
        buffer: Where they are.
    """

    def __init__(self, buffer: TransformBuffer, on_note: Callable[[str], None]) -> None:
        self.buffer = buffer
        self._on_note = on_note
        self._changes = Changes()

    async def wait_for(self, condition: Callable[[TransformBuffer], T], timeout: float | None = None) -> T:
        """Wait until a condition holds, looking at it whenever something is told.

        Args:
            condition: Gives something true, which is returned, once it holds.
            timeout: [s] of the machine's clock; without end when None.

        Raises:
            TimeoutError: It did not hold in time.
        """
        return await self._changes.wait_for(lambda: condition(self.buffer), timeout)

    async def take(self, subscription: Subscription, is_static: bool) -> None:
        """Take over what arrives, until the subscription ends; that something cannot be read is told once."""
        noted = False
        async for received in subscription:
            try:
                message = subscription.decode(received)
            except (BackendError, InvalidUse) as error:
                if not noted:
                    self._on_note(str(error))
                noted = True
                continue
            self.buffer.put_message(message, is_static=is_static)
            self._changes.tell()


@asynccontextmanager
async def listen(
    node: RosNode, namespace: str = "", *, on_note: Callable[[str], None] = lambda text: None
) -> AsyncIterator[TransformListener]:
    """Follow the frames of a system for as long as the block lasts.

    Args:
        node: Subscribes.
        namespace: Of `tf` and `tf_static`; they are `/tf` and `/tf_static` if it is empty.
        on_note: Is told of what cannot be, and when time was set back.

    Raises:
        InvalidName: There is no such namespace.
        WrongType: The topics have another type.
    """
    listener = TransformListener(TransformBuffer(on_note=on_note), on_note)
    prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    async with (
        node.subscribing(f"{prefix}/tf_static", TYPE, STATIC, WAITING) as static,
        node.subscribing(f"{prefix}/tf", TYPE, MOVING, WAITING) as moving,
        background() as tasks,
    ):
        tasks.start_soon(listener.take, static, True)
        tasks.start_soon(listener.take, moving, False)
        yield listener
