"""World of a ROS simulator: its time in steps, and relative poses."""

from __future__ import annotations

import logging
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio

from seoro.bridges.ros2.simulators.interfaces import MAP, SimulationInterfaces, States
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, name_list

MEASURED_STEPS = 10  # steps to measure the step length
MAX_ADVANCE = 5.0  # [s] of one request for steps
ROUNDING = 1e-6  # [steps]
PLAY_TIMEOUT = 2.0  # [s]

log = logging.getLogger(__name__)


class RosWorld:
    """A world that advances in steps. Made by `opening_world`.

    Args:
        simulator: Client of the simulator.
        step: Step length [s].

    Attributes:
        has_stepped: Whether steps were made.
    """

    def __init__(self, simulator: SimulationInterfaces, step: float) -> None:
        self.simulator = simulator
        self.step_length = step
        self._steps = 0
        self.has_stepped = False

    @property
    def time(self) -> float:
        """Time since the beginning [s]; a multiple of the step length."""
        return self._steps * self.step_length

    def reset_time(self) -> None:
        """Set the time to zero."""
        self._steps = 0

    async def step(self, count: int) -> None:
        """Make steps."""
        self.has_stepped = True
        await self.simulator.step(count)
        self._steps += count

    async def advance(self, until: float) -> None:
        """Step to a time [s], or to the first step after it."""
        while (left := math.ceil((until - self.time) / self.step_length - ROUNDING)) > 0:
            await self.step(min(left, max(1, round(MAX_ADVANCE / self.step_length))))


def relative_pose(states: States, frame: str, parent: str) -> tuple[float, float, float]:
    """Return the pose of a frame in another one, in the plane: x, y [m] and yaw [rad]. Entities are frames.

    Raises:
        RequestRefused: An entity is unknown, or its pose is invalid.
    """
    (x, y, yaw), (px, py, pyaw) = _planar(states, frame), _planar(states, parent)
    cos, sin = math.cos(pyaw), math.sin(pyaw)
    dx, dy = x - px, y - py
    return cos * dx + sin * dy, cos * dy - sin * dx, math.remainder(yaw - pyaw, math.tau)


def _planar(states: States, frame: str) -> tuple[float, float, float]:
    if frame == MAP:
        return 0.0, 0.0, 0.0
    name = frame.removesuffix("_base_link_gt")  # frame of the true pose of a robot in simulator nodes
    if name not in states.entities:
        raise RequestRefused(
            Result.NOT_FOUND, f"unknown frame {frame!r} (frames: {name_list([MAP, *states.entities])})"
        )
    pose = states.of(name).pose
    return pose.position.x, pose.position.y, pose.orientation.yaw


@asynccontextmanager
async def opening_world(simulator: SimulationInterfaces) -> AsyncIterator[RosWorld]:
    """Pause a simulator, and measure its step length by making steps.

    After the block, it stays paused; if it played before and the block made no steps, it plays again.

    Raises:
        RequestRefused: The states of the entities have no times.
    """
    played, world = await simulator.is_playing(), None
    try:
        await simulator.pause()
        world = RosWorld(simulator, await _measure_step(simulator))
        yield world
    finally:
        if played and not (world and world.has_stepped):
            await _play_again(simulator)


async def _play_again(simulator: SimulationInterfaces) -> None:
    problem = f"no response within {PLAY_TIMEOUT:g} s"
    with anyio.move_on_after(PLAY_TIMEOUT, shield=True):
        try:
            await simulator.play()
        except RequestRefused as refused:
            problem = refused.message
        else:
            return
    log.warning("the simulator played before, and may stay paused: %s", problem)


async def _measure_step(simulator: SimulationInterfaces) -> float:
    before = (await simulator.states()).time
    await simulator.step(MEASURED_STEPS)
    step = ((await simulator.states()).time - before) / MEASURED_STEPS
    if not step > 0.0:
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED,
            "unknown step length: the world has no entities, or their states have no time stamps",
        )
    return round(step, 9)
