"""Injected faults of the runtime: the trace check has to find each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import pytest

from seoro.runtime.behaviors import emit, modifier, override, perform
from seoro.runtime.behaviors.choice import Choice
from seoro.runtime.behaviors.overlap import Overlap
from seoro.runtime.events.conditions import Conditions
from seoro.runtime.events.subscriptions import Subscriptions
from seoro.runtime.events.ticks import Ticks
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.kernel.channel import Channel
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.timers import Timer
from seoro.runtime.verdict import SUCCEEDED

LATE = 0.25  # [s]; nothing else in the scenarios takes that long


@dataclass(frozen=True)
class Mutation:
    """A fault.

    Args:
        name: Effect of the fault.
        put_in: Injects it into the runtime.
        body: Body of a scenario that it affects.
        members: Other members of the scenario.
    """

    name: str
    put_in: Callable[[pytest.MonkeyPatch], None]
    body: str
    members: str = ""


def _late_subscriptions(patch: pytest.MonkeyPatch) -> None:
    """Delay the events of subscriptions, and of reactions."""
    patch.setattr(Subscriptions, "connect_own", lambda self, *arguments: False)
    _late_reactions(patch)


def _late_reactions(patch: pytest.MonkeyPatch) -> None:
    """Delay the events of reactions."""
    listen = Subscriptions.listen

    def listen_late(self: Subscriptions, specification: Any, environment: Any, context: Any, receive: Any) -> Any:
        return listen(self, specification, environment, context, _late(self._scheduler, receive))

    patch.setattr(Subscriptions, "listen", listen_late)


def _late(scheduler: Scheduler, receive: Callable[[Any], bool]) -> Callable[[Any], bool]:
    def late(occurrence: Any) -> bool:
        def act() -> None:
            receive(occurrence)

        scheduler.act_at(scheduler.now + LATE, Timer(act))
        return True

    return late


def _replacing(
    name: str, make: Callable[[Any], Any], module: Any = perform
) -> Callable[[pytest.MonkeyPatch], None]:
    """A function is carried out in another way, which is made from it."""
    return lambda patch: patch.setattr(module, name, make(getattr(module, name)))


def _with_members(change: Callable[[tuple[Any, ...]], tuple[Any, ...]]) -> Callable[[Any], Any]:
    """A composition with other members."""

    def make(carry: Any) -> Any:
        async def changed(plan: Any, *rest: Any) -> Any:
            return await carry(replace(plan, members=change(plan.members)), *rest)

        return changed

    return make


def _late_members(carry: Any) -> Any:
    async def late(plan: Any, place: Any, perform_member: Any) -> Any:
        async def perform_late(member: Any, inside: Any) -> Any:
            if inside.position[-1] > 0:
                await inside.task.sleep(LATE)
            return await perform_member(member, inside)

        return await carry(plan, place, perform_late)

    return late


def _going_on(carry: Any) -> Any:
    """A serial whose members may fail."""

    async def going_on(plan: Any, place: Any, perform_member: Any) -> Any:
        async def perform_any(member: Any, inside: Any) -> Any:
            await perform_member(member, inside)
            return SUCCEEDED

        return await carry(plan, place, perform_any)

    return going_on


def _decide_for_two(patch: pytest.MonkeyPatch) -> None:
    def choose(self: Choice) -> None:
        for task, resume in self._held.items():
            self._decided = task
            resume()

    patch.setattr(Choice, "_choose", choose)


def _early(patch: pytest.MonkeyPatch) -> None:
    end = ExecutionContext.end_of
    patch.setattr(ExecutionContext, "end_of", lambda *arguments: end(*arguments) - LATE)


def _shifted_ticks(patch: pytest.MonkeyPatch) -> None:
    begin = Ticks.__init__
    patch.setattr(
        Ticks, "__init__", lambda self, scheduler, first, *rest: begin(self, scheduler, first + LATE, *rest)
    )


def _unlimited(_: Any) -> Any:
    async def unlimited(place: Any, limit: float, behave: Any, *rest: Any, **more: Any) -> Any:
        return await behave(), False

    return unlimited


def _lost_occurrence(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Channel, "_deliver", lambda self, occurrence: None)


def _together(make: Any) -> Any:
    def all_at_once(plan: Any, place: Any) -> Any:
        timing = make(plan, place)
        return replace(timing, starts=(0.0,) * len(timing.starts))

    return all_at_once


async def _without(place: Any, inner: Any) -> Any:
    return await inner(place)


def _not_failing(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Overlap, "_fail", lambda self, outcome: None)


def _no_checks(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Conditions, "changed", lambda self, holder, name: None)


def _ignoring(_: Any) -> Any:
    return lambda applied, place, inner, within: inner(place)


def _nothing(*_: Any) -> None:
    """Nothing happens."""


MUTATIONS = (
    Mutation("until ends late", _late_subscriptions, "parallel:\n    wait elapsed(3s)\nwith:\n    until @one"),
    Mutation("wait ends late", _late_subscriptions, "wait @one"),
    Mutation("elapsed is early", _early, "wait elapsed(2s)"),
    Mutation("every is late", _shifted_ticks, "wait every(2s, offset: 1s)"),
    Mutation("on is late", _late_reactions, "wait elapsed(4s)", "on @one:\n    emit two"),
    Mutation(
        "parallel forgets a member",
        _replacing("run_parallel", _with_members(lambda members: members[:2])),
        "parallel:\n    log(1)\n    log(2)\n    log(3)",
    ),
    Mutation(
        "serial skips a member",
        _replacing("run_serial", _with_members(lambda members: (*members[:1], *members[2:]))),
        "serial:\n    log(1)\n    log(2)\n    log(3)",
    ),
    Mutation("serial goes on late", _replacing("run_serial", _late_members), "serial:\n    log(1)\n    log(2)"),
    Mutation("serial does not fail", _replacing("run_serial", _going_on), "serial:\n    give_up()\n    log(2)"),
    Mutation(
        "one_of lets two go on",
        _decide_for_two,
        "one_of:\n    serial:\n        wait elapsed(1s)\n        log(1)\n"
        "    serial:\n        wait elapsed(2s)\n        log(2)",
    ),
    Mutation(
        "an emission is lost",
        _lost_occurrence,
        "parallel:\n    wait @two\n    serial:\n        emit two\n        wait elapsed(1s)",
    ),
    Mutation(
        "a condition is not looked at again",
        _no_checks,
        "parallel:\n    wait n == 1\n    serial:\n        increment(n)\n        wait elapsed(1s)",
    ),
    Mutation(
        "timeout never acts",
        _replacing("within_limit", _unlimited, modifier),
        "serial:\n    wait elapsed(3s)\nwith:\n    timeout(1s)",
    ),
    Mutation(
        "a duration is ignored",
        _replacing("run_duration", lambda carry: _without),
        "serial(duration: 2s):\n    wait elapsed(1s)",
    ),
    Mutation(
        "an offset is ignored",
        _replacing("timing_of", _together),
        "parallel(overlap: any, start_to_start: 1s):\n    wait elapsed(3s)\n    wait elapsed(1s)",
    ),
    Mutation(
        "emit end does not end what runs beside it",
        lambda patch: patch.setattr(emit, "_end", _nothing),
        "parallel:\n    emit end\n    wait elapsed(2s)",
    ),
    Mutation("parallel goes on after a failure", _not_failing, "parallel:\n    give_up()\n    wait elapsed(2s)"),
    Mutation(
        "a modifier is ignored",
        _replacing("run_modifier", _ignoring, modifier),
        "serial:\n    log(1)\nwith:\n    repeat(2)",
    ),
    Mutation(
        "override is ignored",
        lambda patch: patch.setattr(override, "_end_overridden", _nothing),
        "parallel:\n    x: wait elapsed(3s)\n    serial:\n        wait elapsed(1s)\n        y: wait elapsed(1s)\n"
        "with:\n    override(x, y)",
    ),
)
