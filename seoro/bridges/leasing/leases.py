"""Leases of the robots of a node: holds of runs, manual leases, and the wait queue.

A client acquires all requested robots of a node at once, or none. If one of several nodes refuses its robots, the
client releases the others, which prevents deadlocks. Waiting clients have a place in the
queue, by priority and then by arrival, and keep it by repeated requests. No client gets a robot before an earlier
client in the queue that wants it, so none starves.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from datetime import datetime
from functools import cached_property
from itertools import count

from seoro.bridges.wire.holds import HOLD_DEADLINE, HOLD_PATIENCE, QUEUE_PATIENCE, Holder
from seoro.bridges.wire.keys import public_holder_name
from seoro.bridges.wire.lab import LONGEST_LEASE, MAX_TEXT, Lease, LeaseRobots, ReleaseLease
from seoro.bridges.wire.refusal import RequestRefused, check_id, name_list
from seoro.bridges.wire.results import LabResult, Result
from seoro.deferred import dataclass
from seoro.security.signing.replay_window import HolderKey, ReplayWindow

MAX_WAITING = 1000  # clients in the wait queue
MAX_LEASES = 1000  # manual leases
CONNECTION_LOST = "its process has died, or the connection to it is lost"  # reason of a stop of robots
UNSEEN = 5.0  # [s] time limit for the token of a client without heartbeats to appear

log = logging.getLogger(__name__)


@dataclass
class Hold:
    """Robots that a client holds.

    Attributes:
        holder: Request of the client.
        last: Time of its last heartbeat, by the machine's clock [s].
        is_alive: Whether it is not overdue. An overdue client is alive again with its next heartbeat, unless
            another client has acquired its robots.
        is_stopping: Whether its robots are being stopped.
        is_seen: Whether its token has been seen.
        began: Time of the acquisition, by the clock of the node [s].
        kept_until: End of the grace period after a missed heartbeat, by the machine's clock [s].
    """

    holder: Holder
    last: float
    is_alive: bool = True
    is_stopping: bool = False
    is_seen: bool = False
    began: float = 0.0
    kept_until: float = 0.0

    @cached_property
    def key(self) -> HolderKey:
        """Key that authenticates the requests of the client."""
        return _key_of(self.holder)

    def holds(self, robot: str) -> bool:
        """Whether the client holds a robot."""
        return not self.holder.robots or robot in self.holder.robots


@dataclass(frozen=True)
class _QueueEntry:
    """A waiting client, its number in order of arrival, and the time of its last request [s]."""

    holder: Holder
    number: int
    requested: float

    @cached_property
    def key(self) -> HolderKey:
        """Key that authenticates the request of the client to leave the queue."""
        return _key_of(self.holder)

    @property
    def rank(self) -> tuple[int, int]:
        """Sort key in the queue."""
        return -self.holder.priority, self.number


class Leases:
    """Holders and manual leases of the robots of a node.

    Args:
        robots: Returns the names of the robots.
        clock: Monotonic clock of the machine [s].
    """

    def __init__(self, robots: Callable[[], Iterable[str]], clock: Callable[[], float] = time.monotonic) -> None:
        self._robots = robots
        self._clock = clock
        self._holds: dict[str, Hold] = {}
        self._queue: dict[str, _QueueEntry] = {}
        self._leases: dict[str, tuple[frozenset[str], Lease]] = {}  # with their robots
        self._numbers = count()
        self._present: set[str] = set()  # public names of clients with a live token

    # ------------------------------------------------------------ runs

    def acquire(self, request: Holder, now: float) -> tuple[Hold, ...]:
        """Acquire robots for a client.

        Args:
            request: The client and its robots.
            now: Time by the clock of the node [s].

        Returns:
            The holds of overdue clients, which this client replaces.

        Raises:
            RequestRefused: Not all robots are available; the message names the reasons and the holders.
        """
        check_id(request.holder)
        own = self._holds.get(request.holder)
        if own is not None and own.is_alive and own.holder.exchange != request.exchange:
            name = public_holder_name(request.holder)
            raise RequestRefused(LabResult.HELD, f"another client holds robots as '{name}'")
        self._check_known(request.robots)
        self._remove_expired()
        conflict = next(self._conflicts(request), None)
        if request.waits:
            self._enqueue(request)
        else:
            self._queue.pop(request.holder, None)
        if conflict is not None:
            raise RequestRefused(LabResult.HELD, conflict)
        replaced = tuple(hold for hold in self._holds.values() if _overlap(hold.holder.robots, request.robots))
        for hold in replaced:
            del self._holds[hold.holder.holder]
        is_seen = public_holder_name(request.holder) in self._present
        self._holds[request.holder] = Hold(request, self._clock(), is_seen=is_seen, began=now)
        return tuple(hold for hold in replaced if hold.holder.holder != request.holder)

    def key_of(self, holder: str) -> HolderKey | None:
        """Return the key of a client that holds robots or waits for some; None for all others."""
        owner = self._holds.get(holder) or self._queue.get(holder)
        return None if owner is None else owner.key

    def renew(self, holder: str) -> Hold:
        """Record a heartbeat.

        Raises:
            RequestRefused: The client does not hold anything.
        """
        hold = self._holds.get(holder)
        if hold is None:
            others = sorted({display_name(other.holder) for other in self._holds.values()})
            now = f"{' and '.join(others)} has them" if others else "this node was restarted"
            raise RequestRefused(LabResult.NOT_HELD, f"this run lost its robots: {now}")
        hold.last, hold.is_alive = self._clock(), True
        return hold

    def release(self, holder: str, *, waits: bool = False) -> None:
        """End a hold; the client keeps its place in the queue if it `waits`."""
        self._holds.pop(holder, None)
        if not waits:
            self._queue.pop(holder, None)

    def hold_of(self, holder: str) -> Hold | None:
        """Return the hold of a client, alive or not."""
        return self._holds.get(holder)

    def holder_of(self, robot: str) -> Hold | None:
        """Return the live holder of a robot."""
        return next((hold for hold in self._live() if hold.holds(robot)), None)

    def holder_names(self, robots: Iterable[str]) -> str:
        """Return the names of the live holders of robots, as text; empty without one."""
        holds = (self.holder_of(robot) for robot in robots)
        return " and ".join(dict.fromkeys(display_name(hold.holder) for hold in holds if hold is not None))

    @property
    def name_of_sole_holder(self) -> str:
        """Name of the live holder of the whole node; empty without one."""
        return next((display_name(hold.holder) for hold in self._live() if not hold.holder.robots), "")

    def _live(self) -> Iterator[Hold]:
        return (hold for hold in self._holds.values() if hold.is_alive)

    def robots_of(self, hold: Hold) -> tuple[str, ...]:
        """Return the robots that a client holds."""
        return tuple(robot for robot in self._robots() if hold.holds(robot))

    def check(self, sender: str, robot: str, *, has_to_hold: bool) -> None:
        """Check that a client may move a robot.

        Args:
            sender: Sender; empty if unnamed.
            robot: The robot.
            has_to_hold: Whether free robots must not be moved either.

        Raises:
            RequestRefused: Another client holds the robot, or the sender has to hold it and does not.
        """
        hold = next((hold for hold in self._holds.values() if hold.holds(robot)), None)
        if hold is not None and hold.is_stopping:
            raise RequestRefused(LabResult.NOT_HELD, f"the robot '{robot}' is being stopped")
        if hold is not None and hold.is_alive:
            if hold.holder.holder != sender:
                code = self._unless_lost(sender, LabResult.HELD)
                raise RequestRefused(code, f"the robot '{robot}' is held by {display_name(hold.holder)}")
            return
        if has_to_hold:
            code = self._unless_lost(sender, Result.INCORRECT_STATE)
            raise RequestRefused(code, f"the robot '{robot}' is not held: acquire it first")
        if (lease := self.lease_of(robot)) is not None:
            raise RequestRefused(LabResult.HELD, f"the robot '{robot}' is {_describe_lease(lease)}")

    def check_all(self, sender: str) -> None:
        """Check that a client may change the whole node.

        Raises:
            RequestRefused: Another client holds a robot, or the sender holds some robots only.
        """
        for hold in self._live():
            if hold.holder.holder != sender:
                raise RequestRefused(self._unless_lost(sender, LabResult.HELD), _held(hold, hold.holder.robots))
        own = self._holds.get(sender)
        if own is not None and own.holder.robots:
            raise RequestRefused(
                LabResult.HELD,
                f"the request is about all robots, but only {name_list(own.holder.robots)} are held",
            )

    def _unless_lost(self, sender: str, code: int) -> int:
        """Return the result code of a refusal: `code`, or NOT_HELD if the sender lost all that it held."""
        hold = self._holds.get(sender)
        return LabResult.NOT_HELD if sender and (hold is None or not hold.is_alive) else code

    # ------------------------------------------------------------ heartbeats

    def overdue(self) -> list[Hold]:
        """Return the live holds without a recent heartbeat."""
        return [hold for hold in self._live() if self._left(hold) <= 0.0]

    def within(self) -> float | None:
        """Return the time until a heartbeat is overdue [s]; None if no live holder sends some."""
        soonest = min((self._left(hold) for hold in self._live()), default=math.inf)
        return None if soonest == math.inf else max(0.0, soonest)

    def _left(self, hold: Hold) -> float:
        if hold.holder.gives_signs:
            return hold.last + HOLD_DEADLINE - self._clock()
        return math.inf if hold.is_seen else hold.last + UNSEEN - self._clock()

    def token_changed(self, token: str, *, is_alive: bool) -> Hold | None:
        """Record that the token of a client appeared or disappeared; returns the live hold of a lost client.

        The token may appear before the client acquires robots. It ends with the client's `public_holder_name`.
        """
        client = token.rpartition("/")[2]
        hold = next((hold for name, hold in self._holds.items() if public_holder_name(name) == client), None)
        if not is_alive:
            self._present.discard(client)
            return hold if hold is not None and hold.is_alive else None
        self._present.add(client)
        if hold is not None:
            hold.is_seen = True
        return None

    def lose_connection(self) -> None:
        """Mark all holders as unseen, since the connection of this node was lost.

        Their tokens have to appear again. Clients need a moment to reconnect, too, so their robots are kept.
        """
        now = self._clock()
        self._present.clear()
        for hold in self._holds.values():
            hold.is_seen = False
            hold.kept_until = HOLD_PATIENCE + (hold.last if hold.holder.gives_signs else now)
            if not hold.holder.gives_signs:
                hold.last = now

    # ------------------------------------------------------------ manual leases

    def lease(self, request: LeaseRobots) -> None:
        """Lease robots to a person.

        Raises:
            RequestRefused: The robots are not free, or the request is invalid.
        """
        check_id(request.lease)
        self._check_known(request.robots)
        if not request.robots:
            raise RequestRefused(Result.OPERATION_FAILED, "missing robots to lease: name at least one")
        if not 0.0 < request.duration <= LONGEST_LEASE:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"invalid duration {request.duration:g} s of a lease; expected more than 0 s and at most "
                f"{LONGEST_LEASE:g} s",
            )
        self._remove_expired()
        if len(self._leases) >= MAX_LEASES:
            raise RequestRefused(Result.OPERATION_FAILED, f"too many leases: {MAX_LEASES}, which is the limit")
        for conflict in self._conflicts(Holder(holder=request.lease, robots=request.robots, lease=request.lease)):
            raise RequestRefused(LabResult.HELD, conflict)
        until = time.time() + request.duration
        lease = Lease(lease=request.lease, purpose=request.purpose[:MAX_TEXT], until=until)
        self._leases[request.lease] = frozenset(request.robots), lease

    def end_lease(self, request: ReleaseLease) -> None:
        """End a manual lease.

        Raises:
            RequestRefused: The lease is unknown.
        """
        self._remove_expired()
        found = [
            name
            for name, (robots, _) in self._leases.items()
            if (request.lease and name == request.lease) or (request.robot and request.robot in robots)
        ]
        if not found:
            what = f"lease '{request.lease}'" if request.lease else f"lease of '{request.robot}'"
            raise RequestRefused(Result.NOT_FOUND, f"unknown {what}")
        for name in found:
            del self._leases[name]

    def lease_of(self, robot: str) -> Lease | None:
        """Return the manual lease of a robot."""
        self._remove_expired()
        return next((lease for robots, lease in self._leases.values() if robot in robots), None)

    def waiting_for(self, robot: str) -> tuple[str, ...]:
        """Return the purposes of the clients that wait for a robot, the next one first."""
        self._remove_expired()
        return tuple(
            display_name(entry.holder)
            for entry in self._in_order()
            if entry.holder.holder not in self._holds and _overlap(entry.holder.robots, (robot,))
        )

    # ------------------------------------------------------------ wait queue

    def _enqueue(self, request: Holder) -> None:
        entry = self._queue.get(request.holder)
        if entry is not None:
            self._queue[request.holder] = replace(entry, holder=request, requested=self._clock())
        elif len(self._queue) < MAX_WAITING:
            self._queue[request.holder] = _QueueEntry(request, next(self._numbers), self._clock())

    def _in_order(self) -> list[_QueueEntry]:
        return sorted(self._queue.values(), key=lambda entry: entry.rank)

    def _conflicts(self, request: Holder) -> Iterator[str]:
        """Yield the reasons why a client cannot acquire its robots: holders, leases, or earlier clients."""
        wanted = request.robots
        for hold in self._holds.values():
            if not _overlap(hold.holder.robots, wanted):
                continue
            common = _with_verb(_common(hold.holder.robots, wanted))
            is_other = hold.holder.holder != request.holder
            if hold.is_alive and is_other:
                yield f"{_held(hold, wanted)}: wait for its end"
            elif is_other and hold.kept_until > self._clock():
                owner = display_name(hold.holder)
                yield f"{common} kept for {owner}, whose connection was lost: try again in a moment"
            elif hold.is_stopping:
                yield f"{common} being stopped: try again"
        for name, (robots, lease) in self._leases.items():
            if name != request.lease and _overlap(tuple(robots), wanted):
                yield f"{_with_verb(_common(tuple(sorted(robots)), wanted))} {_describe_lease(lease)}"
        own = self._queue.get(request.holder) or _QueueEntry(request, next(self._numbers), self._clock())
        for entry in self._in_order():
            if entry.rank < own.rank and _overlap(entry.holder.robots, wanted):
                common = _names(_common(entry.holder.robots, wanted))
                yield f"{display_name(entry.holder)} waits for {common} already, and comes first"

    def _remove_expired(self) -> None:
        """Remove expired leases, and queue entries without recent requests."""
        now, today = self._clock(), time.time()
        self._leases = {name: entry for name, entry in self._leases.items() if entry[1].until > today}
        self._queue = {
            name: entry for name, entry in self._queue.items() if now - entry.requested < QUEUE_PATIENCE
        }

    def _check_known(self, robots: Iterable[str]) -> None:
        known = tuple(self._robots())
        for robot in robots:
            if robot not in known:
                raise RequestRefused(Result.NOT_FOUND, f"unknown robot '{robot}' (robots: {name_list(known)})")


def expire(hold: Hold, cause: str) -> str:
    """Mark a client as lost; returns the reason why its robots are stopped, as text."""
    hold.is_alive = False
    reason = f"the robots were stopped, {display_name(hold.holder)}: {cause}"
    log.warning("%s", reason)
    return reason


def describe_silence(hold: Hold) -> str:
    """Describe why the robots of an overdue holder are stopped."""
    return f"no heartbeat for {HOLD_DEADLINE:g} s" if hold.holder.gives_signs else f"not seen for {UNSEEN:g} s"


def display_name(holder: Holder) -> str:
    """Return the name of a client in messages."""
    return holder.purpose[:MAX_TEXT] or f"the client '{public_holder_name(holder.holder)}'"


def _key_of(holder: Holder) -> HolderKey:
    return HolderKey(holder.exchange, ReplayWindow(holder.number))


def _overlap(some: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Whether two selections of robots overlap; an empty one selects the whole node."""
    return not some or not others or bool({*some} & {*others})


def _common(some: tuple[str, ...], others: tuple[str, ...]) -> tuple[str, ...]:
    """Return the robots in both selections; empty for the whole node."""
    return tuple(robot for robot in some if robot in others) if some and others else some or others


def _names(robots: tuple[str, ...]) -> str:
    return " and ".join(f"'{robot}'" for robot in robots) or "the robots"


def _with_verb(robots: tuple[str, ...]) -> str:
    """Return the names of robots with `is` or `are`."""
    return f"{_names(robots)} {'is' if len(robots) == 1 else 'are'}"


def _held(hold: Hold, wanted: tuple[str, ...]) -> str:
    return f"{_with_verb(_common(hold.holder.robots, wanted))} held by {display_name(hold.holder)}"


def _describe_lease(lease: Lease) -> str:
    until = datetime.fromtimestamp(lease.until).astimezone().strftime("%d %b %H:%M:%S")
    return f"leased until {until}" + (f" ({lease.purpose})" if lease.purpose else "")
