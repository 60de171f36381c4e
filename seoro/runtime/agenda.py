"""What may run next: instants, rounds, and the flows of control that step in them.

Everything happens in instants, at one value of `now`. An instant is a sequence of rounds. In a round every
flow that may go on takes one step, one flow at a time in the order of invocation paths; its effects are put
down here and take hold between rounds, in this order: changes of variables, then what ends behaviors (failures,
`emit end`, a choice of `one_of`), then what wakes waiting flows. So no flow sees what another did in
the same round, and the textual order of members changes nothing. When no flow can go on the instant has settled,
and only then may time move. Before that, choices between guards are made, and limits act that are due
(`settling.py`): what ends by itself in that instant is in time.

A flow counts as busy from the moment it is freed until it parks here again; when the last busy flow parks, the
next is freed in that very call. A flow that is alone therefore frees itself and goes on without a switch, also
from one instant to the next where the clock can skip. A flow becomes a task when it is freed for the first time.

Actions may await things of the outside world. Their flow then is `outside`: rounds go on without it, and
on clocks of which the runtime is the master time waits for it. A request to a backend is shorter than that:
on such clocks even the round waits for the answer, so that answers arrive in a fixed order.

Behaviors are ended by scope: the agenda marks every flow in the scope, and delivers a cancellation to
one after another, the last started first, as each has finished its clean-up.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from contextvars import Context, copy_context
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import anyio

from seoro.runtime.ending import end
from seoro.runtime.flows import Flow, Scope, Waiter
from seoro.runtime.rounds import Effects, Rounds, StepOrder, by_path
from seoro.runtime.settling import Settling
from seoro.runtime.stack import carried
from seoro.runtime.timetable import TIME_DIGITS, Entry, Limit, Timer, Timetable
from seoro.runtime.verdict import CANCELLED, Outcome

if TYPE_CHECKING:
    from seoro.runtime.contracts import Clock

__all__ = ["TIME_DIGITS", "Agenda", "Behave", "Flow", "Limit", "Scope", "StepOrder", "Timer", "Waiter"]

Behave: TypeAlias = Callable[[Flow], Coroutine[Any, Any, Outcome]]  # what a flow does
PATIENCE = 1.0  # [s] of the machine's clock that time may take to pass when the run has been stopped
SKIPS = 50  # instants that may follow each other before other tasks of the event loop have a turn
SLICE = 0.05  # [s] of the machine's clock in which rounds follow each other before other tasks have one
LOOK_EVERY = 8  # steps after which to look at the machine's clock for that


class Agenda:
    """The order of everything in one run. Make it inside of the event loop.

    Args:
        clock: The run's clock.
        stuck: Called when nothing can happen any more.
        clock_failed: Called when the clock raises; time stands still from then on.
        broken: Called when a flow raises, or what happens between steps, which nothing of that should.
        step_order: Gives, for the path of a flow, the key by which the steps of a round are sorted; by default the
            path itself. Since no flow sees an effect of its own round, any order gives the same run but for the
            order of records, which is what tests put to the proof.
    """

    def __init__(
        self,
        clock: Clock,
        stuck: Callable[[], None],
        clock_failed: Callable[[Exception], None],
        broken: Callable[[Exception], None],
        step_order: StepOrder | None = None,
    ) -> None:
        self.now = 0.0
        self.instant = 0
        self._loop = asyncio.get_running_loop()
        self._clock = clock
        self._stuck = stuck
        self._clock_failed = clock_failed
        self._broken = broken
        self._has_clock_failed = False
        self._has_been_stuck = False
        self._busy = 0
        self._outside = 0
        self._asking = 0
        self._expected = 0  # answers that a backend will give as time goes on
        self._open = False  # whether the instant has not settled
        self._is_apart = False  # whether `drive` does not know of it
        self._finished = False
        self._alive = 0  # flows that have not ended
        self._skips = 0  # instants since other tasks have had a turn
        self._slice_end = 0.0  # when they are to have one [s]
        self._yields = False  # whether they have it now, in the middle of an instant
        self._steps = 0  # since the last look at the machine's clock
        self._rounds = Rounds(step_order or by_path, self._cancel)
        self._effects = Effects(broken)
        self._fired: list[Waiter] = []
        self._timetable = Timetable()
        self._settling = Settling()
        self._settled = asyncio.Event()
        self._interrupt = anyio.Event()
        self._passing = anyio.CancelScope()  # of the time that is passing, or has passed last
        self._held: list[Callable[[], None]] = []  # what backends have said since the last instant

    @property
    def has_clock_failed(self) -> bool:
        """Whether time stands still, because the clock has raised or was given up."""
        return self._has_clock_failed

    @property
    def is_exact(self) -> bool:
        """Whether instants are at the very times at which something is due."""
        return self._clock.deterministic

    # -------------------------------------------------------- flows

    def fork(self, path: tuple[int, ...], parent: Scope | None, behave: Behave) -> Flow:
        """A new flow, which takes its first step in the next round.

        Args:
            path: Its position in the tree of invocations.
            parent: The scope from which it is forked; None for the run itself.
            behave: What it does.
        """
        flow = Flow(path, parent, (self._rounds.number, path))
        if parent is not None:
            parent.flow.forked[flow] = None
        self._alive += 1
        self._rounds.step(path, partial(self._begin, flow, behave, copy_context()))
        self._poke()
        return flow

    def _begin(self, flow: Flow, behave: Behave, context: Context) -> None:
        """Start the task of a flow, unless it was ended in the meantime."""
        if flow.ended is None:
            self._busy += 1
            flow.task = self._loop.create_task(self._carry(flow, behave), context=context)

    async def _carry(self, flow: Flow, behave: Behave) -> None:
        """The whole life of a flow."""
        outcome = CANCELLED
        try:
            outcome = await carried(behave(flow))
        except asyncio.CancelledError:
            if not self.left(flow.scopes[0]):
                raise
        except Exception as error:
            self._broken(error)
        finally:
            self._flow_ended(flow, outcome)
            self._release()

    def _flow_ended(self, flow: Flow, outcome: Outcome) -> None:
        flow.alive = False
        flow.outcome = outcome
        self._alive -= 1
        if flow.parent is not None:
            del flow.parent.flow.forked[flow]
        if flow.on_end is not None:
            self._effects.ends.append((flow.path, partial(flow.on_end, flow)))

    async def step(self, flow: Flow) -> None:
        """Wait for the next round, or take the first step of a flow in the round it was freed in."""
        if flow.fresh:
            flow.fresh = False
        elif not self._goes_on_alone():
            self._free_next(flow)
            await self._park(flow)

    def _goes_on_alone(self) -> bool:
        """Whether the one busy flow is all there is in the next round, which then begins in this call."""
        rounds = self._rounds
        if self._busy > 1 or rounds.present or rounds.has_next or self._waits_for_answers():
            return False
        self._steps += 1
        if self._steps > LOOK_EVERY:
            if time.monotonic() > self._slice_end:
                return False
            self._steps = 0
        self._take_hold()
        while self._effects.writes:
            self._take_hold()
        if rounds.has_next:
            return False
        rounds.number += 1
        return True

    async def wait(self, waiter: Waiter) -> Any:
        """Wait until the waiter is fired; returns the value it was fired with."""
        waiter.flow.parked = self._loop.create_future()
        try:
            return await self._park(waiter.flow)
        finally:
            waiter.over = True

    def _free_next(self, flow: Flow) -> None:
        """Park a flow that is to be freed in the next round."""
        future = flow.parked = self._loop.create_future()
        self._rounds.step(flow.path, partial(self._free, flow, future, None))

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

    def arrive(self, waiter: Waiter) -> None:
        """Wake a flow that waits for the outside world.

        Where time passes by itself, an instant begins in this call, and `drive` is told when it has settled: what
        arrives is answered a turn of the event loop sooner.
        """
        if self._open or self._clock.deterministic or self._finished:
            self.fire(waiter)
        elif not (waiter.fired or waiter.over):
            waiter.fired = True
            self._fired.append(waiter)
            self._is_apart = True
            self._open_instant()

    def happen(self, act: Callable[[], None]) -> None:
        """Do what the outside world brings about, in this instant or in one that begins in this call.

        On clocks of which the runtime is the master, it is done in the next instant.
        """
        if self._open or self._clock.deterministic or self._finished:
            self.tell(act)
        else:
            self._held.append(act)
            self._is_apart = True
            self._open_instant()

    def at(self, time: float, entry: Entry) -> None:
        """Fire a waiter, or let a timer or a limit act, in the first instant at or after a time."""
        self._timetable.add(time, entry)

    def react(self, path: tuple[int, ...], step: Callable[[], None]) -> None:
        """Take a step in the next round that belongs to no flow, and awaits nothing."""
        self._rounds.step(path, step)
        self._poke()

    def check(self, path: tuple[int, ...], effect: Callable[[], None]) -> None:
        """Put down what depends on variables; it takes hold once all of their changes have, in order of paths."""
        self._effects.checks.append((path, effect))

    def choose(self, choice: Limit) -> None:
        """Let a choice be made when the instant has otherwise settled, before limits act; once this instant."""
        self._settling.choose(choice)

    def when_settled(self, act: Callable[[], None]) -> None:
        """Let something act when the instant has otherwise settled, limits and all; flows may be outside still."""
        self._settling.follow(act)

    def write(self, path: tuple[int, ...], effect: Callable[[], None]) -> None:
        """Put down a change of a variable; it takes hold between rounds, before all else, in order of paths."""
        self._effects.writes.append((path, effect))
        self._poke()

    def after_round(self, path: tuple[int, ...], effect: Callable[[], None]) -> None:
        """Put down an effect that ends behaviors; it takes hold between rounds, in the order of paths."""
        self._effects.ends.append((path, effect))
        self._poke()

    def emit(self, occurrence: tuple[str, str], effect: Callable[[], None]) -> None:
        """Put down an emission; it takes hold between rounds, after what ends behaviors.

        Args:
            occurrence: The event and its arguments; those of one round take hold in the order of that.
            effect: Called then.
        """
        self._effects.emissions.append((occurrence, effect))

    def close(self, effect: Callable[[], None]) -> None:
        """Put down the end of what hears emissions; it takes hold after all of the same round."""
        self._effects.closings.append(effect)

    def expect(self, count: int) -> None:
        """A backend is going to report something as time goes on, which therefore may; or, for -1, it has."""
        self._expected += count

    # -------------------------------------------------------- ending

    @staticmethod
    def scope(flow: Flow) -> Scope:
        """A scope in a flow; leave it by the end of the block, also when it was ended."""
        return Scope(flow, len(flow.scopes))

    @staticmethod
    def left(scope: Scope) -> bool:
        """Whether a cancellation that arrives here was meant for this scope; if so, the flow goes on."""
        flow = scope.flow
        if flow.ended is not scope:
            return False
        flow.ended, flow.delivered = None, False
        return True

    @staticmethod
    def is_ended(scope: Scope) -> bool:
        """Whether a scope was ended, by itself or with what is around it, and has not been left yet."""
        return scope.flow.ended is not None and scope.flow.ended.depth <= scope.depth

    def end(self, scope: Scope, outcome: Outcome) -> None:
        """End a scope, unless it has been left. To be called between rounds, as an effect."""
        end(scope, outcome, self._rounds.cancel)

    def end_flow(self, flow: Flow, outcome: Outcome) -> None:
        """End a whole flow. To be called between rounds, as an effect."""
        if flow.alive:
            self.end(flow.scopes[0], outcome)

    def cancel_again(self, flow: Flow) -> None:
        """Cancel a flow whose clean-up takes too long."""
        self._rounds.cancel(flow)
        self._poke()

    def _cancel(self, flow: Flow) -> None:
        if flow.outside:
            # It is taken back at once, so that the round waits for its clean-up.
            foreign = flow.foreign
            self._return(flow)
            self._tell(flow)
            if foreign is not None:
                foreign.cancel()
        elif flow.parked is not None and not flow.parked.done():
            self._tell(flow)
            flow.parked.cancel()
        elif flow.task is None and flow.alive:
            self._flow_ended(flow, CANCELLED)  # before it has begun

    def _tell(self, flow: Flow) -> None:
        """The flow is going to see that it is cancelled."""
        self._busy += 1
        flow.told = True
        if flow.on_cancel is not None:
            flow.on_cancel()

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

    def tell(self, act: Callable[[], None]) -> None:
        """Record what a backend says of its own accord, in the instant that it belongs to: this or the next.

        After the last one, it is recorded at once: backends are ended then.
        """
        if self._open or self._finished:
            act()
        else:
            self._held.append(act)
            self._poke()

    def _tell_held(self) -> None:
        held, self._held = self._held, []
        for act in held:
            act()

    def _advance(self) -> None:
        """Free the next flow; between rounds, let effects take hold first. What raises does not stop the rest."""
        while True:
            try:
                return self._go_on()
            except Exception as error:
                self._broken(error)

    def _go_on(self) -> None:
        while self._open and self._busy == 0 and not self._yields:
            if self._rounds.present:
                self._steps += 1
                if self._steps > LOOK_EVERY and self._is_yielding():
                    return
                self._rounds.present.popleft()()
            elif self._waits_for_answers():
                return
            else:
                self._take_hold()
                if self._effects.writes:
                    continue
                if self._rounds.has_next:
                    self._rounds.begin()
                elif not (self._fire_due() or self._act_at_end() or self._skip()):
                    self._open = False
                    self._settled.set()
                    if self._is_apart:
                        self._is_apart = False
                        self._interrupt.set()

    def _is_yielding(self) -> bool:
        """Whether other tasks of the event loop have a turn first, which may want to stop the run.

        Nothing of the run goes on meanwhile, so that runs are the same however fast the machine is. When its last
        flow has ended, there is nothing to stop any more.
        """
        self._steps = 0
        if self._alive and time.monotonic() > self._slice_end:
            self._yields = True
            self._loop.call_soon(self._resume)
        return self._yields

    def _resume(self) -> None:
        self._yields = False
        self._slice_end = time.monotonic() + SLICE
        if not self._finished:
            self._advance()

    def _waits_for_answers(self) -> bool:
        return self._asking > 0 and self._clock.deterministic

    def _take_hold(self) -> None:
        """What happens between rounds."""
        self._effects.take_hold()
        if self._fired:
            self._wake_fired()

    def _wake_fired(self) -> None:
        fired = [waiter for waiter in self._fired if not waiter.over]
        self._fired.clear()
        if len(fired) > 1:
            fired.sort(key=lambda waiter: waiter.flow.path)
        for waiter in fired:
            flow = waiter.flow
            assert flow.parked is not None
            go_on = partial(self._rounds.step, flow.path, partial(self._free, flow, flow.parked, waiter.value))
            if flow.guard is None or flow.ended is not None:
                go_on()
            else:
                guard, flow.guard = flow.guard, None
                guard(flow, go_on)

    def _open_instant(self) -> None:
        self._skips = 0
        self._slice_end = time.monotonic() + SLICE
        self._settled.clear()
        self._open = True
        try:
            self._begin_instant()
        except Exception as error:
            self._broken(error)
        self._advance()

    def _begin_instant(self) -> None:
        now = round(self._clock.now(), TIME_DIGITS)
        if now > self.now:
            self.now = now
            self.instant += 1
        self._tell_held()
        self._fire_due()

    def _fire_due(self) -> bool:
        """Fire what is due by now; returns whether there was anything that counts at once."""
        has_fired = False
        while (due := self._timetable.take(self.now)) is not None:
            match due:
                case Waiter():
                    self.fire(due)
                case Timer(act=act):
                    act()
                case Limit():
                    self._settling.reach(due)
                    continue
            has_fired = True
        return has_fired

    def _act_at_end(self) -> bool:
        """Let something act that waits for the instant to settle; returns whether there was anything."""
        may_end = self._outside > 0 and self._clock.deterministic  # in this instant, before its limit
        return self._settling.act(self._effects, with_limits=not may_end)

    def _skip(self) -> bool:
        """Begin the next instant in this call, if the clock can do so; not for ever, since other tasks wait."""
        if self._skips == SKIPS or self._outside or not self._alive or self._has_clock_failed:
            return False
        due = self._timetable.next_due
        if due is None or not self._clock.skip(due):
            return False
        self._skips += 1
        self._begin_instant()
        return True

    async def drive(self) -> None:
        """Let instants follow each other until `finish`; the one task that moves time."""
        while not self._finished:
            if not self._has_work():
                await self._pass_time()
            if self._interrupt.is_set():
                self._interrupt = anyio.Event()
            if not self._finished:
                if not self._open:
                    self._open_instant()
                await self._settled.wait()

    def _has_work(self) -> bool:
        return bool(self._rounds.has_next or self._fired or self._effects.are_there)

    async def _pass_time(self) -> None:
        due = self._timetable.next_due
        deterministic = self._clock.deterministic
        if self._has_clock_failed or (deterministic and self._outside):
            await self._interrupt.wait()
        elif deterministic and due is None and not self._expected:
            if self._has_been_stuck:  # the run is ending, and waits for a clean-up that takes real time
                await self._interrupt.wait()
            self._has_been_stuck = True
            self._stuck()
        else:
            try:
                with anyio.CancelScope() as self._passing:
                    await self._clock.pass_time(due, self._interrupt)
                self._has_clock_failed = self._passing.cancelled_caught
            except Exception as error:
                self._has_clock_failed = True
                self._clock_failed(error)

    def hurry(self) -> None:
        """The run has been stopped: a simulator that hangs while time passes there is waited for no longer."""
        if not self._finished:
            self._loop.call_later(PATIENCE, self._passing.cancel)

    def finish(self) -> None:
        """Stop driving, once the run is over."""
        self._finished = True
        self._tell_held()
        self._interrupt.set()
        self._settled.set()  # an instant that a defect has broken does not settle
