"""Contract of backends that take part in a ROS 2 system: topics, services, actions, tf, clocks and bags.

Names of topics, services, actions and nodes may be relative to the root; types are written with slashes or dots.
Message values are mappings of members, nested where the message is; arrays are lists. Times are those of the
machine's clock, except those of `RosClock`, which may be simulated. Invalid names, types and values raise
`UsageError`; failures of the system raise `BackendError`.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any, Literal, Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.runtime.contracts.backends import GoalStatus

Members = Mapping[str, Any]
Note = Callable[[str], None]
"""Callback for notes to users."""


class Wanted(Value):
    """An entity of the ROS graph to wait for; endpoints optionally of one node."""

    kind: Literal["node", "topic", "service", "action", "publisher", "subscription", "server"]
    name: str
    node: str = ""


class RobotNames(Value):
    """Topics of an observed robot; those without a leading slash are below its namespace.

    Args:
        namespace: Namespace of the robot, without slashes around it; empty for the root.
        tf: Topic of transforms; that of static ones is `tf_static` beside it.
        odometry: Topic of `nav_msgs/Odometry`.
        pose: Topic of the poses of its localisation.
    """

    namespace: str = ""
    tf: str = "tf"
    odometry: str = "odom"
    pose: str = "amcl_pose"

    def full(self, name: str) -> str:
        """Return the full form of a name."""
        return name if name.startswith("/") else f"/{self.namespace}/{name}" if self.namespace else f"/{name}"

    def below(self, namespace: str) -> RobotNames:
        """Return the names of an equal robot in a namespace."""
        return RobotNames(namespace, self.tf, self.odometry, self.pose)

    @property
    def frames(self) -> str:
        """Namespace of the transforms, without slashes around it."""
        return self.full(self.tf).rpartition("/")[0].strip("/")


class RosMessage(Protocol):
    """A received message."""

    @property
    def members(self) -> Members:
        """Its members."""

    @property
    def message(self) -> Any:
        """The same message with attributes and numpy arrays."""

    @property
    def arrived(self) -> float:
        """Time of arrival [s since the epoch]."""


class RosSubscription(Protocol):
    """A subscription with a bounded buffer of unread messages."""

    def receive_nowait(self) -> RosMessage | None:
        """Return the oldest unread message, or None."""

    def on_arrival(self, call: Callable[[], None]) -> None:
        """Call a function once, on the event loop, soon after a message or an error is available."""

    @property
    def lost(self) -> int:
        """Number of messages dropped from the buffer or lost in transit."""


class RosPublisher(Protocol):
    """A publisher of a topic."""

    async def wait_for_subscription(self, timeout: float) -> bool:
        """Wait until published messages reach the subscribers, for `timeout` [s] at most; return whether they do.

        Without subscribers, return False at once.
        """

    def publish(self, value: Members) -> None:
        """Publish a message; missing members get their defaults."""


class GoalResult(Value):
    """End state and result of a ROS action goal."""

    status: GoalStatus
    result: Members


class RosGoal(Protocol):
    """A goal accepted by a server."""

    async def ended(self) -> GoalResult:
        """Wait for the end of the goal."""


class FramePose(Value):
    """Pose of a frame in another frame: position [m], quaternion (x, y, z, w), and time stamp.

    `stamp` is on the clock of the publisher [s]; None if no transform between the frames ever changes.
    """

    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    stamp: float | None


class RosFrames(Protocol):
    """Frames from `tf` and `tf_static`."""

    async def next_pose(self, frame: str, parent: str) -> FramePose:
        """Wait for the pose of a frame in another frame, newer than the last one returned."""

    def describe_absence(self, frame: str, parent: str) -> str:
        """Return why the pose of a frame in another is unknown; empty if it is known."""


class RosClock(Protocol):
    """Clock of the system."""

    def now(self) -> float | None:
        """Return the present time [s]; None before the first clock message."""

    def at(self, arrived: float) -> float | None:
        """Return the system time [s] for an arrival [s since the epoch]; None before the first clock message."""

    async def wait_until(self, moment: float) -> None:
        """Wait until a time [s], or until the clock jumps."""

    @property
    def jumps(self) -> int:
        """Number of jumps so far."""


class RosRecording(Protocol):
    """A bag being recorded."""

    async def wait_complete(self) -> None:
        """Wait until all required topics are recorded."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Required topics that are not recorded yet."""


@runtime_checkable
class ObservedSystem(Protocol):
    """A ROS 2 system whose topics a run observes: a running one, or a recorded one."""

    def loss_since(self, moment: float) -> str:
        """See `backends.Connected`."""

    def names_of(self, robot: str) -> RobotNames:
        """Return the names of the topics of a robot; its actor may have another namespace."""

    def subscribing(self, topic: str, type_name: str, qos: str) -> AbstractAsyncContextManager[RosSubscription]:
        """Create a subscription to a topic.

        Args:
            topic: Name of the topic.
            type_name: Type of its messages; empty for that of its publishers, which it waits for.
            qos: Name of the QoS profile.
        """

    def clock(self, note: Note) -> AbstractAsyncContextManager[RosClock]:
        """Follow the time of the system: `/clock` if it is published, otherwise the clock of this machine.

        Args:
            note: Called when the clock jumps, unless another follower was notified.
        """

    def machine_clock(self) -> RosClock:
        """Return the clock of this machine, from any start, or of a recorded system."""

    def frames(self, namespace: str, note: Note) -> AbstractAsyncContextManager[RosFrames]:
        """Follow the frames published in a namespace; empty for the root."""

    def lifecycle(self, node: str) -> AbstractAsyncContextManager[AsyncIterator[str]]:
        """Follow the states of a lifecycle node: the present state, then each change.

        The state is `gone` while the node does not exist.
        """


@runtime_checkable
class Ros2System(ObservedSystem, Protocol):
    """A ROS 2 system that a run takes part in. Entities created by a context manager exist during its block."""

    def publishing(self, topic: str, type_name: str, qos: str) -> AbstractAsyncContextManager[RosPublisher]:
        """Create a publisher of a topic; `qos` is one of `qos_preset_profiles`."""

    async def wait_for(self, wanted: Sequence[Wanted]) -> None:
        """Wait until all wanted entities exist at the same time; entities of this run do not count."""

    def missing(self, wanted: Sequence[Wanted]) -> tuple[str, ...]:
        """Describe the wanted entities that do not exist now, in a few words each."""

    async def call(self, service: str, type_name: str, request: Members) -> Members:
        """Call a service and return its response; wait for a server first."""

    def sending_goal(
        self,
        action: str,
        type_name: str,
        goal: Members,
        feedback: Callable[[Members], None],
        note: Note,
        *,
        late: bool,
    ) -> AbstractAsyncContextManager[RosGoal]:
        """Send a goal to an action, waiting for a server first; the goal is canceled at the end of the block.

        Args:
            action: Name of the action.
            type_name: Type of the action.
            goal: The goal.
            feedback: Callback for feedback.
            note: Called if the goal cannot be canceled.
            late: Whether to receive feedback that was published before.
        """

    async def set_parameter(self, node: str, name: str, text: str) -> None:
        """Set a node parameter from text, parsed as the declared type, otherwise as YAML."""

    def recording(
        self, folder: Path, topics: Sequence[str], note: Note, *, storage: str, hidden: bool, use_sim_time: bool
    ) -> AbstractAsyncContextManager[RosRecording]:
        """Record topics into a new bag; all topics if none is named.

        Args:
            folder: Folder of the bag.
            topics: Names of topics.
            note: Called for lost publishers, lost messages, and the final number of messages.
            storage: Storage format, by its rosbag2 name; empty for the default.
            hidden: Whether to record hidden topics (a part of the name begins with `_`).
            use_sim_time: Whether to stamp messages with `/clock`.
        """

    async def play(
        self, bag: Path, topics: Sequence[str], note: Note, *, start_offset: float, clock_rate: float | None
    ) -> None:
        """Play a bag to its end.

        Args:
            bag: Folder of the bag.
            topics: Names of topics to play; all if empty.
            note: Called for events during playback.
            start_offset: Time to skip at the start [s].
            clock_rate: Rate at which to publish `/clock` [1/s]; None for never.
        """
