"""What a backend may be able to do that takes part in a ROS 2 system: topics, services, actions, and what is built
of them.

It is one of the capabilities (see `capabilities.py`), and what has many parts. Names of topics, services, actions
and nodes may be relative to the root; types are written with slashes or dots. Values of messages are mappings of
their members, whose members may be mappings again; arrays are lists there. Times are those of the machine's clock,
but for those of the system's own, which a simulation may have (`RosClock`).
What cannot be because of a name, a type or a value raises `InvalidUse`, what the system does not do
`BackendError`.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any, Literal, Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.runtime.contracts import GoalStatus

Members = Mapping[str, Any]
Note = Callable[[str], None]
"""Called with what happens, in words for people."""


class Wanted(Value):
    """Something that is to be there: of a kind, with a name; endpoints maybe of a certain node."""

    kind: Literal["node", "topic", "service", "action", "publisher", "subscription", "server"]
    name: str
    node: str = ""


class RosMessage(Protocol):
    """A message that has arrived."""

    @property
    def members(self) -> Members:
        """What it says."""
        ...

    @property
    def message(self) -> Any:
        """The same with attributes, and with numpy arrays."""
        ...

    @property
    def arrived(self) -> float:
        """When it arrived [s since the epoch]."""
        ...


class RosSubscription(Protocol):
    """A subscription, which holds some messages that nobody has taken yet."""

    def take_now(self) -> RosMessage | None:
        """The oldest message that nobody has taken, if there is one."""
        ...

    def when_arrived(self, call: Callable[[], None]) -> None:
        """Have something called once in the event loop, soon after there is something to take, or to be raised."""
        ...

    @property
    def lost(self) -> int:
        """Messages that arrived and were not taken in time, or got lost on their way."""
        ...


class RosPublisher(Protocol):
    """A publisher of a topic."""

    async def wait_for_subscription(self, timeout: float) -> bool:
        """Wait until what is published reaches those who have subscribed, `timeout` [s] at most; whether it does.

        It does not where nobody has subscribed; then this returns at once.
        """
        ...

    def publish(self, value: Members) -> None:
        """Publish a message; members that are missing have their defaults."""
        ...


class GoalResult(Value):
    """How a goal of a ROS action ended, and what its server says of that."""

    status: GoalStatus
    result: Members


class RosGoal(Protocol):
    """A goal that a server has accepted."""

    async def ended(self) -> GoalResult:
        """Wait for its end."""
        ...


class FramePose(Value):
    """Where a frame is in another one: position [m], quaternion (x, y, z, w), and when that was.

    `stamp` is by the clock of those who tell [s]; None if nothing between the frames ever moves.
    """

    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    stamp: float | None


class RosFrames(Protocol):
    """Frames, as `tf` and `tf_static` tell."""

    async def next_pose(self, frame: str, parent: str) -> FramePose:
        """The latest pose of a frame in another one; waits until it is known, and is another than the last."""
        ...

    def absence(self, frame: str, parent: str) -> str:
        """Why it is not known where a frame is in another one; empty if it is."""
        ...


class RosClock(Protocol):
    """The time of the system."""

    def at(self, arrived: float) -> float | None:
        """The time [s] when something arrived [s since the epoch]; None if the system tells none yet."""
        ...

    async def wait_until(self, moment: float) -> None:
        """Wait until it is so late [s], or the time jumps."""
        ...

    @property
    def jumps(self) -> int:
        """How often it has jumped."""
        ...


class RosRecording(Protocol):
    """A bag that is recorded."""

    async def wait_complete(self) -> None:
        """Wait until all topics are recorded that have to be."""
        ...

    @property
    def missing(self) -> tuple[str, ...]:
        """The topics of those that are not there yet."""
        ...


@runtime_checkable
class Ros2System(Protocol):
    """A ROS 2 system. What is entered here is there for as long as the block lasts."""

    def loss_since(self, moment: float) -> str:
        """See `capabilities.Connected`."""
        ...

    def publishing(self, topic: str, type_name: str, qos: str) -> AbstractAsyncContextManager[RosPublisher]:
        """Be a publisher of a topic; `qos` is one of `qos_preset_profiles`."""
        ...

    def subscribing(self, topic: str, type_name: str, qos: str) -> AbstractAsyncContextManager[RosSubscription]:
        """Be a subscription of a topic."""
        ...

    async def wait_for(self, wanted: Sequence[Wanted]) -> None:
        """Wait until all of some things are there at one time; what this run itself has is left out."""
        ...

    def missing(self, wanted: Sequence[Wanted]) -> tuple[str, ...]:
        """Which of them are not there now, each in a few words."""
        ...

    async def call(self, service: str, type_name: str, request: Members) -> Members:
        """Call a service, once there is a server of it, and wait for its response."""
        ...

    def pursuing(
        self,
        action: str,
        type_name: str,
        goal: Members,
        feedback: Callable[[Members], None],
        note: Note,
        *,
        late: bool,
    ) -> AbstractAsyncContextManager[RosGoal]:
        """Send a goal to an action, once there is a server of it; at the end of the block it is canceled.

        Args:
            action: Its name.
            type_name: Its type.
            goal: The goal.
            feedback: Called with what the server tells on the way.
            note: Told if the goal cannot be canceled.
            late: Whether to ask for feedback that was published before.
        """
        ...

    async def set_parameter(self, node: str, name: str, text: str) -> None:
        """Set a parameter of a node to what a text says, read as the kind that it has, else as YAML."""
        ...

    def lifecycle(self, node: str) -> AbstractAsyncContextManager[AsyncIterator[str]]:
        """Follow the states of a node that has a life cycle: the present one, and then each that it comes to.

        It is `gone` when it is not there any more, and in a state again when it is back.
        """
        ...

    def clock(self, note: Note) -> AbstractAsyncContextManager[RosClock]:
        """Follow the time of the system: what a simulation tells on `/clock`, or else that of this machine.

        Args:
            note: Told when it jumps, unless another that follows it is.
        """
        ...

    def frames(self, namespace: str, note: Note) -> AbstractAsyncContextManager[RosFrames]:
        """Follow the frames whose transforms are published in a namespace; empty for the root."""
        ...

    def recording(
        self,
        folder: Path,
        topics: Sequence[str],
        note: Note,
        *,
        storage: str,
        hidden: bool,
        use_sim_time: bool,
    ) -> AbstractAsyncContextManager[RosRecording]:
        """Record topics into a bag, which is made; all that there are if none is named.

        Args:
            folder: The bag.
            topics: Their names.
            note: Told of publishers that go, of messages that are lost, and of how much was recorded in the end.
            storage: By the name that rosbag2 has for it; empty for what seoro chooses.
            hidden: Whether topics may be recorded whose names have a part that begins with `_`.
            use_sim_time: Whether messages get the time of `/clock`.
        """
        ...

    async def play(
        self, bag: Path, topics: Sequence[str], note: Note, *, start_offset: float, clock_rate: float | None
    ) -> None:
        """Play a bag to its end: some of its topics, or all.

        Args:
            bag: The bag.
            topics: Their names.
            note: Told of what happens.
            start_offset: What of it is left out [s].
            clock_rate: How often its time is published on `/clock` [1/s]; not at all when None.
        """
        ...
