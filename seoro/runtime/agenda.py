"""What may run next: instants, rounds, and the flows of control that step in them.

Everything happens in instants, at one value of `now`. An instant is a sequence of rounds. In a round every
flow that may go on takes one step, one flow at a time in the order of invocation paths; its effects are put
down here and take hold between rounds, in this order: changes of variables, then what ends behaviors (failures,
`emit end`, a member of `one_of` that decides), then what wakes waiting flows. So no flow sees what another did in
the same round, and the textual order of members changes nothing. When no flow can go on the instant has settled,
and only then may time move. Before that, limits act that are due: what ends by itself in that instant is in time.

A flow is a member of a `parallel` or `one_of`, or the run itself, and is one task. It counts as busy from
the moment it is freed until it parks here again; when the last busy flow parks, the next is freed in that very
call. A flow that is alone therefore frees itself and goes on without a switch.

Actions may await things of the outside world. Their flow then is `outside`: rounds go on without it, and
on clocks of which the runtime is the master time waits for it. A request to a backend is shorter than that:
on such clocks even the round waits for the answer, so that answers arrive in a fixed order.

Behaviors are ended by scope: the agenda marks every flow in the scope, and delivers a cancellation to
one after another, the last started first, as each has finished its clean-up.
"""

from __future__ import annotations

import asyncio
import heapq
from collections import deque
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, TypeAlias

import anyio

from seoro.runtime.past import Past

if TYPE_CHECKING:
    from seoro.runtime.contracts import Clock
    from seoro.runtime.verdict import Outcome

StepOrder: TypeAlias = Callable[[tuple[int, ...]], Any]

TIME_DIGITS = 9  # times are kept to the nanosecond, so that 0.1 + 0.2 is due with 0.3


@dataclass(eq=False)
class Scope:
    """A behavior that can be ended as a whole: the flow it runs in and everything forked from there."""

    flow: Flow
    depth: int
    outcome: Outcome | None = None  # set when it is ended
    has_end: bool = False  # whether it has an end of its own, whatever runs in it

    @property
    def around(self) -> Iterator[Scope]:
        """The scopes that it lies in, from the nearest."""
        scope: Scope | None = self
        while scope is not None:
            yield from reversed(scope.flow.scopes[: scope.depth])
            scope = scope.flow.parent
            if scope is not None:
                yield scope


@dataclass(eq=False)
class Flow:
    """A flow of control.

    Args:
        path: Position in the tree of invocations; flows are stepped in its order.
        parent: The scope from which it was forked; None for the run itself.
        started: Its place in the order of starts: the round and the path; the order of steps does not matter.
    """

    path: tuple[int, ...]
    parent: Scope | None
    started: tuple[int, tuple[int, ...]]
    task: asyncio.Task[Any] | None = None  # once it has begun
    on_end: Callable[[Flow], None] | None = None
    guard: Callable[[Flow], None] | None = None  # called when its next wait is over, between rounds
    scopes: list[Scope] = field(default_factory=list)
    outcome: Outcome | None = None
    alive: bool = True
    ended: Scope | None = None  # the outermost scope that was ended and has not been left yet
    fresh: bool = False  # freed for the first time: its first step is this one
    delivered: bool = False  # whether the flow has been told so
    told: bool = False  # whether the cancellation that it sees next comes from the agenda
    asking: bool = False
    parked: asyncio.Future[Any] | None = None  # what it waits on here
    foreign: asyncio.Future[Any] | None = None  # what it waits on outside
    outside: bool = False
    open_ended: bool = False  # whether what it carries out has no end of its own
    past: Past = field(default_factory=Past)

    def within(self, scope: Scope) -> bool:
        """Whether the flow was forked, at any remove, from a scope that belongs to the given one."""
        parent = self.parent
        while parent is not None:
            if parent.flow is scope.flow:
                return parent.depth >= scope.depth
            parent = parent.flow.parent
        return False


@dataclass(eq=False)
class Waiter:
    """A flow that waits for something that is fired, once, with a value."""

    flow: Flow
    fired: bool = False
    value: Any = None
    over: bool = False  # whether its flow waits no more


@dataclass(eq=False)
class Timer:
    """What happens at a time, before the first round of that instant, unless it is over before."""

    act: Callable[[], None]
    over: bool = False


@dataclass(eq=False)
class Limit:
    """What a scope comes to at a time, unless it is over before; it acts when that instant has otherwise settled.

    Args:
        scope: Of what it limits.
        act: Called between rounds.
    """

    scope: Scope
    act: Callable[[], None]
    over: bool = False


class Agenda:
    """The order of everything in one run.

    Args:
        clock: The run's clock.
        stuck: Called when nothing can happen any more.
        clock_failed: Called when the clock raises; time stands still from then on.
        step_order: Gives, for the path of a flow, the key by which the steps of a round are sorted; by default the
            path itself. Since no flow sees an effect of its own round, any order gives the same run but for the
            order of records, which is what tests put to the proof.
    """

    def __init__(
        self,
        clock: Clock,
        stuck: Callable[[], None],
        clock_failed: Callable[[Exception], None],
        step_order: StepOrder | None = None,
    ) -> None:
        self.now = 0.0
        self.instant = 0
        self._clock = clock
        self._stuck = stuck
        self._clock_failed = clock_failed
        self._step_order = step_order or _by_path
        self._broken = False  # whether the clock has failed
        self._has_been_stuck = False
        self._busy = 0
        self._outside = 0
        self._asking = 0
        self._expected = 0  # answers that a backend will give as time goes on
        self._open = False  # whether the instant has not settled
        self._finished = False
        self._round = 0
        self._flows: dict[Flow, None] = {}  # alive
        self._ready: list[tuple[Any, Callable[[], None]]] = []
        self._current: deque[Callable[[], None]] = deque()
        self._writes: list[tuple[tuple[int, ...], Callable[[], None]]] = []
        self._checks: list[tuple[tuple[int, ...], Callable[[], None]]] = []
        self._ends: list[tuple[tuple[int, ...], Callable[[], None]]] = []
        self._emissions: list[tuple[tuple[str, str], Callable[[], None]]] = []
        self._closings: list[Callable[[], None]] = []
        self._fired: list[Waiter] = []
        self._timers: list[tuple[float, int, Waiter | Timer | Limit]] = []
        self._due_limits: list[Limit] = []
        self._at_settling: list[Callable[[], None]] = []
        self._numbers = count()
        self._settled = anyio.Event()
        self._interrupt = anyio.Event()

    # -------------------------------------------------------- flows

    def fork(self, path: tuple[int, ...], parent: Scope | None) -> Flow:
        """A new flow, which may take its first step in the next round. Run its task with `run`."""
        flow = Flow(path, parent, (self._round, path))
        flow.scopes.append(Scope(flow, 0))
        if parent is not None:
            flow.past = parent.flow.past.fork()
        self._flows[flow] = None
        self._free_next(flow)
        self._poke()
        return flow

    async def first_step(self, flow: Flow) -> None:
        """Wait for the first step of a forked flow; the first thing its task does."""
        assert flow.parked is not None
        flow.task = asyncio.current_task()
        try:
            await flow.parked
        except asyncio.CancelledError:
            flow.told = False
            raise
        finally:
            flow.parked = None
        flow.fresh = True

    def flow_ended(self, flow: Flow, outcome: Outcome) -> None:
        """The last thing a flow's task does."""
        flow.alive = False
        flow.outcome = outcome
        del self._flows[flow]
        if flow.on_end is not None:
            self._ends.append((flow.path, partial(flow.on_end, flow)))
        self._release()

    async def step(self, flow: Flow) -> None:
        """Wait for the next round, or take the first step of a flow in the round it was freed in."""
        if flow.fresh:
            flow.fresh = False
            return
        self._free_next(flow)
        await self._park(flow)

    async def wait(self, waiter: Waiter) -> Any:
        """Wait until the waiter is fired; returns the value it was fired with."""
        waiter.flow.parked = asyncio.get_running_loop().create_future()
        try:
            return await self._park(waiter.flow)
        finally:
            waiter.over = True

    def _free_next(self, flow: Flow) -> None:
        """Park a flow that is to be freed in the next round."""
        future = flow.parked = asyncio.get_running_loop().create_future()
        self._ready.append(((1, self._step_order(flow.path)), partial(self._free, flow, future, None)))

    async def _park(self, flow: Flow) -> Any:
        future = flow.parked
        assert future is not None
        self._release()
        try:
            # A flow that was freed by its own parking goes on without a switch.
            return future.result() if future.done() else await future
        except asyncio.CancelledError:
            flow.told = False
            raise
        finally:
            flow.parked = None

    def _free(self, flow: Flow, future: asyncio.Future[Any], value: Any) -> None:
        """Let a parked flow go on, unless it was ended or went elsewhere in the meantime."""
        if future.done() or (flow.ended is not None and not flow.delivered):
            return
        self._busy += 1
        future.set_result(value)

    def _release(self) -> None:
        self._busy -= 1
        self._advance()

    # -------------------------------------------------------- waking

    def fire(self, waiter: Waiter, value: Any = None) -> None:
        """Wake a waiting flow between this round and the next."""
        if not (waiter.fired or waiter.over):
            waiter.fired, waiter.value = True, value
            self._fired.append(waiter)
            self._poke()

    def fire_at(self, time: float, waiter: Waiter) -> None:
        """Fire a waiter in the first instant at or after a time."""
        heapq.heappush(self._timers, (round(time, TIME_DIGITS), next(self._numbers), waiter))

    def act_at(self, time: float, timer: Timer) -> None:
        """Let a timer act in the first instant at or after a time."""
        heapq.heappush(self._timers, (round(time, TIME_DIGITS), next(self._numbers), timer))

    def react(self, path: tuple[int, ...], step: Callable[[], None]) -> None:
        """Take a step in the next round that belongs to no flow, and awaits nothing."""
        self._ready.append(((1, self._step_order(path)), step))
        self._poke()

    def check(self, path: tuple[int, ...], effect: Callable[[], None]) -> None:
        """Put down what depends on variables; it takes hold once all of their changes have, in order of paths."""
        self._checks.append((path, effect))

    def limit_at(self, time: float, limit: Limit) -> None:
        """Let a limit act in the first instant at or after a time."""
        heapq.heappush(self._timers, (round(time, TIME_DIGITS), next(self._numbers), limit))

    def when_settled(self, act: Callable[[], None]) -> None:
        """Let something act when the instant has otherwise settled, limits and all; flows may be outside still."""
        self._at_settling.append(act)

    def write(self, path: tuple[int, ...], effect: Callable[[], None]) -> None:
        """Put down a change of a variable; it takes hold between rounds, before all else, in order of paths."""
        self._writes.append((path, effect))
        self._poke()

    def after_round(self, path: tuple[int, ...], effect: Callable[[], None]) -> None:
        """Put down an effect that ends behaviors; it takes hold between rounds, in the order of paths."""
        self._ends.append((path, effect))
        self._poke()

    def emit(self, occurrence: tuple[str, str], effect: Callable[[], None]) -> None:
        """Put down an emission; it takes hold between rounds, after what ends behaviors.

        Args:
            occurrence: The event and its arguments; those of one round take hold in the order of that.
            effect: Called then.
        """
        self._emissions.append((occurrence, effect))

    def close(self, effect: Callable[[], None]) -> None:
        """Put down the end of what hears emissions; it takes hold after all of the same round."""
        self._closings.append(effect)

    @contextmanager
    def expecting(self) -> Generator[None]:
        """While a backend is going to report something as time goes on, time may go on."""
        self._expected += 1
        try:
            yield
        finally:
            self._expected -= 1

    # -------------------------------------------------------- ending

    @contextmanager
    def scope(self, flow: Flow) -> Generator[Scope]:
        """A scope in a flow; leave it by the end of the block, also when it was ended."""
        scope = Scope(flow, len(flow.scopes))
        flow.scopes.append(scope)
        try:
            yield scope
        finally:
            flow.scopes.pop()

    def flows_in(self, scope: Scope) -> list[Flow]:
        """The flows that were forked in a scope and have not ended, in the order of their starts."""
        return sorted((flow for flow in self._flows if flow.within(scope)), key=lambda flow: flow.started)

    def left(self, scope: Scope) -> bool:
        """Whether a cancellation that arrives here was meant for this scope; if so, the flow goes on."""
        flow = scope.flow
        if flow.ended is not scope:
            return False
        flow.ended, flow.delivered = None, False
        return True

    def end(self, scope: Scope, outcome: Outcome) -> None:
        """End a scope, unless it has been left. To be called between rounds, as an effect."""
        if scope not in scope.flow.scopes:
            return
        if scope.outcome is None:
            scope.outcome = outcome
        flows = self.flows_in(scope)
        for flow in flows:
            self._doom(flow, flow.scopes[0])
        self._doom(scope.flow, scope)
        self._deliver_in_turn([scope.flow, *flows])

    def end_flow(self, flow: Flow, outcome: Outcome) -> None:
        """End a whole flow. To be called between rounds, as an effect."""
        if flow.alive:
            self.end(flow.scopes[0], outcome)

    @staticmethod
    def is_ended(scope: Scope) -> bool:
        """Whether a scope was ended, by itself or with what is around it, and has not been left yet."""
        return scope.flow.ended is not None and scope.flow.ended.depth <= scope.depth

    def _doom(self, flow: Flow, scope: Scope) -> None:
        if flow.ended is None or scope.depth < flow.ended.depth:
            flow.ended = scope

    def _deliver_in_turn(self, flows: list[Flow]) -> None:
        """Cancel the last flow that is not cancelled yet, and go on when it has ended."""
        while flows:
            flow = flows.pop()
            if not flow.alive or flow.delivered or flow.ended is None:
                continue
            flow.delivered = True
            if flows:
                after = flow.on_end

                def ended(flow: Flow, after: Callable[[Flow], None] | None = after) -> None:
                    if after is not None:
                        after(flow)
                    self._deliver_in_turn(flows)

                flow.on_end = ended
            self._ready.append(((0, flow.path), partial(self._cancel, flow)))
            return

    def cancel_again(self, flow: Flow) -> None:
        """Cancel a flow whose clean-up takes too long."""
        self._ready.append(((0, flow.path), partial(self._cancel, flow)))
        self._poke()

    def _cancel(self, flow: Flow) -> None:
        if flow.outside:
            # It is taken back at once, so that the round waits for its clean-up.
            foreign = flow.foreign
            self._return(flow)
            self._busy += 1
            flow.told = True
            if foreign is not None:
                foreign.cancel()
        elif flow.parked is not None and not flow.parked.done():
            self._busy += 1
            flow.told = True
            flow.parked.cancel()

    # -------------------------------------------------------- the outside world

    def leave(self, flow: Flow, foreign: asyncio.Future[Any] | None) -> None:
        """The flow awaits something of the outside world."""
        flow.outside, flow.foreign = True, foreign
        self._outside += 1
        self._asking += flow.asking
        self._release()

    def readmit(self, flow: Flow) -> asyncio.Future[Any]:
        """The flow has come back from outside, or was woken by something that is not the agenda.

        Returns:
            What it has to wait for: it goes on in the next round.
        """
        if flow.outside:
            self._return(flow)
        self._free_next(flow)
        assert flow.parked is not None
        future = flow.parked
        if self._open:
            self._advance()
        else:
            self._interrupt.set()
        return future

    def _return(self, flow: Flow) -> None:
        flow.outside, flow.foreign = False, None
        self._outside -= 1
        self._asking -= flow.asking

    # -------------------------------------------------------- rounds and instants

    def _poke(self) -> None:
        """Something new came up: if nothing is going on, let it go on."""
        if not self._open:
            self._interrupt.set()

    def _advance(self) -> None:
        """Free the next flow; between rounds, let effects take hold first."""
        while self._open and self._busy == 0:
            if self._current:
                self._current.popleft()()
            elif self._asking and self._clock.deterministic:
                return
            else:
                self._take_hold()
                if self._writes:
                    continue
                if not self._ready and (self._fire_due() or self._reach_limits() or self._settle()):
                    continue
                if not self._ready:
                    self._open = False
                    self._settled.set()
                    return
                self._round += 1
                self._ready.sort(key=_order)
                self._current.extend(go for _, go in self._ready)
                self._ready.clear()

    def _take_hold(self) -> None:
        """What happens between rounds."""
        writes, self._writes = sorted(self._writes, key=_order), []
        for _, write in writes:
            write()
        checks, self._checks = sorted(self._checks, key=_order), []
        for _, check in checks:
            check()
        while self._ends or self._emissions:
            ends, self._ends = sorted(self._ends, key=_order), []
            for _, effect in ends:
                effect()
            if not self._ends:
                emissions, self._emissions = sorted(self._emissions, key=_order), []
                for _, emission in emissions:
                    emission()
        closings, self._closings = self._closings, []
        for close in closings:
            close()
        fired = sorted((w for w in self._fired if not w.over), key=lambda waiter: waiter.flow.path)
        self._fired = []
        for waiter in fired:
            flow = waiter.flow
            if flow.guard is not None and flow.ended is None:
                guard, flow.guard = flow.guard, None
                guard(flow)
        for waiter in fired:
            future = waiter.flow.parked
            assert future is not None
            go = partial(self._free, waiter.flow, future, waiter.value)
            self._ready.append(((1, self._step_order(waiter.flow.path)), go))

    def _open_instant(self) -> None:
        now = round(self._clock.now(), TIME_DIGITS)
        if now > self.now:
            self.now = now
            self.instant += 1
        self._fire_due()
        self._open = True
        self._settled = anyio.Event()
        self._advance()

    def _fire_due(self) -> bool:
        """Fire what is due by now; returns whether there was anything that counts at once."""
        has_fired = False
        while self._timers and self._timers[0][0] <= self.now:
            due = heapq.heappop(self._timers)[2]
            if due.over:
                continue
            match due:
                case Waiter():
                    self.fire(due)
                case Timer(act=act):
                    act()
                case Limit():
                    self._due_limits.append(due)
                    continue
            has_fired = True
        return has_fired

    def _reach_limits(self) -> bool:
        """Let limits act that are due and have none that is due within them; returns whether there were any."""
        if self._outside and self._clock.deterministic:
            return False  # what is at work there may end in this instant
        due = [limit for limit in self._due_limits if not limit.over]
        around = {scope for limit in due for scope in limit.scope.around}
        self._due_limits = [limit for limit in due if limit.scope in around]
        reached = [limit for limit in due if limit.scope not in around]
        for limit in reached:
            limit.over = True
            self._ends.append((limit.scope.flow.path, limit.act))
        return bool(reached)

    def _settle(self) -> bool:
        """Let those act who wait for the instant to settle; returns whether there were any."""
        acts, self._at_settling = self._at_settling, []
        for act in acts:
            act()
        return bool(acts)

    async def drive(self) -> None:
        """Let instants follow each other until `finish`; the one task that moves time."""
        while not self._finished:
            if not self._has_work():
                await self._pass_time()
            self._interrupt = anyio.Event()
            if not self._finished:
                self._open_instant()
                await self._settled.wait()

    def _has_work(self) -> bool:
        return bool(self._ready or self._fired or self._writes or self._ends or self._emissions)

    async def _pass_time(self) -> None:
        while self._timers and self._timers[0][2].over:
            heapq.heappop(self._timers)
        due = self._timers[0][0] if self._timers else None
        deterministic = self._clock.deterministic
        if self._broken or (deterministic and self._outside):
            await self._interrupt.wait()
        elif deterministic and due is None and not self._expected:
            if self._has_been_stuck:  # the run is ending, and waits for a clean-up that takes real time
                await self._interrupt.wait()
            self._has_been_stuck = True
            self._stuck()
        else:
            try:
                await self._clock.pass_time(due, self._interrupt)
            except Exception as error:
                self._broken = True
                self._clock_failed(error)

    def finish(self) -> None:
        """Stop driving, once the run is over."""
        self._finished = True
        self._interrupt.set()


def _by_path(path: tuple[int, ...]) -> Any:
    return path


def _order(entry: tuple[Any, Callable[[], None]]) -> Any:
    return entry[0]
