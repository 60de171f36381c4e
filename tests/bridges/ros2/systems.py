"""Two ROS 2 nodes with separate sessions at one router."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import Dialect, RmwZenoh

STRING = "std_msgs/msg/String"
ADD = "example_interfaces/srv/AddTwoInts"
RMW_ZENOH = RmwZenoh()


@asynccontextmanager
async def two_nodes(
    router: str, types: TypeStore, dialect: Dialect = RMW_ZENOH, theirs: TypeStore | None = None
) -> AsyncIterator[tuple[RosNode, RosNode]]:
    """Yield a node of the robot, with its own definitions, and a node of seoro."""
    async with (
        connect(router, types=theirs or types, dialect=dialect) as robot,
        robot.node("robot") as there,
        connect(router, types=types, dialect=dialect) as system,
        system.node("seoro") as here,
    ):
        yield there, here


def with_another_string(types: TypeStore, folder: Path) -> TypeStore:
    """Return definitions with another `std_msgs/msg/String`."""
    file = folder / "std_msgs" / "msg" / "String.msg"
    file.parent.mkdir(parents=True)
    file.write_text("string data\nuint8 priority\n")
    return types.add_folder(folder)
