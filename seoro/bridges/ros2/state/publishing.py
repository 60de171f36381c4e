"""Publishing of the state of a run while it goes on."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Final

import anyio

from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.state.behaviors import BehaviorStates
from seoro.bridges.ros2.state.markers import RunMarkers
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire.qos import Durability, Qos
from seoro.concurrency.background import background
from seoro.concurrency.condition import Condition

BEHAVIORS: Final = "/seoro/behaviors"
MARKERS: Final = "/seoro/markers"
PERIOD: Final = 0.2  # [s] at least between two messages of a topic
_LATCHED: Final = Qos(depth=1, durability=Durability.TRANSIENT_LOCAL)


class RunState:
    """An observer that publishes the state of a run. It skips states that last less than a period.

    Args:
        behaviors: Publisher of the tree of behaviors.
        markers: Publisher of markers.
        source: Name of the publishing node.
    """

    def __init__(self, behaviors: Publication, markers: Publication, source: str) -> None:
        self._publications = behaviors, markers
        self._states = BehaviorStates(source)
        self._markers = RunMarkers()
        self._has_changed = [False, False]
        self._changed = Condition()

    def record(self, record: dict[str, Any]) -> None:
        """See `Observer.record`."""
        changed = self._states.add(record), self._markers.add(record)
        self._has_changed = [old or new for old, new in zip(self._has_changed, changed, strict=True)]
        if any(changed):
            self._changed.notify_all()

    async def run(self) -> None:
        """Publish each change, without end."""
        while True:
            await self._changed.wait_for(lambda: any(self._has_changed))
            self.publish()
            await anyio.sleep(PERIOD)

    def publish(self) -> None:
        """Publish the states and markers that changed since the last call."""
        behaviors, markers = self._publications
        has_states, has_markers = self._has_changed
        self._has_changed = [False, False]
        if has_states:
            behaviors.publish(self._states.message(time.time_ns()))
        if has_markers:
            markers.publish(self._markers.message())


@asynccontextmanager
async def publishing_state(node: RosNode) -> AsyncIterator[RunState]:
    """Publish the state of a run that the yielded observer sees, until the end of the block."""
    async with (
        node.publishing(BEHAVIORS, "diagnostic_msgs/msg/DiagnosticArray", _LATCHED) as behaviors,
        node.publishing(MARKERS, "visualization_msgs/msg/MarkerArray", _LATCHED) as markers,
        background() as tasks,
    ):
        state = RunState(behaviors, markers, node.node.name)
        tasks.start_soon(state.run)
        try:
            yield state
        finally:
            state.publish()
