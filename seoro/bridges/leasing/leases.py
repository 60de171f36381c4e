"""Who has which robots of a node: runs that hold them, people who have leased them, and those who wait.

A client takes all that it wants of a node at once, or nothing. One that wants robots of several nodes gives back
what it has got when it does not get the rest: nobody waits with something in hand, so nobody waits in a circle.
Those who wait have a place in line, by priority and then by when they came, which they keep by asking again. No
one gets a robot that somebody before them in line wants, so that nobody starves.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from itertools import count

from seoro.bridges.wire.holding import HOLD_DEADLINE, HOLD_PATIENCE, QUEUE_PATIENCE, Holder
from seoro.bridges.wire.keys import shown_holder
from seoro.bridges.wire.lab import LONGEST_LEASE, MAX_TEXT, Lease, LeaseRobots, ReleaseLease
from seoro.bridges.wire.refusal import RequestRefused, check_id, listed
from seoro.bridges.wire.results import LabResult, Result
from seoro.keys.window import HolderKey, ReplayWindow

MOST_WAITING = 1000  # clients in line
MOST_LEASES = 1000  # by hand
GONE = "its process has died, or the connection to it is lost"  # why robots are stopped
UNSEEN = 5.0  # [s] that the token of a client that gives no signs of life may take to be seen

log = logging.getLogger(__name__)


@dataclass
class Hold:
    """Robots that a client holds.

    Attributes:
        holder: The client, and what it has asked for.
        last: When it gave a sign of life, by the machine's clock [s].
        is_alive: Whether it is not overdue. A client that was, and is back before another has come, is again.
        is_stopping: Whether its robots are being stopped.
        is_seen: Whether its token has been seen.
        began: When it took them, by the clock of the node [s].
        kept_until: When others may have them although it is overdue, by the machine's clock [s].
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
        """Authenticates the requests of the client."""
        return _key_of(self.holder)

    def has(self, robot: str) -> bool:
        """Whether a robot is one of those."""
        return not self.holder.robots or robot in self.holder.robots


@dataclass(frozen=True)
class _Place:
    """A place in line: whose, the how many-th to come, and when it was last asked for [s]."""

    holder: Holder
    number: int
    asked: float

    @cached_property
    def key(self) -> HolderKey:
        """Authenticates the request of the client to give the place up."""
        return _key_of(self.holder)


@dataclass(frozen=True)
class _Lease:
    """A lease by hand."""

    robots: frozenset[str]
    purpose: str
    until: float  # [s since 1970]


class Leases:
    """Who has the robots of a node.

    Args:
        robots: Gives the names of those that there are.
        clock: The machine's clock, which nobody sets [s].
    """

    def __init__(self, robots: Callable[[], Iterable[str]], clock: Callable[[], float] = time.monotonic) -> None:
        self._robots = robots
        self._clock = clock
        self._holds: dict[str, Hold] = {}
        self._line: dict[str, _Place] = {}
        self._leases: dict[str, _Lease] = {}
        self._numbers = count()
        self._present: set[str] = set()  # clients whose tokens are there, as they are shown

    # ------------------------------------------------------------ runs

    def take(self, asked: Holder, now: float) -> tuple[Hold, ...]:
        """Let a client have robots.

        Args:
            asked: The client, and which it wants.
            now: By the clock of the node [s].

        Returns:
            The holds of clients that gave no sign of life any more, in whose place this comes.

        Raises:
            RequestRefused: It cannot have all that it wants; the message says why, and who has them.
        """
        check_id(asked.holder)
        self._check_key(asked)
        self._check_known(asked.robots)
        self._tidy()
        hindrance = next(self._hindrances(asked), None)
        if asked.waits:
            self._ask_again(asked)
        else:
            self._line.pop(asked.holder, None)
        if hindrance is not None:
            raise RequestRefused(LabResult.HELD, hindrance)
        gone = tuple(hold for hold in self._holds.values() if _overlap(hold.holder.robots, asked.robots))
        for hold in gone:
            del self._holds[hold.holder.holder]
        is_seen = shown_holder(asked.holder) in self._present
        self._holds[asked.holder] = Hold(asked, self._clock(), is_seen=is_seen, began=now)
        return tuple(hold for hold in gone if hold.holder.holder != asked.holder)

    def _check_key(self, asked: Holder) -> None:
        hold = self._holds.get(asked.holder)
        if hold is not None and hold.is_alive and hold.holder.exchange != asked.exchange:
            raise RequestRefused(LabResult.HELD, f"another client holds robots as '{shown_holder(asked.holder)}'")

    def key_of(self, holder: str) -> HolderKey | None:
        """Key of a client that holds robots, or waits for some; None for all others."""
        owner = self._holds.get(holder) or self._line.get(holder)
        return None if owner is None else owner.key

    def renew(self, holder: str) -> Hold:
        """Note a sign of life.

        Raises:
            RequestRefused: The client does not hold anything.
        """
        hold = self._holds.get(holder)
        if hold is None:
            others = sorted({called(other.holder) for other in self._holds.values()})
            now = f"{' and '.join(others)} has them" if others else "this node was started anew"
            raise RequestRefused(LabResult.NOT_HELD, f"the robots are not held by this run any more: {now}")
        hold.last, hold.is_alive = self._clock(), True
        return hold

    def release(self, holder: str, *, waits: bool = False) -> None:
        """End a hold; the client keeps its place in line if it `waits`."""
        self._holds.pop(holder, None)
        if not waits:
            self._line.pop(holder, None)

    def hold_of(self, holder: str) -> Hold | None:
        """What a client holds, alive or not."""
        return self._holds.get(holder)

    def holder_of(self, robot: str) -> Hold | None:
        """Who holds a robot and is alive."""
        return next((hold for hold in self._holds.values() if hold.is_alive and hold.has(robot)), None)

    @property
    def holder_of_all(self) -> Hold | None:
        """Who holds the whole node and is alive."""
        return next((hold for hold in self._holds.values() if hold.is_alive and not hold.holder.robots), None)

    @property
    def is_anything_held(self) -> bool:
        """Whether somebody holds something and is alive."""
        return any(hold.is_alive for hold in self._holds.values())

    def robots_of(self, hold: Hold) -> tuple[str, ...]:
        """The robots that a client holds."""
        return tuple(robot for robot in self._robots() if hold.has(robot))

    def check(self, sender: str, robot: str, *, has_to_hold: bool) -> None:
        """Refuse what is about a robot to those who may not move it.

        Args:
            sender: Who asks; empty if it does not say.
            robot: The robot.
            has_to_hold: Whether robots that nobody has may not be moved either.

        Raises:
            RequestRefused: Another has it, or nobody, and somebody has to.
        """
        hold = next((hold for hold in self._holds.values() if hold.has(robot)), None)
        if hold is not None and hold.is_stopping:
            raise RequestRefused(LabResult.NOT_HELD, f"the robot '{robot}' is being stopped")
        if hold is not None and hold.is_alive:
            if hold.holder.holder != sender:
                code = self._unless_lost(sender, LabResult.HELD)
                raise RequestRefused(code, f"the robot '{robot}' is held by {called(hold.holder)}")
            return
        if has_to_hold:
            code = self._unless_lost(sender, Result.INCORRECT_STATE)
            raise RequestRefused(code, f"nobody holds the robot '{robot}': take it first")
        for lease in self._present_leases():
            if robot in lease.robots:
                raise RequestRefused(LabResult.HELD, f"the robot '{robot}' is {_said(lease)}")

    def check_all(self, sender: str) -> None:
        """Refuse what changes all that a node has to those who do not have all of it.

        Raises:
            RequestRefused: Others have something of it.
        """
        for hold in self._holds.values():
            if hold.is_alive and hold.holder.holder != sender:
                raise RequestRefused(self._unless_lost(sender, LabResult.HELD), _held(hold, hold.holder.robots))
        hold_of_sender = self._holds.get(sender)
        if hold_of_sender is not None and hold_of_sender.holder.robots:
            raise RequestRefused(
                LabResult.HELD,
                f"this is about all robots, and only {listed(hold_of_sender.holder.robots)} are held",
            )

    def _unless_lost(self, sender: str, code: int) -> int:
        """Result code of a refusal: `code`, or NOT_HELD if the sender lost all that it held."""
        hold = self._holds.get(sender)
        return LabResult.NOT_HELD if sender and (hold is None or not hold.is_alive) else code

    # ------------------------------------------------------------ signs of life

    def overdue(self) -> list[Hold]:
        """Those whose clients are alive, and ought to have given a sign of life by now."""
        return [hold for hold in self._holds.values() if hold.is_alive and self._left(hold) <= 0.0]

    def within(self) -> float | None:
        """How long it takes until one is overdue [s]; None if none can be."""
        left = [self._left(hold) for hold in self._holds.values() if hold.is_alive]
        soonest = min((each for each in left if each != float("inf")), default=None)
        return None if soonest is None else max(0.0, soonest)

    def _left(self, hold: Hold) -> float:
        if hold.holder.gives_signs:
            return hold.last + HOLD_DEADLINE - self._clock()
        return float("inf") if hold.is_seen else hold.last + UNSEEN - self._clock()

    def token_changed(self, token: str, *, is_alive: bool) -> Hold | None:
        """The token of a client has come, or is gone; returns what it holds if it is gone and was alive."""
        shown = token.rpartition("/")[2]
        if not is_alive:
            return self.lose(shown)
        self.see(shown)
        return None

    def see(self, shown: str) -> None:
        """The token of a client is there, which may be before it takes anything; see `shown_holder`."""
        self._present.add(shown)
        hold = self._shown(shown)
        if hold is not None:
            hold.is_seen = True

    def lose(self, shown: str) -> Hold | None:
        """The token of a client is gone; what it holds, if it was alive."""
        self._present.discard(shown)
        hold = self._shown(shown)
        return hold if hold is not None and hold.is_alive else None

    def _shown(self, shown: str) -> Hold | None:
        return next((hold for name, hold in self._holds.items() if shown_holder(name) == shown), None)

    def lose_sight(self) -> None:
        """No token is seen any more, which says nothing of those who have them: they have to be seen again.

        The connection of this node was lost. Clients that hold robots, or did when it was, need a moment to come
        back, too: the robots are kept for them.
        """
        now = self._clock()
        self._present.clear()
        for hold in self._holds.values():
            hold.is_seen = False
            hold.kept_until = HOLD_PATIENCE + (hold.last if hold.holder.gives_signs else now)
            if not hold.holder.gives_signs:
                hold.last = now

    # ------------------------------------------------------------ leases by hand

    def lease(self, asked: LeaseRobots) -> None:
        """Keep robots for somebody.

        Raises:
            RequestRefused: Others have them, or what is asked for cannot be.
        """
        check_id(asked.lease)
        self._check_known(asked.robots)
        if not asked.robots:
            raise RequestRefused(Result.OPERATION_FAILED, "it is not said which robots are to be leased")
        if not 0.0 < asked.duration <= LONGEST_LEASE:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"a lease lasts more than 0 s and {LONGEST_LEASE:g} s at most, not {asked.duration:g} s",
            )
        self._tidy()
        if len(self._leases) >= MOST_LEASES:
            raise RequestRefused(Result.OPERATION_FAILED, f"there are {MOST_LEASES} leases already")
        wanted = Holder(holder=asked.lease, robots=asked.robots, lease=asked.lease)
        for hindrance in self._hindrances(wanted):
            raise RequestRefused(LabResult.HELD, hindrance)
        until = time.time() + asked.duration
        self._leases[asked.lease] = _Lease(frozenset(asked.robots), asked.purpose[:MAX_TEXT], until)

    def end_lease(self, asked: ReleaseLease) -> None:
        """End a lease by hand.

        Raises:
            RequestRefused: There is none.
        """
        self._tidy()
        found = [
            lease
            for lease, what in self._leases.items()
            if (asked.lease and lease == asked.lease) or (asked.robot and asked.robot in what.robots)
        ]
        if not found:
            what = f"lease '{asked.lease}'" if asked.lease else f"lease of '{asked.robot}'"
            raise RequestRefused(Result.NOT_FOUND, f"there is no {what}")
        for lease in found:
            del self._leases[lease]

    def lease_of(self, robot: str) -> Lease | None:
        """The lease by hand that a robot is under."""
        self._tidy()
        for lease, what in self._leases.items():
            if robot in what.robots:
                return Lease(lease=lease, purpose=what.purpose, until=what.until)
        return None

    def waiting_for(self, robot: str) -> tuple[str, ...]:
        """What those are for who wait for a robot, the next one first."""
        self._tidy()
        places = sorted(self._line.values(), key=_rank)
        return tuple(
            called(place.holder)
            for place in places
            if place.holder.holder not in self._holds and (not place.holder.robots or robot in place.holder.robots)
        )

    # ------------------------------------------------------------ in line

    def _ask_again(self, asked: Holder) -> None:
        place = self._line.get(asked.holder)
        if place is not None:
            self._line[asked.holder] = replace(place, holder=asked, asked=self._clock())
        elif len(self._line) < MOST_WAITING:
            self._line[asked.holder] = _Place(asked, next(self._numbers), self._clock())

    def _hindrances(self, asked: Holder) -> Iterator[str]:
        """Why a client cannot have what it wants: who has it, or comes first."""
        for hold in self._holds.values():
            if hold.is_alive and hold.holder.holder != asked.holder and _overlap(hold.holder.robots, asked.robots):
                yield f"{_held(hold, asked.robots)}: wait for its end"
            elif hold.holder.holder != asked.holder and self._is_kept(hold, asked):
                common = _named(_common(hold.holder.robots, asked.robots))
                yield f"{common} kept for {called(hold.holder)}, whose connection was lost: try again in a moment"
            elif hold.is_stopping and _overlap(hold.holder.robots, asked.robots):
                yield f"{_named(_common(hold.holder.robots, asked.robots))} being stopped: try again"
        for lease, what in self._leases.items():
            if lease != asked.lease and _overlap(tuple(what.robots), asked.robots):
                yield f"{_named(_common(tuple(sorted(what.robots)), asked.robots))} {_said(what)}"
        mine = self._line.get(asked.holder)
        rank = _rank(mine or _Place(asked, next(self._numbers), self._clock()))
        for place in sorted(self._line.values(), key=_rank):
            if _rank(place) < rank and _overlap(place.holder.robots, asked.robots):
                common = _names(_common(place.holder.robots, asked.robots))
                yield f"{called(place.holder)} waits for {common} already, and comes first"

    def _is_kept(self, hold: Hold, asked: Holder) -> bool:
        """Whether what a client wants is kept for one that is overdue."""
        return hold.kept_until > self._clock() and _overlap(hold.holder.robots, asked.robots)

    def _present_leases(self) -> Iterable[_Lease]:
        self._tidy()
        return self._leases.values()

    def _tidy(self) -> None:
        """Forget leases that are over, and places in line that nobody asks for any more."""
        now, today = self._clock(), time.time()
        self._leases = {lease: what for lease, what in self._leases.items() if what.until > today}
        self._line = {holder: place for holder, place in self._line.items() if now - place.asked < QUEUE_PATIENCE}

    def _check_known(self, robots: Iterable[str]) -> None:
        known = tuple(self._robots())
        for robot in robots:
            if robot not in known:
                raise RequestRefused(Result.NOT_FOUND, f"there is no robot '{robot}': there are {listed(known)}")


def lapse(hold: Hold, why: str) -> str:
    """Take a client for gone; returns for what reason its robots are stopped, in words."""
    hold.is_alive = False
    reason = f"the robots were stopped, {called(hold.holder)}: {why}"
    log.warning("%s", reason)
    return reason


def silence(hold: Hold) -> str:
    """Why robots are stopped whose holder is overdue, in words."""
    return f"no sign of life for {HOLD_DEADLINE:g} s" if hold.holder.gives_signs else f"not seen for {UNSEEN:g} s"


def called(holder: Holder) -> str:
    """What messages call a client."""
    return holder.purpose[:MAX_TEXT] or f"the client '{shown_holder(holder.holder)}'"


def _key_of(holder: Holder) -> HolderKey:
    return HolderKey(holder.exchange, ReplayWindow(holder.number))


def _rank(place: _Place) -> tuple[int, int]:
    return -place.holder.priority, place.number


def _overlap(some: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Whether two choices of robots have one in common; an empty one is all, with the world around them."""
    return not some or not others or bool({*some} & {*others})


def _common(some: tuple[str, ...], others: tuple[str, ...]) -> tuple[str, ...]:
    """The robots that two choices have in common; none for all."""
    return tuple(robot for robot in some if robot in others) if some and others else some or others


def _names(robots: Iterable[str]) -> str:
    names = [f"'{robot}'" for robot in robots]
    return " and ".join(names) or "the robots"


def _named(robots: Iterable[str]) -> str:
    """Robots, as the subject of a sentence, with the verb."""
    names = tuple(robots)
    return f"{_names(names)} {'is' if len(names) == 1 else 'are'}"


def _held(hold: Hold, asked: tuple[str, ...]) -> str:
    return f"{_named(_common(hold.holder.robots, asked))} held by {called(hold.holder)}"


def _said(lease: _Lease) -> str:
    until = datetime.fromtimestamp(lease.until).astimezone().strftime("%d %b %H:%M:%S")
    return f"leased until {until}" + (f" ({lease.purpose})" if lease.purpose else "")
