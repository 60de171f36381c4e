"""Client of the exposed simulator node: its requests, events and streams."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from itertools import count

import anyio

from seoro.bridges import wire
from seoro.bridges.session import Bound, Mailbox, Sample, subscribing
from seoro.bridges.sim.requests import NodeAddress, R, ask
from seoro.concurrency.background import background
from seoro.concurrency.condition import Condition
from seoro.errors import BackendError

EVENTS_TIMEOUT = 5.0  # [s] of a request for events
ANSWER_TIMEOUT = 3600.0  # [s]; a node may be busy with many steps, and the loss of a node is noticed at once
WAITING = Bound(500)  # queue of a stream: 10 s

OnFeedback = Callable[[wire.NavigationFeedback], None]


class Worlds:
    """Worlds of a node: requests to expose another world, and world numbers reported by the node.

    Attributes:
        request: Number of the last request to expose another world.
    """

    def __init__(self) -> None:
        self.request = 0
        self._exposed = 0  # last request whose world is exposed
        self._number = 0
        self._changes = Condition()

    async def replace(self) -> None:
        """Request that the robots of another world are exposed, and wait until they are."""
        self.request += 1
        request = self.request
        self._changes.notify_all()
        await self._changes.wait_for(lambda: self._exposed >= request)

    def set_number(self, number: int) -> None:
        """Set the number of the present world of the node."""
        self._number = number
        self._changes.notify_all()

    async def wait_replaced(self, request: int, number: int) -> None:
        """Note that a world is exposed, and wait for another one.

        Args:
            request: Number of the last request before the world was read from the node.
            number: Number of the world at the node.
        """
        self._exposed = request
        self._changes.notify_all()
        await self._changes.wait_for(lambda: self.request > request or self._number > number)


class ExposedNode:
    """A simulator node.

    Args:
        address: Address of the node.

    Attributes:
        worlds: World of the node.
    """

    def __init__(self, address: NodeAddress) -> None:
        self.address = address
        self._client = secrets.token_hex(4)
        self._numbers = count(1)
        self._ends: dict[str, asyncio.Future[wire.Occurrence]] = {}
        self._on_feedback: dict[str, OnFeedback] = {}
        self.worlds = Worlds()

    async def ask(self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.A:
        """Send a request, and return the answer.

        Raises:
            BackendRefused: The node refuses the request.
            BackendLost: The node has disappeared, or does not answer.
        """
        return await ask(self.address, verb, request, ANSWER_TIMEOUT)

    def new_id(self) -> str:
        """Return a new ID for a goal or a stream, unique at the node."""
        return f"ros-{self._client}-{next(self._numbers)}"

    async def pursue(self, verb: wire.Verb[R, wire.Empty], request: R) -> wire.Occurrence:
        """Send a goal, and wait for its end; if the task is cancelled, the goal is canceled.

        Raises:
            BackendRefused: The node refuses the request.
        """
        goal = request.id
        end: asyncio.Future[wire.Occurrence] = asyncio.get_running_loop().create_future()
        self._ends[goal] = end
        try:
            await self.ask(verb, request)
            return await end
        except asyncio.CancelledError:
            with anyio.CancelScope(shield=True):
                await self._cancel(goal)
            raise
        finally:
            del self._ends[goal]

    async def _cancel(self, goal: str) -> None:
        with suppress(BackendError):  # the goal has ended, or the node has disappeared
            await self.ask(wire.CANCEL_GOAL, wire.CancelGoal(id=goal))

    @asynccontextmanager
    async def receiving_feedback(self, robot: str, on_feedback: OnFeedback) -> AsyncIterator[None]:
        """Receive the navigation feedback of a robot for the duration of the block."""
        self._on_feedback[robot] = on_feedback
        try:
            yield
        finally:
            if self._on_feedback.get(robot) is on_feedback:
                del self._on_feedback[robot]

    async def follow(self, number: int) -> None:
        """Dispatch ends, feedback and world changes after an event number, without end.

        Raises:
            BackendLost: The node has disappeared.
        """
        while True:
            request = wire.AwaitEvents(since=number, wait=EVENTS_TIMEOUT)
            answer = await self.ask(wire.AWAIT_EVENTS, request)
            number = answer.number
            for each in answer.events:
                self._dispatch(each)

    def _dispatch(self, event: wire.LoggedEvent) -> None:
        occurrence, feedback = event.occurrence, event.feedback
        if occurrence is not None and occurrence.id in self._ends and not self._ends[occurrence.id].done():
            self._ends[occurrence.id].set_result(occurrence)
        if feedback is not None and feedback.robot in self._on_feedback:
            self._on_feedback[feedback.robot](feedback)
        if event.world is not None:
            self.worlds.set_number(event.world.number)

    @asynccontextmanager
    async def streaming(self, wanted: wire.OpenStream) -> AsyncIterator[Mailbox[wire.StreamUpdate]]:
        """Open a stream of data for the duration of the block."""
        updates: Mailbox[wire.StreamUpdate] = Mailbox(WAITING)
        key = wire.node_stream(self.address.namespace, self.address.node, wanted.id)

        def on_sample(sample: Sample) -> None:
            updates.put(wire.decode(wire.StreamUpdate, sample.payload, wire.ANSWER), len(sample.payload))

        async with subscribing(self.address.session, key, on_sample):
            await self.ask(wire.OPEN_STREAM, wanted)
            try:
                yield updates
            finally:
                with anyio.CancelScope(shield=True), suppress(BackendError):
                    await self.ask(wire.CLOSE_STREAM, wire.StreamName(id=wanted.id))


@asynccontextmanager
async def following_node(address: NodeAddress) -> AsyncIterator[ExposedNode]:
    """Follow the events of a simulator node during the block.

    Raises:
        BackendLost: The node has disappeared.
    """
    node = ExposedNode(address)
    number = (await node.ask(wire.AWAIT_EVENTS, wire.AwaitEvents())).number  # of the last event
    async with background() as tasks:
        tasks.start_soon(node.follow, number)
        yield node
