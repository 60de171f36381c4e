"""Common parts of the rules: a backend in a run, grants of time, and expectations."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Protocol, TypeVar, runtime_checkable

from seoro.errors import BackendError, BackendRefused
from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D, Velocity6D
from seoro.runtime.contracts.backends import Backend, GoalStatus, Report
from seoro.runtime.contracts.worlds import Frames
from seoro.runtime.kernel.clock import TimeServer

BOX = "example_simulation://models/box.sdf"  # a cube of 0.3 m, its origin in the middle of its underside
DRIVEN = ("differential_drive_robot", "robot", "osc_actor")
STEP = 0.05  # [s] longest overrun of a grant: the longest physics step
AT_REST = Velocity6D()
Rule = Callable[[Any], Awaitable[None]]
"""Checks its argument: a `Bench`, an `ArmBench`, or a `Make` if it is named so, to compare several runs."""
RULES: dict[Rule, tuple[type, ...]] = {}
"""Rules of backends, with the contracts that they require."""

C = TypeVar("C")
B = TypeVar("B", bound="Bench")


def rule(*contracts: type) -> Callable[[Rule], Rule]:
    """Decorate a rule of backends with the contracts that it requires."""

    def register(function: Rule) -> Rule:
        RULES[function] = contracts
        return function

    return register


class SimulatedBackend(Backend, TimeServer, Protocol):
    """Backend with simulated time."""


Make = Callable[[], AbstractAsyncContextManager[SimulatedBackend]]


@runtime_checkable
class Partial(Protocol):
    """Backend that supports some of the contracts whose methods it has."""

    def serves(self, contract: type) -> bool:
        """Whether the backend supports a contract."""


def has(backend: SimulatedBackend, contract: type) -> bool:
    """Whether a backend supports a contract."""
    return isinstance(backend, contract) and (not isinstance(backend, Partial) or backend.serves(contract))


class Reports:
    """Reporter that keeps its reports."""

    def __init__(self) -> None:
        self.all: list[Report] = []

    def __call__(self, report: Report) -> None:
        """Keep a report."""
        self.all.append(report)

    def any(self) -> bool:
        """Whether anything was reported."""
        return bool(self.all)

    @property
    def statuses(self) -> list[str]:
        """Statuses of all reports."""
        return [report.status.value for report in self.all]


class Bench:
    """A backend in a run that has just started.

    Attributes:
        backend: The backend.
        robot: Name of its robot.
        happened: Received events: name and arguments.
        lost: Reasons of reported losses.
        time: Result of the last grant [s].
    """

    def __init__(self, backend: SimulatedBackend, robot: str) -> None:
        self.backend = backend
        self.robot = robot
        self.happened: list[tuple[str, Mapping[str, Any]]] = []
        self.lost: list[BackendError] = []
        self.time = 0.0

    def cast(self, contract: type[C]) -> C:
        """Cast the backend to `contract` (already checked)."""
        assert isinstance(self.backend, contract)
        return self.backend

    async def grant(self, until: float) -> float:
        """Grant time once; returns the reached time [s]."""
        time = await self.backend.advance(until)
        limit = max(until, self.time) + STEP
        expect(self.time <= time <= limit, f"a grant from {self.time} s to {until} s reached {time} s")
        self.time = time
        return time

    async def pass_time(self, duration: float) -> None:
        """Grant a duration [s]."""
        await self.pass_until(self.time + duration, lambda: False)

    async def pass_until(self, limit: float, happens: Callable[[], bool]) -> None:
        """Grant time up to a limit [s], or until a condition holds."""
        grants = 0
        while self.time < limit and not happens():
            before = self.time
            await self.grant(limit)
            grants = grants + 1 if self.time == before else 0
            expect(grants < 100, f"time stands at {self.time} s, although it is granted to {limit} s")

    async def expect_end(self, what: str, reports: Reports, limit: float) -> None:
        """Grant time until a success is reported, for a duration of at most `limit` [s]."""
        await self.pass_until(self.time + limit, reports.any)
        expect_reported(what, reports, GoalStatus.SUCCEEDED)

    async def truth(self) -> tuple[float, float, float]:
        """Return the true pose of the robot: x, y [m] and yaw [rad]."""
        found = await self.cast(Frames).relative_pose(self.truth_frame, "map", 0.0)
        return found.position.x, found.position.y, found.orientation.yaw

    async def expect_still(self, what: str) -> None:
        """Expect the robot to stand still for a second."""
        before = await self.truth()
        await self.pass_time(1.0)
        moved = distance(before, await self.truth())
        expect(moved < 0.01, f"{what} moved {moved:.3f} m in a second")

    @property
    def truth_frame(self) -> str:
        """Frame of the robot's true pose."""
        return f"{self.robot}_base_link_gt"


@asynccontextmanager
async def started(make: Make) -> AsyncIterator[Bench]:
    """Open a backend and run it with a driving robot while the block lasts."""
    async with started_with(make, DRIVEN, Bench) as bench:
        yield bench


@asynccontextmanager
async def started_with(
    make: Make, types: tuple[str, ...], bench_of: Callable[[SimulatedBackend, str], B]
) -> AsyncIterator[B]:
    """Open a backend and run it with an actor of a type while the block lasts."""
    async with make() as backend:
        robot = backend.assign_robot("robot", types)
        if robot is None:
            raise AssertionError(f"{backend.name} has no robot for an actor of type {types[0]}")
        bench = bench_of(backend, robot)
        await backend.start_run(
            lambda name, arguments: bench.happened.append((name, arguments)), bench.lost.append
        )
        try:
            yield bench
        finally:
            await backend.end_run()


def place(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Pose3D:
    """Return a pose [m, rad]."""
    return Pose3D(Position3D(x, y, z), Orientation3D(yaw=yaw))


def expect(holds: bool, otherwise: str) -> None:
    """Raise an AssertionError with the message `otherwise` unless a condition holds."""
    if not holds:
        raise AssertionError(otherwise)


def expect_near(what: str, found: float, wanted: float, by: float) -> None:
    """Expect a number within a tolerance."""
    expect(abs(found - wanted) <= by, f"{what} is {found:.6g} instead of {wanted:.6g}: off by more than {by:g}")


def expect_reported(what: str, reports: Reports, *wanted: GoalStatus) -> None:
    """Expect exactly one report, with one of the wanted statuses."""
    names = " or ".join(status.value for status in wanted)
    found = ", ".join(reports.statuses) or "nothing"
    expect(
        len(reports.all) == 1 and reports.all[0].status in wanted,
        f"{what} was reported as {found}, not once as {names}",
    )


def expect_cancelled(what: str, reports: Reports) -> None:
    """Expect no report, or that of a cancellation."""
    expect(reports.statuses in ([], ["canceled"]), f"{what} was reported as {', '.join(reports.statuses)}")


async def expect_refused(what: str, request: Awaitable[object], code: int | None = None) -> None:
    """Expect a request to be refused with a result code and a readable message."""
    try:
        await request
    except BackendRefused as refused:
        message = str(refused)
        expect(" " in message.strip(), f"{what} is refused with {message!r}, which is not a sentence")
        expect(refused.code != 1, f"{what} is refused with the code of success")
        if code is not None:
            expect(refused.code == code, f"{what} is refused with the code {refused.code} instead of {code}")
        return
    raise AssertionError(f"{what} is not refused")


def distance(first: tuple[float, ...], second: tuple[float, ...]) -> float:
    """Return the distance of two positions in the plane [m]."""
    return math.dist(first[:2], second[:2])
