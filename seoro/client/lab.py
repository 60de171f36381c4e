"""Control of a lab: states, leases and stops of its robots."""

from __future__ import annotations

import secrets
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio

from seoro.embed.arguments import to_limit, to_text, to_texts
from seoro.embed.whoami import whoami
from seoro.errors import BackendError, UsageError
from seoro.lab.commands import LabCommands, Place
from seoro.lab.outcomes import OnOutcome, Outcome, ignore_outcome
from seoro.lab.reading import Lab
from seoro.lab.status import Member, read_states

RELEASE_WITHIN: Final = 10.0  # [s]
RECORDED: Final = "it is a recorded robot, without users and motion"


@dataclass(frozen=True)
class Lease:
    """Lease of robots by hand.

    Attributes:
        name: Id of the lease, for `seoro.Leasing(lease=...)` and for `release`.
        robots: Names of the robots, as requested.
        until: Time at which it expires [s since 1970].
    """

    name: str
    robots: tuple[str, ...]
    until: float


class LabControl:
    """Controls a lab. Made by `seoro.Client.lab`.

    Args:
        endpoints: Endpoints of its nodes, executors and routers.
        file: Lab file with names of robots; None to use the names at their nodes.
        keys: Folder of keys; None for that of the environment variable `SEORO_KEYS`, else `~/.config/seoro/keys`.
    """

    def __init__(self, endpoints: Sequence[str], file: Lab | None = None, keys: Path | None = None) -> None:
        self._commands = LabCommands(tuple(endpoints), keys)
        self._file = file

    async def status(self) -> list[Member]:
        """Return all members with the states of their robots, and unreachable endpoints with the reason."""
        return await read_states(self._commands.endpoints, self._commands.keys)

    async def lease(self, *robots: str, duration: float = 600.0, purpose: str = "") -> Lease:
        """Lease robots by hand, all or none; only runs that name the lease can acquire them.

        Args:
            robots: Names of the robots, in the lab file or at their nodes.
            duration: Duration of the lease [s].
            purpose: Purpose, shown to other clients.

        Raises:
            UsageError: Unknown robot.
            BackendError: A robot is not available; the message names its holder.
        """
        _check_named(robots)
        to_text("purpose", purpose)
        within = to_limit("duration", duration)
        name = f"hand-{secrets.token_hex(4)}"
        until = time.time() + within
        whose = f"{purpose} - {whoami()}" if purpose else whoami()
        outcomes = await self._commands.lease(self._places(robots), name, whose, within)
        if refused := [f"{each.display_name}: {each.error}" for each in outcomes if each.error]:
            raise BackendError(f"cannot lease {', '.join(robots)}: {'; '.join(refused)}")
        return Lease(name, robots, until)

    async def release(self, name: str) -> Outcome:
        """End a lease by its id, or by a robot.

        Raises:
            UsageError: The lease is unknown.
        """
        (place,) = self._places([to_text("name", name)])
        return await self._commands.release_lease(place)

    @asynccontextmanager
    async def leased(self, *robots: str, duration: float = 600.0, purpose: str = "") -> AsyncIterator[Lease]:
        """Lease robots while the block lasts, for at most `duration` [s]; see `lease`."""
        lease = await self.lease(*robots, duration=duration, purpose=purpose)
        try:
            yield lease
        finally:
            if time.time() < lease.until:
                with anyio.move_on_after(RELEASE_WITHIN, shield=True):  # also if the block is cancelled
                    await self.release(lease.name)

    async def stop(self, *robots: str) -> list[Outcome]:
        """Stop robots and end their goals; new goals are accepted.

        Raises:
            UsageError: Unknown robot.
        """
        _check_named(robots)
        return await self._commands.stop_robots(self._places(robots))

    async def stop_all(self, reason: str = "", on_outcome: OnOutcome = ignore_outcome) -> list[Outcome]:
        """Stop all robots and runs in an emergency, until a release.

        Args:
            reason: Reason, shown to other clients.
            on_outcome: Called with each outcome as it arrives. Stops are repeated, so a node may have several; one
                without an error is final.
        """
        return await self._commands.emergency_stop_all(whoami(), to_text("reason", reason), on_outcome)

    async def estop(self, *robots: str, reason: str = "") -> list[Outcome]:
        """Stop some robots in an emergency, until a release.

        Args:
            robots: Names of the robots, in the lab file or at their nodes; see `stop_all` for all.
            reason: Reason, shown to other clients.

        Raises:
            UsageError: The names are missing, or a robot is unknown.
        """
        _check_named(robots, "use `lab.stop_all()` for all robots")
        to_text("reason", reason)
        recorded = [
            name for name in robots if self._is_recorded(name)
        ]  # these do not keep others from being stopped
        places = self._places([name for name in robots if name not in recorded])
        stopped = await self._commands.emergency_stop_robots(places, whoami(), reason) if places else []
        return [*stopped, *(Outcome("", name, error=RECORDED) for name in recorded)]

    async def release_all(self, reason: str) -> list[Outcome]:
        """Release the emergency stop of all robots and runs.

        Args:
            reason: Reason why the release is safe.

        Raises:
            UsageError: The reason is missing.
        """
        _check_reason(reason)
        return await self._commands.release_all(whoami(), reason)

    async def release_estop(self, *robots: str, reason: str) -> list[Outcome]:
        """Release the emergency stop of some robots.

        Args:
            robots: Names of the robots, as for `estop`.
            reason: Reason why the release is safe.

        Raises:
            UsageError: The reason is missing, or a robot is unknown or was not stopped by name.
        """
        _check_reason(reason)
        _check_named(robots, "use `lab.release_all(reason)` for all robots")
        return await self._commands.release_robots(self._places(robots), whoami(), reason)

    def _is_recorded(self, robot: str) -> bool:
        """Whether a robot of the lab file is a recorded one."""
        lab = self._file
        return lab is not None and robot in lab.robots and lab.robots[robot].bag is not None

    def _places(self, robots: Sequence[str]) -> list[Place]:
        """Return the names of robots at their nodes, each with its endpoint if the lab file has one.

        Raises:
            UsageError: A robot is a recorded one.
        """
        lab = self._file
        places: list[Place] = []
        for robot in robots:
            if self._is_recorded(robot):
                raise UsageError(f"cannot use '{robot}': {RECORDED}", help="leave it out")
            if lab is not None and robot in lab.robots:
                places.append((lab.remote_name(robot), lab.address(lab.robots[robot].where)[0]))
            else:
                places.append((robot, None))
        return places


def _check_reason(reason: str) -> None:
    if not to_text("reason", reason).strip():
        raise UsageError("missing reason of the release of an emergency stop", help="such as 'the area is clear'")


def _check_named(robots: Sequence[str], hint: str = "pass each name as an argument: `'tb1', 'tb2'`") -> None:
    if not robots:
        raise UsageError("expected names of robots", help=hint)
    to_texts("robots", robots)
