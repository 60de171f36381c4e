"""What the rules share: a backend at the start of a run, grants of time, and words for what was found."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Protocol, TypeVar, runtime_checkable

from seoro.errors import BackendError, BackendRefused
from seoro.runtime.capabilities import Simulation
from seoro.runtime.contracts import (
    Backend,
    GoalStatus,
    Orientation3D,
    Pose3D,
    Position3D,
    Report,
    TimeServer,
    Velocity6D,
)

BOX = "example_simulation://models/box.sdf"  # a cube of 0.3 m, its origin in the middle of its underside
DRIVEN = ("differential_drive_robot", "robot", "osc_actor")
STEP = 0.05  # [s] by which a grant may be overrun: the longest physics step
AT_REST = Velocity6D()
C = TypeVar("C")


class SimulatedBackend(Backend, TimeServer, Protocol):
    """A backend that is granted time."""


Make = Callable[[], AbstractAsyncContextManager[SimulatedBackend]]


@runtime_checkable
class Levelled(Protocol):
    """A backend that lacks some of the contracts whose methods it has."""

    def serves(self, contract: type) -> bool:
        """Whether it keeps a contract."""
        ...


def has(backend: SimulatedBackend, contract: type) -> bool:
    """Whether a backend keeps a contract, as far as it says."""
    return isinstance(backend, contract) and (not isinstance(backend, Levelled) or backend.serves(contract))


class Reports:
    """A reporter that keeps what it is told."""

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
        """How what was reported ended."""
        return [report.status.value for report in self.all]


class Bench:
    """A backend in a run that has just started.

    Attributes:
        backend: The backend.
        robot: What it calls its robot.
        happened: What it told unasked: name and arguments.
        lost: Why it said that it is gone.
        time: What the last grant came to [s].
    """

    def __init__(self, backend: SimulatedBackend, robot: str) -> None:
        self.backend = backend
        self.robot = robot
        self.happened: list[tuple[str, Mapping[str, Any]]] = []
        self.lost: list[BackendError] = []
        self.time = 0.0

    def can(self, contract: type[C]) -> C:
        """The backend as one that serves a contract, which was checked before."""
        assert isinstance(self.backend, contract)
        return self.backend

    async def grant(self, until: float) -> float:
        """Grant time once; returns what it came to [s]."""
        time = await self.backend.advance(until)
        limit = max(until, self.time) + STEP
        expect(self.time <= time <= limit, f"a grant from {self.time} s to {until} s came to {time} s")
        self.time = time
        return time

    async def pass_time(self, duration: float) -> None:
        """Grant a duration [s], whatever happens in it."""
        await self.pass_until(self.time + duration, lambda: False)

    async def pass_until(self, limit: float, happens: Callable[[], bool]) -> None:
        """Grant time until something happens, to a limit [s]."""
        grants = 0
        while self.time < limit and not happens():
            before = self.time
            await self.grant(limit)
            grants = grants + 1 if self.time == before else 0
            expect(grants < 100, f"time stands at {self.time} s, although it is granted to {limit} s")

    async def truth(self) -> tuple[float, float, float]:
        """Where the robot really is: x, y [m] and yaw [rad]."""
        found = await self.can(Simulation).relative_pose(self.truth_frame, "map", 0.0)
        return found.position.x, found.position.y, found.orientation.yaw

    @property
    def truth_frame(self) -> str:
        """The frame in which the robot really is."""
        return f"{self.robot}_base_link_gt"


@asynccontextmanager
async def started(make: Make, types: tuple[str, ...] = DRIVEN) -> AsyncIterator[Bench]:
    """A backend whose run has started with an actor of a type, and that is ended afterwards."""
    async with make() as backend:
        robot = backend.home_of("robot", types)
        if robot is None:
            raise AssertionError(f"{backend.name} has no robot for an actor of type {types[0]}")
        bench = Bench(backend, robot)
        await backend.start_run(
            lambda name, arguments: bench.happened.append((name, arguments)), bench.lost.append
        )
        try:
            yield bench
        finally:
            await backend.end_run()


def place(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Pose3D:
    """A pose [m, rad]."""
    return Pose3D(Position3D(x, y, z), Orientation3D(yaw=yaw))


def expect(holds: bool, otherwise: str) -> None:
    """Raise an AssertionError with what is wrong unless something holds."""
    if not holds:
        raise AssertionError(otherwise)


def expect_near(what: str, found: float, wanted: float, by: float) -> None:
    """Expect a number to be as wanted, within a tolerance."""
    expect(abs(found - wanted) <= by, f"{what} is {found:.6g} instead of {wanted:.6g}: off by more than {by:g}")


def expect_reported(what: str, reports: Reports, *wanted: GoalStatus) -> None:
    """Expect that something was reported once, as ended in one of some ways."""
    names = " or ".join(status.value for status in wanted)
    found = ", ".join(reports.statuses) or "nothing"
    expect(
        len(reports.all) == 1 and reports.all[0].status in wanted,
        f"{what} was reported as {found}, not once as {names}",
    )


async def expect_refused(what: str, request: Awaitable[object], code: int | None = None) -> None:
    """Expect a request to be refused with a result code and a sentence for people."""
    try:
        await request
    except BackendRefused as refused:
        said = str(refused)
        expect(" " in said.strip(), f"{what} is refused with {said!r}, which is no sentence")
        expect(refused.code != 1, f"{what} is refused with the code of success")
        if code is not None:
            expect(refused.code == code, f"{what} is refused with the code {refused.code} instead of {code}")
        return
    raise AssertionError(f"{what} is not refused")


def distance(first: tuple[float, ...], second: tuple[float, ...]) -> float:
    """Distance of two places in the plane [m]."""
    return math.dist(first[:2], second[:2])
