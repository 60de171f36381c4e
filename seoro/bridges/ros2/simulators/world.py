"""A simulation in a simulator of the ROS world: its time in steps, and where things are."""

from __future__ import annotations

import logging
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio

from seoro.bridges.ros2.simulators.interfaces import MAP, SimulationInterfaces, States
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed

TRIED = 10  # steps that are made to find out how long one is
LONGEST = 5.0  # [s] that are stepped at a time
ROUNDING = 1e-6  # [steps]
PLAYS_WITHIN = 2.0  # [s] that a simulator may take to play again

log = logging.getLogger(__name__)


class RosWorld:
    """A simulation that passes in steps. Made by `opening_world`.

    Args:
        simulator: Its services.
        step: Length of a step [s].
        start: The simulator's time at the beginning [s].

    Attributes:
        has_begun: Whether steps were asked for.
    """

    def __init__(self, simulator: SimulationInterfaces, step: float, start: float) -> None:
        self.simulator = simulator
        self.step_length = step
        self._start = start
        self._steps = 0
        self.has_begun = False

    @property
    def time(self) -> float:
        """Since the beginning [s]; a multiple of the length of a step."""
        return self._steps * self.step_length

    def start_over(self) -> None:
        """Begin at time zero."""
        self._steps = 0

    async def step(self, count: int) -> None:
        """Make steps."""
        self.has_begun = True
        await self.simulator.step(count)
        self._steps += count

    async def advance(self, until: float) -> None:
        """Step to a time [s], or to the first after it."""
        while (left := math.ceil((until - self.time) / self.step_length - ROUNDING)) > 0:
            await self.step(min(left, max(1, round(LONGEST / self.step_length))))


def relative(states: States, frame: str, parent: str) -> tuple[float, float, float]:
    """Where a frame is in another, seen from above: x, y [m] and yaw [rad]. Entities are frames by their names.

    Raises:
        RequestRefused: There is no such entity, or it is not told where it is.
    """
    (x, y, yaw), (px, py, pyaw) = _planar(states, frame), _planar(states, parent)
    cos, sin = math.cos(pyaw), math.sin(pyaw)
    dx, dy = x - px, y - py
    return cos * dx + sin * dy, cos * dy - sin * dx, math.remainder(yaw - pyaw, math.tau)


def _planar(states: States, frame: str) -> tuple[float, float, float]:
    if frame == MAP:
        return 0.0, 0.0, 0.0
    name = frame.removesuffix("_base_link_gt")  # as simulator nodes call a robot's true place
    if name not in states.entities:
        raise RequestRefused(
            Result.NOT_FOUND, f"there is no frame or entity {frame!r}: known are {listed([MAP, *states.entities])}"
        )
    pose = states.of(name).pose
    return pose.position.x, pose.position.y, pose.orientation.yaw


@asynccontextmanager
async def opening_world(simulator: SimulationInterfaces) -> AsyncIterator[RosWorld]:
    """Pause a simulator, and find out how long its steps are, by making some.

    After the block it stays paused, or plays on if it played before and the block has asked for no steps.

    Raises:
        RequestRefused: It does not say when its entities are where.
    """
    played, world = await simulator.plays(), None
    try:
        await simulator.pause()
        world = await _measured(simulator)
        yield world
    finally:
        if played and not (world and world.has_begun):
            await _play_on(simulator)


async def _play_on(simulator: SimulationInterfaces) -> None:
    problem = f"it has not responded within {PLAYS_WITHIN:g} s"
    with anyio.move_on_after(PLAYS_WITHIN, shield=True):
        try:
            await simulator.play()
        except RequestRefused as refused:
            problem = refused.message
        else:
            return
    log.warning("the simulator played before, and may stay paused: %s", problem)


async def _measured(simulator: SimulationInterfaces) -> RosWorld:
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
