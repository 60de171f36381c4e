"""Running made-up programs, and what of a trace must not depend on how it came about."""

from __future__ import annotations

import asyncio
import json
import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from seoro import ActionContext, ActionFailed, action
from seoro.bindings.bound_functions import BoundFunctions
from seoro.embed import check_file
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan
from seoro.runtime.execution.settings import Settings
from seoro.runtime.kernel.clock import VirtualClock
from seoro.runtime.run import Execution
from seoro.runtime.verdict import Verdict

Record = dict[str, Any]
_BEHAVIORS = {"id", "parent", "behavior", "by", "modifier"}  # fields with numbers of behaviors
_HOLDERS = {"instance", "of", "object"}  # fields with numbers of instances and objects


@action("hold", open_ended=True)
async def hold(ctx: ActionContext) -> None:
    """Go on until it is ended."""
    try:
        await ctx.sleep(1e6)
    finally:
        ctx.log("held")


@action("work")
async def work(ctx: ActionContext, seconds: float) -> None:
    """Take a while."""
    try:
        await ctx.sleep(seconds)
    except asyncio.CancelledError:
        ctx.log("cleaned up")
        raise


@action("give_up")
async def give_up(ctx: ActionContext) -> None:
    raise ActionFailed("given up")


def _module() -> ModuleType:
    module = ModuleType("actions_of_programs")
    vars(module).update({function.__name__: function for function in (hold, work, give_up)})
    return module


@dataclass(frozen=True)
class Loaded:
    """A program that has been checked."""

    plan: Plan
    functions: BoundFunctions


def load_text(text: str) -> Loaded:
    """Check a program, which has no errors."""
    path = Path("program.osc")

    def read(asked: Path) -> Any:
        return text if asked == path else asked.read_text(encoding="utf-8")

    scenario = check_file(path, modules=[_module()], read=read)
    assert not scenario.checked.errors, f"{text}\n{scenario.checked.errors}"
    return Loaded(lower(scenario.checked, "main", {}), scenario.functions)


@dataclass(eq=False)
class Ran:
    """Result of a run.

    Args:
        round: Returns the number of the current round.
        records: Records of events.
        rounds: Round of each record.
        verdict: End state.
    """

    round: Callable[[], int] = lambda: 0
    records: list[Record] = field(default_factory=list)
    rounds: list[int] = field(default_factory=list)
    verdict: Verdict | None = None

    def record(self, record: Record) -> None:
        """Observer that ignores stamps of the wall clock."""
        self.records.append({name: value for name, value in record.items() if name != "wall"})
        self.rounds.append(self.round())


async def execute(loaded: Loaded, order: int | None = None) -> Ran:
    """Run a program on the virtual clock.

    Args:
        loaded: The program.
        order: Seed of the order of the tasks in a round; None for the order of the runtime.
    """
    ran, functions = Ran(), loaded.functions
    chance = random.Random(order)
    settings = Settings(
        0,
        VirtualClock(),
        observers=[ran],
        actions=functions.actions,
        modifiers=functions.modifiers,
        step_order=None if order is None else lambda path: chance.random(),
    )
    execution = Execution(loaded.plan, settings)
    ran.round = lambda: execution._scheduler.cycle
    ran.verdict = await execution.run()
    assert execution.fault is None
    return ran


def in_any_order(ran: Ran) -> list[tuple[int, list[str]]]:
    """Return the sorted records of each round; changes of variables are numbered, as their order matters."""
    names = _Names(ran.records)
    changes: Counter[int] = Counter()
    found: dict[int, list[str]] = {}
    for number, record in zip(ran.rounds, ran.records, strict=True):
        shown = {name: names.named(name, value) for name, value in record.items() if name != "seq"}
        if "cause" in shown:
            shown["cause"] = names.record(ran.records[record["cause"]])
        if record["kind"] == "run.start":
            shown["tree"] = len(record["tree"])
        if record["kind"] == "variable":
            changes[number] += 1
            shown["number"] = changes[number]
        found.setdefault(number, []).append(json.dumps(shown))
    return [(number, sorted(lines)) for number, lines in found.items()]


class _Names:
    """Names instead of numbers, which depend on the order of starts.

    Behaviors are named by path, instances by their invocation, structs and actors by their place in the trace.

    Args:
        records: All records of a run.
    """

    def __init__(self, records: Sequence[Record]) -> None:
        self._behaviors: dict[int | None, str] = {None: ""}
        self._holders: dict[int, str] = {}
        self._seen: Counter[str] = Counter()
        for record in records:
            if record["kind"] == "behavior.start":
                path = f"{self._behaviors[record['parent']]}>{record['path']}"
                self._behaviors[record["id"]] = self._next(path)
            elif record["kind"] == "instance":
                path = f"{self._behaviors[record['behavior']]}:{record['of']}"
                self._holders[record["instance"]] = name = self._next(path)
                self._name_objects(record["values"], name)

    def _next(self, path: str) -> str:
        self._seen[path] += 1
        return f"{path}*{self._seen[path]}"

    def _name_objects(self, traced: Any, path: str) -> None:
        if isinstance(traced, dict):
            if "object" in traced:
                self._holders.setdefault(traced["object"], path)
            for name, value in traced.items():
                self._name_objects(value, f"{path}.{name}")

    def record(self, record: Record) -> str:
        """Return a name of a record that is a cause."""
        own = self._behaviors[record["id"]] if "id" in record else record.get("name") or record.get("path", "")
        return f"{record['kind']} {own} at {record['t']}"

    def named(self, field: str, value: Any) -> Any:
        """Return the value of a field of a record, with names instead of numbers."""
        if isinstance(value, dict):
            return {name: self.named(name, inside) for name, inside in value.items()}
        if field in _BEHAVIORS:
            return self._behaviors[value]
        if field in _HOLDERS and isinstance(value, int):
            return self._holders[value]
        return value
