"""Running made-up programs, and what of a trace must not depend on how it came about."""

from __future__ import annotations

import asyncio
import json
import random
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from seoro import ActionContext, ActionFailed, action
from seoro.bindings.implementations import BoundFunctions
from seoro.embed import check_file
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan
from seoro.runtime.clock import VirtualClock
from seoro.runtime.run import Execution, Settings
from seoro.runtime.verdict import Verdict

Record = dict[str, Any]
_NUMBERS = {"id", "parent", "behavior", "by", "modifier"}  # of behaviors, in the order of their starts
_NUMBERED = {"seq", "instance", "of", "values", "exact"}  # numbered or ordered by steps


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
    """What became of a run."""

    records: list[Record] = field(default_factory=list)
    verdict: Verdict | None = None

    def record(self, record: Record) -> None:
        """An observer; stamps of the wall clock are no part of what happened."""
        self.records.append({name: value for name, value in record.items() if name != "wall"})


async def execute(loaded: Loaded, order: int | None = None) -> Ran:
    """Run a program on the virtual clock.

    Args:
        loaded: The program.
        order: From what number the order is drawn in which the flows of a round are stepped; None for the order
            of the runtime.
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
    ran.verdict = await execution.run()
    assert execution.fault is None
    return ran


def in_any_order(ran: Ran) -> list[tuple[float, list[str]]]:
    """What happened at each time, whatever the order in it.

    Behaviors have numbers in the order of their starts; here they are called by their paths.
    """
    names: dict[int | None, str] = {None: ""}
    seen: Counter[str] = Counter()
    changes: Counter[float] = Counter()
    found: dict[float, list[str]] = {}
    for record in ran.records:
        shown = {name: value for name, value in record.items() if name not in _NUMBERED}
        if record["kind"] == "behavior.start":
            name = f"{names[record['parent']]}>{record['path']}"
            seen[name] += 1
            names[record["id"]] = f"{name}*{seen[name]}"
            shown["parent"] = names[record["parent"]]
        for name in _NUMBERS & record.keys() - {"parent"}:
            shown[name] = names.get(record[name], "")
        if record["kind"] == "variable":  # changes take hold between rounds, in an order of their own
            changes[record["t"]] += 1
            shown["number"] = changes[record["t"]]
        found.setdefault(record["t"], []).append(json.dumps(shown))
    return [(time, sorted(lines)) for time, lines in found.items()]
