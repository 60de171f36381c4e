"""A ROS 2 system as a backend of runs, for the actions of `osc.ros`; see `Ros2System` for the methods."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from pathlib import Path

import anyio.to_thread
from anyio import CancelScope
from anyio.abc import TaskGroup

from seoro.bridges.ros2.clients.cancellation import cancel_goal
from seoro.bridges.ros2.clients.editions import check_fits
from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.clients.lifecycle import watching_lifecycle
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.clients.parameters import set_parameter
from seoro.bridges.ros2.clients.presence import Presence, full_name
from seoro.bridges.ros2.clock import MachineClock, SharedClock
from seoro.bridges.ros2.descriptions import node_for_service
from seoro.bridges.ros2.endpoints import RosPublisher, RosSubscription
from seoro.bridges.ros2.graph import types_of
from seoro.bridges.ros2.participant import RosNode, RosOptions, connect_system
from seoro.bridges.ros2.recording import Playback, Recording, open_bag, play, record
from seoro.bridges.ros2.state.publishing import publishing_state
from seoro.bridges.ros2.state.stopping import serving_stop
from seoro.bridges.ros2.tf.listener import listen
from seoro.bridges.ros2.tf.poses import FramePoses
from seoro.bridges.ros2.tracks import RosTracks
from seoro.bridges.ros2.wire import PRESETS
from seoro.bridges.session import Outages
from seoro.bridges.wire.results import LabResult
from seoro.concurrency.background import background
from seoro.errors import BackendStopped
from seoro.runtime.contracts import ros2 as contract
from seoro.runtime.contracts.backends import WARNING, EventHandler, LossHandler
from seoro.runtime.contracts.observers import Observer
from seoro.runtime.contracts.tracks import TrackReporter

ROBOT = "robot"  # base type of all robots


class RosBackend:
    """A ROS 2 system, accessed by a node of seoro.

    Args:
        node: Node of seoro.
        name: Name of the system in messages.
        tasks: Task group of subscriptions shared by actions, and of the cancellation of lost goals.
        outages: Outages of the connection to the system.
        is_alone: Whether no other backend has the robots of the run.
        observers: Observers of the run.
    """

    def __init__(
        self,
        node: RosNode,
        name: str,
        tasks: TaskGroup,
        outages: Outages,
        *,
        is_alone: bool,
        observers: Sequence[Observer] = (),
    ) -> None:
        self._node = node
        self.name = name
        self.observers = observers
        self._outages = outages
        self._presence = Presence(node)
        self._clock = SharedClock(node, tasks)
        self._tasks = tasks
        self._is_alone = is_alone
        self._on_event: EventHandler | None = None  # set at the start of a run
        self._on_lost: LossHandler | None = None  # set while a run is active
        self._actors: list[str] = []  # robots of the scenario
        self._tracking: CancelScope | None = None

    def names_of(self, robot: str) -> contract.RobotNames:
        """Return the usual names: actors have the namespaces of running robots."""
        return contract.RobotNames()

    def loss_since(self, moment: float) -> str:
        """See `Connected`. Messages sent during an outage are lost, so each outage counts."""
        if self._node.system.session.is_cut_off:
            return "the connection to the ROS 2 system is lost"
        if self._outages.since(moment):
            return "the connection to the ROS 2 system was lost meanwhile, and messages may be missing"
        return ""

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return the name of an actor if it is a robot: robots without another backend are in this system."""
        if ROBOT not in types:
            return None
        self._actors.append(actor)
        return actor

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """Keep the handlers of warnings and stops: waiting actions notice outages by themselves."""
        self._on_event, self._on_lost = on_event, on_lost

    def stop_run(self, reason: str) -> bool:
        """Begin to cancel the run; returns whether one is active."""
        if self._on_lost is None:
            return False
        self._on_lost(BackendStopped(reason, LabResult.STOPPED))
        return True

    async def start_tracks(self, rate: float, report: TrackReporter, scans: float = 0.0) -> None:
        """See `Tracks`. Beside simulators and bridges, which have the robots, nothing is reported."""
        if scans:
            self._warn(f"scans of the robots of {self.name} are not recorded")
        if self._is_alone:
            self._tasks.start_soon(self._track, rate, report)

    async def _track(self, rate: float, report: TrackReporter) -> None:
        with CancelScope() as self._tracking:
            await RosTracks(self._node, self._actors, self._warn).run(rate, report)

    def _warn(self, text: str) -> None:
        if self._on_event is not None:
            self._on_event(WARNING, {"message": text})

    async def end_run(self) -> None:
        """Report no more poses; actions end everything that they started."""
        self._on_lost = None
        if self._tracking is not None:
            self._tracking.cancel()

    @asynccontextmanager
    async def publishing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[RosPublisher]:
        """Create a publisher of a topic."""
        async with self._node.publishing(topic, type_name, PRESETS[qos]) as publication:
            yield RosPublisher(publication, self._node)

    @asynccontextmanager
    async def subscribing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[RosSubscription]:
        """Create a subscription to a topic; without a type, wait for a publisher and use its type."""
        name = self._node.resolve(topic)
        found = type_name or (await self._node.graph.wait_for(lambda graph: types_of(graph.publishers(name))))[0]
        async with self._node.subscribing(topic, found, PRESETS[qos]) as subscription, background() as tasks:
            incoming = RosSubscription(subscription, self._node)
            tasks.start_soon(incoming.watch_types)
            try:
                yield incoming
            finally:
                await incoming.close()

    async def wait_for(self, wanted: Sequence[contract.Wanted]) -> None:
        """Wait until all wanted entities exist at the same time."""
        presence = self._presence
        resolved = [presence.resolved(each) for each in wanted]
        await self._node.graph.wait_for(lambda graph: all(presence.has(graph, each) for each in resolved))

    def missing(self, wanted: Sequence[contract.Wanted]) -> tuple[str, ...]:
        """Describe the wanted entities that do not exist now."""
        presence = self._presence
        resolved = [presence.resolved(each) for each in wanted]
        return tuple(presence.missing(each) for each in resolved if not presence.has(self._node.graph, each))

    async def call(self, service: str, type_name: str, request: contract.Members) -> Members:
        """Call a service once it has a server, and return its response."""
        node = await node_for_service(self._node, service, type_name)
        types = node.system.types
        check_fits(types, f"{types.canonical(type_name)}_Request", request)
        async with node.calling(service, type_name) as client:
            await client.wait_for_server()
            return Members(await client.call(request))

    def sending_goal(
        self,
        action: str,
        type_name: str,
        goal: contract.Members,
        feedback: Callable[[contract.Members], None],
        note: contract.Note,
        *,
        late: bool,
    ) -> AbstractAsyncContextManager[contract.RosGoal]:
        """Send a goal to an action; the goal is canceled at the end of the block."""

        def cancel_lost(unsettled: Goal) -> None:
            if unsettled.is_lost:
                self._tasks.start_soon(cancel_goal, self._node, unsettled.action, unsettled.goal_id, note)

        return sending_goal(self._node, action, type_name, goal, feedback, note, cancel_lost, late=late)

    async def set_parameter(self, node: str, name: str, text: str) -> None:
        """Set a parameter of a node."""
        await set_parameter(self._node, full_name(node), name, text)

    def lifecycle(self, node: str) -> AbstractAsyncContextManager[AsyncIterator[str]]:
        """Follow the states of a node."""
        return watching_lifecycle(self._node, full_name(node))

    def clock(self, note: contract.Note) -> AbstractAsyncContextManager[SharedClock]:
        """Follow the time of the system."""
        return self._clock.using(note)

    def machine_clock(self) -> MachineClock:
        """Return the clock of this machine."""
        return MachineClock()

    @asynccontextmanager
    async def frames(self, namespace: str, note: contract.Note) -> AsyncIterator[FramePoses]:
        """Follow the frames published in a namespace."""
        async with (
            listen(self._node, namespace, on_note=note) as listener,
            self._clock.using(note, listener.buffer.clear),
        ):
            yield FramePoses(listener.buffer, lambda find: listener.wait_for(lambda _: find()))

    @asynccontextmanager
    async def recording(
        self,
        folder: Path,
        topics: Sequence[str],
        note: contract.Note,
        *,
        storage: str,
        hidden: bool,
        use_sim_time: bool,
    ) -> AsyncIterator[Recording]:
        """Record topics into a bag."""
        recording = record(
            self._node,
            folder,
            topics,
            pattern="" if topics else ".*",
            hidden=hidden,
            use_sim_time=use_sim_time,
            storage=storage,
            on_note=note,
        )
        async with recording as made:
            yield made
        note(_summary(made))

    async def play(
        self,
        bag: Path,
        topics: Sequence[str],
        note: contract.Note,
        *,
        start_offset: float,
        clock_rate: float | None,
    ) -> None:
        """Play a bag to its end."""
        names = tuple(self._node.resolve(topic) for topic in topics)
        playback = Playback(names, start_offset=start_offset, clock_rate=clock_rate)
        await play(self._node, await anyio.to_thread.run_sync(open_bag, bag), playback, on_note=note)


def _summary(recording: Recording) -> str:
    """Summarise a recording: messages by topic, and lost messages."""
    counts = ", ".join(f"{count} of {topic}" for topic, count in recording.counts.items()) or "no messages"
    lost = sum(recording.lost.values()) + sum(recording.missed.values())
    return f"recorded {counts} in {recording.folder}{f'; {lost} messages were lost' if lost else ''}"


@asynccontextmanager
async def open_backend(
    options: RosOptions, *, is_alone: bool, has_state: bool = False
) -> AsyncIterator[RosBackend]:
    """Join a ROS 2 system for the duration of the block; see `connect_system` for the errors.

    Args:
        options: Options of the connection.
        is_alone: Whether no other backend has the robots of the run, so that this one reports their poses.
        has_state: Whether the state of the run is published, and other nodes can stop it.
    """
    async with (
        connect_system(options) as system,
        system.node(f"seoro_{system.session.identity[:6]}") as node,
        background() as tasks,
    ):
        await anyio.to_thread.run_sync(system.prepare)
        outages = await anyio.to_thread.run_sync(system.session.blocking.outages)
        async with AsyncExitStack() as opened:
            observers = [await opened.enter_async_context(publishing_state(node))] if has_state else []
            name = f"the ROS 2 system at {options.endpoint}"
            backend = RosBackend(node, name, tasks, outages, is_alone=is_alone, observers=observers)
            if has_state:
                await opened.enter_async_context(serving_stop(node, backend.stop_run))
            yield backend
