"""The simulator node that is exposed: asked, and followed in what happens and in what is published."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from itertools import count

import anyio

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.ros2.expose.worlds import Worlds
from seoro.bridges.session import Bound, Mailbox, Sample, subscribing
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendError

WAIT = 5.0  # [s] for what happens, until the node is asked again
PATIENCE = 3600.0  # [s] for an answer: a node may be amid many steps; one that is gone is noticed at once
WAITING = Bound(500)  # what was published and not passed on yet: 10 s of it

Told = Callable[[wire.NavigationFeedback], None]


class ExposedNode:
    """A simulator node.

    Args:
        address: How it is reached.

    Attributes:
        worlds: Which of its worlds is exposed.
    """

    def __init__(self, address: NodeAddress) -> None:
        self.address = address
        self._client = secrets.token_hex(4)
        self._numbers = count(1)
        self._ends: dict[str, asyncio.Future[wire.Occurrence]] = {}
        self._ways: dict[str, Told] = {}
        self.worlds = Worlds()

    async def ask(self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.A:
        """Ask it to carry out a verb.

        Raises:
            BackendRefused: It said no.
            BackendLost: It is gone, or does not answer.
        """
        return await ask(self.address, verb, request, PATIENCE)

    async def pursue(
        self, verb: wire.Verb[wire.Q, wire.Empty], request: Callable[[str], wire.Q]
    ) -> wire.Occurrence:
        """Ask for what has a goal, and wait for its end; when this is cancelled, so is the goal.

        Args:
            verb: What is asked for.
            request: Makes the request from the id of the goal.

        Raises:
            BackendRefused: The node said no.
        """
        goal = f"ros-{self._client}-{next(self._numbers)}"
        end: asyncio.Future[wire.Occurrence] = asyncio.get_running_loop().create_future()
        self._ends[goal] = end
        try:
            await self.ask(verb, request(goal))
            return await end
        except asyncio.CancelledError:
            with anyio.CancelScope(shield=True):
                await self._cancel(goal)
            raise
        finally:
            del self._ends[goal]

    async def _cancel(self, goal: str) -> None:
        with suppress(BackendError):  # it has ended by itself, or with the node
            await self.ask(wire.CANCEL_GOAL, wire.CancelGoal(id=goal))

    @asynccontextmanager
    async def on_its_way(self, robot: str, told: Told) -> AsyncIterator[None]:
        """Be told how far a robot is on its way, for as long as the block lasts."""
        self._ways[robot] = told
        try:
            yield
        finally:
            if self._ways.get(robot) is told:
                del self._ways[robot]

    async def last_number(self) -> int:
        """The number of what has happened last."""
        return (await self.ask(wire.AWAIT_HAPPENINGS, wire.AwaitHappenings())).number

    async def follow(self, number: int) -> None:
        """Tell of ends, ways to goals and other worlds after a number, for ever.

        Raises:
            BackendLost: The node is gone.
        """
        while True:
            asked = wire.AwaitHappenings(since=number, wait=WAIT)
            happened = await self.ask(wire.AWAIT_HAPPENINGS, asked)
            number = happened.number
            for each in happened.happenings:
                self._tell(each)

    def _tell(self, happening: wire.Happening) -> None:
        occurrence, feedback = happening.occurrence, happening.feedback
        if occurrence is not None and occurrence.id in self._ends and not self._ends[occurrence.id].done():
            self._ends[occurrence.id].set_result(occurrence)
        if feedback is not None and feedback.robot in self._ways:
            self._ways[feedback.robot](feedback)
        if happening.world is not None:
            self.worlds.tell(happening.world.number)

    @asynccontextmanager
    async def streaming(self, wanted: wire.OpenStream) -> AsyncIterator[Mailbox[wire.Streamed]]:
        """Have it publish, for as long as the block lasts. The name of the stream is made here."""
        name = f"ros-{self._client}-{next(self._numbers)}"
        told: Mailbox[wire.Streamed] = Mailbox(WAITING)
        key = wire.node_stream(self.address.namespace, self.address.node, name)

        def take(sample: Sample) -> None:
            told.put(wire.decode(wire.Streamed, sample.payload, wire.ANSWER), len(sample.payload))

        async with subscribing(self.address.session, key, take):
            await self.ask(wire.OPEN_STREAM, wanted.model_copy(update={"id": name}))
            try:
                yield told
            finally:
                with anyio.CancelScope(shield=True), suppress(BackendError):
                    await self.ask(wire.CLOSE_STREAM, wire.StreamName(id=name))


@asynccontextmanager
async def following(address: NodeAddress) -> AsyncIterator[ExposedNode]:
    """Follow a simulator node for as long as the block lasts, from before its beginning on.

    Raises:
        BackendLost: The node is gone.
    """
    node = ExposedNode(address)
    number = await node.last_number()
    async with background() as tasks:
        tasks.start_soon(node.follow, number)
        yield node
