"""A simulation in a simulator of the ROS world: its time in steps, where things are, and watches on that."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from seoro.bridges import wire
from seoro.bridges.ros2.simulators.interfaces import MAP, SimulationInterfaces, States
from seoro.bridges.serving.refusal import RequestRefused, listed
from seoro.bridges.wire import Outcome, Result

TRIED = 10  # steps that are made to find out how long one is
LOOK = 0.02  # [s] between two looks at what is watched
LONGEST = 5.0  # [s] that are stepped at a time
ROUNDING = 1e-6  # [steps]


@dataclass(frozen=True)
class Watch:
    """A watch on the distance of a frame from a point in another [m]."""

    frame: str
    parent: str
    x: float
    y: float
    threshold: float

    def holds(self, entities: Mapping[str, wire.EntityState]) -> bool:
        """Whether it is nearer than that."""
        x, y, _ = relative(entities, self.frame, self.parent)
        return math.hypot(x - self.x, y - self.y) < self.threshold


class RosWorld:
    """A simulation that passes in steps. Made by `open_world`.

    Args:
        simulator: Its services.
        step: Length of a step [s].
        start: The simulator's time at the beginning [s].
    """

    def __init__(self, simulator: SimulationInterfaces, step: float, start: float) -> None:
        self.simulator = simulator
        self.step_length = step
        self._start = start
        self._steps = 0
        self._watches: dict[str, Watch] = {}

    @property
    def time(self) -> float:
        """Since the beginning [s]; a multiple of the length of a step."""
        return self._steps * self.step_length

    def start_over(self) -> None:
        """Begin at time zero, without watches."""
        self._steps, self._watches = 0, {}

    async def step(self, count: int) -> None:
        """Make steps."""
        await self.simulator.step(count)
        self._steps += count

    async def advance(self, until: float) -> list[wire.Occurrence]:
        """Step to a time [s], or to the first thing that was watched for."""
        fired: list[wire.Occurrence] = []
        while not fired and (left := math.ceil((until - self.time) / self.step_length - ROUNDING)) > 0:
            longest = LOOK if self._watches else LONGEST
            await self.step(min(left, max(1, round(longest / self.step_length))))
            fired = await self.check() if self._watches else []
        return fired

    async def check(self) -> list[wire.Occurrence]:
        """The watches whose conditions hold now, which is told of them once."""
        entities = (await self.simulator.states()).entities
        names = [name for name, watch in self._watches.items() if _holds(watch, entities)]
        for name in names:
            del self._watches[name]
        return [wire.Occurrence(id=name, time=self.time, outcome=Outcome.SUCCEEDED) for name in names]

    def watch(self, identifier: str, watch: Watch) -> None:
        """Watch for something.

        Raises:
            RequestRefused: The id is in use.
        """
        if identifier in self._watches:
            raise RequestRefused(Result.OPERATION_FAILED, f"the id {identifier!r} is in use")
        self._watches[identifier] = watch

    def cancel(self, identifier: str) -> None:
        """Forget a watch.

        Raises:
            RequestRefused: There is none of that id.
        """
        if self._watches.pop(identifier, None) is None:
            raise RequestRefused(Result.NOT_FOUND, f"there is no watch {identifier!r}")


def _holds(watch: Watch, entities: Mapping[str, wire.EntityState]) -> bool:
    try:
        return watch.holds(entities)
    except RequestRefused:  # what it watches has gone
        return False


def relative(entities: Mapping[str, wire.EntityState], frame: str, parent: str) -> tuple[float, float, float]:
    """Where a frame is in another, seen from above: x, y [m] and yaw [rad]. Entities are frames by their names.

    Raises:
        RequestRefused: There is no such entity.
    """
    (x, y, yaw), (px, py, pyaw) = _planar(entities, frame), _planar(entities, parent)
    cos, sin = math.cos(pyaw), math.sin(pyaw)
    dx, dy = x - px, y - py
    return cos * dx + sin * dy, cos * dy - sin * dx, math.remainder(yaw - pyaw, math.tau)


def _planar(entities: Mapping[str, wire.EntityState], frame: str) -> tuple[float, float, float]:
    if frame == MAP:
        return 0.0, 0.0, 0.0
    name = frame.removesuffix("_base_link_gt")  # as simulator nodes call a robot's true place
    if name not in entities:
        raise RequestRefused(
            Result.NOT_FOUND, f"there is no frame or entity {frame!r}: known are {listed([MAP, *entities])}"
        )
    pose = entities[name].pose
    return pose.position.x, pose.position.y, pose.orientation.yaw


async def open_world(simulator: SimulationInterfaces) -> RosWorld:
    """Pause a simulator, and find out how long its steps are, by making some.

    Raises:
        RequestRefused: It does not say when its entities are where.
    """
    await simulator.pause()
    before: States = await simulator.states()
    await simulator.step(TRIED)
    after = await simulator.states()
    step = (after.time - before.time) / TRIED
    if not step > 0.0:
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED,
            "the states of entities have no times, by which the length of a step is known: there is no entity, or "
            "the simulator does not say when",
        )
    return RosWorld(simulator, round(step, 9), after.time)
