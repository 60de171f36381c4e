"""State of a lab, read while a page follows it.

Each endpoint has a connection and a task of its own, and each member is asked by itself. So members that do not
answer delay no news of the others.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Collection, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import anyio

from seoro.bridges.executor import messages
from seoro.bridges.executor.asking import Executor
from seoro.bridges.session import SessionError, is_secured
from seoro.bridges.wire.message import Empty
from seoro.concurrency.background import background
from seoro.concurrency.condition import Condition
from seoro.errors import BackendError, UsageError
from seoro.lab.recorded import RecordedRobot
from seoro.lab.status import ANSWER_TIMEOUT, Connection, ListedRobot, Member, connect_endpoint, members_at, refresh
from seoro.ui.lab_json import snapshot_of

PERIOD: Final = 0.5  # [s] between two questions to a member
LIST_PERIOD: Final = 3.0  # [s] between two lists of the members at an endpoint
RETRY: Final = 3.0  # [s] until an unreachable endpoint is tried again


@dataclass(frozen=True)
class Seen:
    """A member as it was last seen.

    Args:
        member: The member, with its state.
        stopped: Reason of the emergency stop of an executor; empty without one.
        is_asked: Whether it was asked for its state; it may not have answered.
    """

    member: Member
    stopped: str = ""
    is_asked: bool = True


class LabWatch:
    """Reads the members at some endpoints while they are followed.

    Args:
        endpoints: Returns the endpoints of nodes, executors and routers, which may become more.
        optional: Further endpoints, which need not be in use.
        listed: Robots of a lab file.
        keys: Folder of keys, as in `connect_members`.
        recorded: Recorded robots of a lab file.
    """

    def __init__(
        self,
        endpoints: Callable[[], Sequence[str]],
        optional: Sequence[str] = (),
        listed: Sequence[ListedRobot] = (),
        keys: Path | None = None,
        recorded: Sequence[RecordedRobot] = (),
    ) -> None:
        self._endpoints = endpoints
        self._optional = optional
        self._listed = listed
        self._keys = keys
        self._recorded = recorded
        self._seen: dict[str, dict[str, Seen]] = {}
        self._followers = 0
        self._changed = Condition()  # of the members, and of the followers
        self._asked = Condition()  # to read at once

    # ------------------------------------------------------------ for pages

    @property
    def endpoints(self) -> Sequence[str]:
        """All endpoints."""
        return tuple(dict.fromkeys((*self._endpoints(), *self._optional)))

    @property
    def optional(self) -> Collection[str]:
        """Endpoints that need not be in use."""
        return frozenset(self._optional) - frozenset(self._endpoints())

    @property
    def members(self) -> list[Seen]:
        """Members that were seen; optional endpoints without a member are left out."""
        optional = self.optional
        return [
            seen
            for endpoint in self.endpoints
            for seen in self._seen.get(endpoint, {}).values()
            if seen.member.node or endpoint not in optional
        ]

    @asynccontextmanager
    async def followed(self) -> AsyncIterator[None]:
        """Read the lab while the block lasts."""
        self._followers += 1
        self._changed.notify_all()
        try:
            yield
        finally:
            self._followers -= 1
            self._changed.notify_all()

    async def snapshots(self) -> AsyncIterator[Mapping[str, Any]]:
        """Yield the state of the lab, then each change; a slow reader misses some. Use it within `followed`."""
        await self._changed.wait_for(self._is_read)
        last: Mapping[str, Any] | None = None
        while True:
            present = snapshot_of(self.members, self._listed, self._recorded)
            if present != last:
                last = present
                yield present
            else:
                await self._changed.wait()

    def read_again(self) -> None:
        """Ask all members at once, because they have probably changed."""
        self._asked.notify_all()

    def _is_read(self) -> bool:
        found = [self._seen.get(endpoint) for endpoint in self.endpoints]
        return all(members and all(seen.is_asked for seen in members.values()) for members in found)

    # ------------------------------------------------------------ the work

    async def serve(self) -> None:
        """Read the lab whenever it is followed, until this is cancelled."""
        while True:
            await self._changed.wait_for(lambda: self._followers > 0)
            async with background() as tasks:
                while self._followers > 0:
                    for endpoint in self.endpoints:
                        if endpoint not in self._seen:
                            self._seen[endpoint] = {}
                            tasks.start_soon(self._read, endpoint)
                    with anyio.move_on_after(LIST_PERIOD):
                        await self._changed.wait_for(lambda: self._followers == 0)
            self._seen = {}

    async def _read(self, endpoint: str) -> None:
        while True:
            try:
                async with connect_endpoint(endpoint, self._keys, is_repeated=True) as (session, keys):
                    while not session.is_cut_off:
                        await self._read_members(await members_at(endpoint, session, keys))
                reason = "the connection is lost"
            except (SessionError, UsageError) as error:
                reason = str(error)
            self._replace(endpoint, {"": Seen(Member(endpoint, problem=reason))})
            await self._pause(RETRY)

    async def _read_members(self, reached: Sequence[Connection]) -> None:
        """Ask the members at an endpoint again and again, until they are listed anew."""
        (endpoint,) = {each.member.endpoint for each in reached}
        before = self._seen[endpoint]
        found = {
            each.member.node: before.get(each.member.node, Seen(each.member, is_asked=False)) for each in reached
        }
        self._replace(endpoint, found)
        async with background() as tasks:
            for each in reached:
                tasks.start_soon(self._ask_again, each)
            await anyio.sleep(LIST_PERIOD)

    async def _ask_again(self, each: Connection) -> None:
        while True:
            seen = await _ask(each)
            self._replace(each.member.endpoint, {**self._seen[each.member.endpoint], each.member.node: seen})
            await self._pause(PERIOD)

    def _replace(self, endpoint: str, found: dict[str, Seen]) -> None:
        if found != self._seen[endpoint]:
            self._seen[endpoint] = found
            self._changed.notify_all()

    async def _pause(self, seconds: float) -> None:
        with anyio.move_on_after(seconds):
            await self._asked.wait()


async def _ask(each: Connection) -> Seen:
    if each.session is None or not each.member.is_executor:
        (member,) = (await refresh([each])).values()
        return Seen(member)
    secured = is_secured(each.member.endpoint)
    executor = Executor(each.session, each.member.node, minor=0, keys=each.keys, is_secured=secured)
    try:
        with anyio.fail_after(ANSWER_TIMEOUT):
            info = await executor.ask(messages.DESCRIBE, Empty())
    except TimeoutError:
        return Seen(replace(each.member, problem=f"no answer within {ANSWER_TIMEOUT:g} s"))
    except (BackendError, UsageError) as error:
        return Seen(replace(each.member, problem=str(error)))
    return Seen(each.member, info.stopped)
