"""A lab, as those see it who look after it: how its robots are, who has them, and stopping them."""

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
from seoro.errors import BackendError, InvalidUse
from seoro.lab import commanding
from seoro.lab.commanding import Outcome, Place
from seoro.lab.reading import Lab
from seoro.lab.seeing import Member, look
from seoro.people import whoami

RELEASE_WITHIN: Final = 10.0  # [s]


@dataclass(frozen=True)
class Lease:
    """Robots that are kept for somebody.

    Attributes:
        name: Its id, for `seoro.Leasing(lease=...)` and for whoever ends it.
        robots: Their names, as they were asked for.
        until: When it ends by itself [s since 1970].
    """

    name: str
    robots: tuple[str, ...]
    until: float


class LabControl:
    """Looks after a lab. Made by `seoro.Client.lab`.

    Args:
        endpoints: Where its nodes, executors and routers are reached.
        file: Its file, which has names of robots; None if they are those at their nodes.
        keys: Folder of keys; None for that of the environment variable `SEORO_KEYS`, else `~/.config/seoro/keys`.
    """

    def __init__(self, endpoints: Sequence[str], file: Lab | None = None, keys: Path | None = None) -> None:
        self._endpoints = tuple(endpoints)
        self._file = file
        self._keys = keys

    async def status(self) -> list[Member]:
        """All who are alive, nodes with how their robots are, and endpoints where nobody is, with the reason."""
        return await look(self._endpoints, self._keys)

    async def lease(self, *robots: str, duration: float = 600.0, purpose: str = "") -> Lease:
        """Keep robots: all of them, or none. No run gets them that does not name the lease.

        Args:
            robots: Their names, in the lab file or at their nodes.
            duration: For how long [s].
            purpose: What for, for others who want them.

        Raises:
            InvalidUse: There is no such robot.
            BackendError: One of them cannot be had; it says who has it.
        """
        _check_named(robots)
        to_text("purpose", purpose)
        within = to_limit("duration", duration)
        name = f"hand-{secrets.token_hex(4)}"
        until = time.time() + within
        whose = f"{purpose} - {whoami()}" if purpose else whoami()
        places = self._places(robots)
        outcomes = await commanding.lease(places, self._endpoints, name, whose, within, self._keys)
        if refused := [f"{each.called}: {each.error}" for each in outcomes if each.error]:
            raise BackendError(f"cannot lease {', '.join(robots)}: {'; '.join(refused)}")
        return Lease(name, robots, until)

    async def release(self, name: str) -> Outcome:
        """End a lease by its id, or that of a robot.

        Raises:
            InvalidUse: There is none.
        """
        (place,) = self._places([to_text("name", name)])
        return await commanding.end_lease(self._endpoints, place, self._keys)

    @asynccontextmanager
    async def leased(self, *robots: str, duration: float = 600.0, purpose: str = "") -> AsyncIterator[Lease]:
        """Keep robots for as long as the block lasts, but no longer than `duration` [s]; else as `lease`."""
        lease = await self.lease(*robots, duration=duration, purpose=purpose)
        try:
            yield lease
        finally:
            if time.time() < lease.until:
                with anyio.move_on_after(RELEASE_WITHIN, shield=True):  # also where the block is cancelled
                    await self.release(lease.name)

    async def stop(self, *robots: str) -> list[Outcome]:
        """Stop robots, which ends their goals; they may be sent on afterwards.

        Raises:
            InvalidUse: There is no such robot.
        """
        _check_named(robots)
        return await commanding.stop_robots(self._places(robots), self._endpoints, self._keys)

    async def stop_all(self, reason: str = "") -> list[Outcome]:
        """Emergency stop: everything stops, and nothing moves until it is released.

        Args:
            reason: Why, for others.
        """
        return await commanding.stop_all(self._endpoints, whoami(), to_text("reason", reason), self._keys)

    async def estop(self, *robots: str, reason: str = "") -> list[Outcome]:
        """Emergency stop of some robots, which do not move until it is released; all others go on.

        Args:
            robots: Their names, in the lab file or at their nodes; `stop_all` is for all.
            reason: Why, for others.

        Raises:
            InvalidUse: No robot is named.
        """
        _check_named(robots, "`lab.stop_all()` is for all of them")
        to_text("reason", reason)
        return await commanding.stop_named(self._places(robots), self._endpoints, whoami(), reason, self._keys)

    async def release_all(self, reason: str) -> list[Outcome]:
        """Let things move again after an emergency stop.

        Args:
            reason: Why that is safe.

        Raises:
            InvalidUse: There is no reason.
        """
        _check_reason(reason)
        return await commanding.release_all(self._endpoints, whoami(), reason, self._keys)

    async def release_estop(self, *robots: str, reason: str) -> list[Outcome]:
        """Let some robots move again after an emergency stop of these.

        Args:
            robots: Their names, as `estop` had them.
            reason: Why that is safe.

        Raises:
            InvalidUse: There is no reason, or one of the robots is unknown or was not stopped by its name.
        """
        _check_reason(reason)
        _check_named(robots, "`lab.release_all(reason)` is for all of them")
        return await commanding.release_named(self._places(robots), self._endpoints, whoami(), reason, self._keys)

    def _places(self, robots: Sequence[str]) -> list[Place]:
        """Names of robots at their nodes, each with its endpoint if the lab file says so."""
        lab = self._file
        places: list[Place] = []
        for robot in robots:
            if lab is not None and robot in lab.robots:
                places.append((lab.called(robot), lab.address(lab.robots[robot].where)[0]))
            else:
                places.append((robot, None))
        return places


def _check_reason(reason: str) -> None:
    if not to_text("reason", reason).strip():
        raise InvalidUse("an emergency stop is released with a reason", help="such as 'nobody is inside'")


def _check_named(robots: Sequence[str], hint: str = "names are arguments of their own: `'tb1', 'tb2'`") -> None:
    if not robots:
        raise InvalidUse("expected names of robots", help=hint)
    to_texts("robots", robots)
