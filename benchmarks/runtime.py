"""What the runtime costs: waiting, reacting, steps, timers, nesting, and beside it `scenario-execution`.

    python benchmarks/runtime.py [CASE ...] [--peer PYTHON | --install-peer]

Each case runs in a process of its own, from the plan to the verdict, with nobody who reads the trace but where
that is how it is measured, and with the garbage collector as `seoro exec` sets it. The time of the processor is
told beside that of the wall clock where it matters: on a machine that does other things, it is less.

What the peer takes is read from the times in its log, from the start of a scenario to its end, without loading; of
what it takes minutes for, less is asked of it, as the table says.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import peer

from seoro.embed import Scenario, load
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan
from seoro.runtime.clock import RealClock, VirtualClock
from seoro.runtime.run import Execution, Settings

HEADER = "import osc.helpers\n"
SIZES = (10, 100, 1000, 10_000, 100_000)  # behaviors


def serial(*members: str) -> str:
    """A scenario with members one after another."""
    return f"{HEADER}scenario main:\n    do serial:\n" + "".join(f"        {member}\n" for member in members)


def parallel(*members: str) -> str:
    """A scenario with an event, and members side by side."""
    lines = "".join(f"        {line}\n" for member in members for line in member.splitlines())
    return f"{HEADER}scenario main:\n    event go\n    do parallel:\n{lines}"


def nested(levels: int) -> str:
    """Compositions within compositions."""
    lines = [f"{'    ' * (level + 2)}serial:\n" for level in range(levels - 1)]
    return f"{HEADER}scenario main:\n    do serial:\n{''.join(lines)}{'    ' * (levels + 1)}log('inside')\n"


def invoked(levels: int) -> str:
    """Scenarios that invoke each other."""
    scenarios = [f"scenario s{n}:\n    do serial:\n        s{n - 1}()\n" for n in range(1, levels)]
    first = "scenario s0:\n    do serial:\n        log('inside')\n"
    return "".join([HEADER, first, *scenarios, f"scenario main:\n    do serial:\n        s{levels - 1}()\n"])


def waiters(number: int) -> str:
    """Many who wait for one event."""
    return parallel(*["wait @go"] * number, "serial:\n    wait elapsed(500ms)\n    log('sent')\n    emit go")


ROUNDS = 20


def ping(waiter_first: bool) -> str:
    """An event after another; who emits and who waits each log it."""
    sender = [f"    wait elapsed(137ms)\n    log('sent')\n    emit go{n}" for n in range(ROUNDS)]
    hearer = [f"    wait @go{n}\n    log('heard')" for n in range(ROUNDS)]
    both = ["serial:\n" + "\n".join(sender), "serial:\n" + "\n".join(hearer)]
    events = "".join(f"    event go{n}\n" for n in range(ROUNDS))
    return parallel(*(reversed(both) if waiter_first else both)).replace("    event go\n", events)


# ---------------------------------------------------------------- running


class Stamps:
    """Notes when messages are logged."""

    def __init__(self) -> None:
        self.logged: list[tuple[float, str]] = []

    def record(self, record: dict[str, Any]) -> None:
        """An observer of the trace."""
        if record["kind"] == "log":
            self.logged.append((time.perf_counter(), record["message"]))


@dataclass(frozen=True)
class Ran:
    """What a run took.

    Args:
        wall: Seconds of the wall clock, with what comes before its start.
        processor: Seconds of the processor.
        logged: When after its start it logged what [s of the real clock].
        duration: From its start to its end [s of its clock].
    """

    wall: float
    processor: float
    logged: Sequence[tuple[float, str]]
    duration: float


def prepare(text: str) -> tuple[Scenario, Plan]:
    """The plan of a text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "main.osc"
        path.write_text(text)
        scenario = load(path)
        return scenario, lower(scenario.checked, "main")


def run(text: str, *, virtual: bool = False, logs: bool = False) -> Ran:
    """Run a text, and see that it passes."""
    scenario, plan = prepare(text)
    stamps = Stamps()
    clock = VirtualClock() if virtual else RealClock()

    async def carry() -> None:
        settings = Settings(
            seed=0,
            clock=clock,
            observers=[stamps] if logs else [],
            actions=scenario.functions.actions,
            modifiers=scenario.functions.modifiers,
        )
        execution = Execution(plan, settings)
        verdict = await execution.run()
        if not verdict.passed:
            raise SystemExit(f"it {verdict.status.value}: {verdict.reason}")

    before, processor = time.perf_counter(), time.process_time()
    asyncio.run(carry())
    after, processor = time.perf_counter(), time.process_time() - processor
    start = after - clock.now()
    logged = [(at - start, message) for at, message in stamps.logged]
    return Ran(after - before, processor, logged, after - start)


def delays(logged: Sequence[tuple[float, str]]) -> list[float]:
    """The times from each `sent` to the `heard` after it."""
    sent = [at for at, message in logged if message == "sent"]
    heard = [at for at, message in logged if message == "heard"]
    return [after - before for before, after in zip(sent, heard, strict=True)]


def waiting(number: int) -> dict[str, float]:
    """Processor time of the 18 seconds in the middle of a wait of 20."""
    scenario, plan = prepare(parallel(*["wait elapsed(20s)"] * number))
    taken: list[float] = []

    async def carry() -> None:
        functions = scenario.functions
        settings = Settings(0, RealClock(), actions=functions.actions, modifiers=functions.modifiers)
        execution = Execution(plan, settings)
        loop = asyncio.get_running_loop()
        for at in (1.5, 19.5):
            loop.call_later(at, lambda: taken.append(time.process_time()))
        await execution.run()

    asyncio.run(carry())
    return {"value": (taken[1] - taken[0]) * 1000}


def side_by_side(number: int) -> dict[str, float]:
    """Waits of a second."""
    ran = run(parallel(*["wait elapsed(1s)"] * number))
    return {
        "value": ran.wall,
        "processor": ran.processor,
        "MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def reaction() -> dict[str, float]:
    """From an event to the reaction, in either order of the text."""
    found = [each for first in (False, True) for each in delays(run(ping(first), logs=True).logged)]
    return {"value": max(found) * 1000}


def one_event(number: int) -> dict[str, float]:
    """From an event to the end of the last who waited for it."""
    ran = run(waiters(number), logs=True)
    return {"value": ran.duration - ran.logged[0][0], "processor, with what comes before": ran.processor}


def lateness() -> dict[str, float]:
    """Of timers of the real clock, after they are due; the first when all have long been started."""
    dues = [0.5 + 0.01 * n + 0.0003 * (n % 7) for n in range(300)]
    members = [f"serial:\n    wait elapsed({due:.4f}s)\n    log('{due:.4f}')" for due in dues]
    late = sorted(at - float(due) for at, due in run(parallel(*members), logs=True).logged)
    if late[0] < 0:
        raise SystemExit(f"a timer came {-late[0] * 1000:.3f} ms early")
    return {"value": late[int(0.99 * len(late))] * 1000, "median": statistics.median(late) * 1000}


def growth() -> dict[str, float]:
    """The cost of one behavior among 10, and among 100,000: loading, checking and lowering; running."""
    shown: dict[str, float] = {}
    for size in SIZES:
        text = serial(*["log('x')"] * size)
        start = time.process_time()
        prepare(text)
        loaded = time.process_time() - start
        shown[f"load {size}"] = loaded / size * 1e6
        shown[f"run {size}"] = run(text, virtual=True).processor / size * 1e6
    shown["value"] = shown["run 100000"] / shown["run 1000"]
    return shown


# ---------------------------------------------------------------- the peer


def peer_run(python: str, text: str) -> list[tuple[float, str]]:
    """What the peer logs, after the start of the scenario; empty if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "main.osc"
        path.write_text(text)
        stamps = peer.stamps(python, path)
    start = next((at for at, message in stamps if message.startswith("Executing")), 0.0)
    return [(at - start, message) for at, message in stamps]


def peer_length(text: str) -> Callable[[str], float | None]:
    """How long the peer takes from the start of a scenario to its end."""
    return lambda python: next((at for at, message in reversed(peer_run(python, text))), None)


def peer_reaction(python: str) -> float:
    """As `reaction`."""
    found = [each for first in (False, True) for each in delays(peer_run(python, ping(first)))]
    return max(found) * 1000


def peer_event(python: str) -> float:
    """As `one_event`, for a hundred."""
    logged = peer_run(python, waiters(100))
    return logged[-1][0] - next(at for at, message in logged if message == "sent")


def peer_waiting(number: int) -> Callable[[str], float | None]:
    """The processor time of 18 seconds of waiting: that of a long wait without that of a short one."""

    def measure(python: str) -> float:
        taken = []
        for seconds in (2, 20):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            peer_run(python, parallel(*[f"wait elapsed({seconds}s)"] * number))
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            taken.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        return (taken[1] - taken[0]) * 1000

    return measure


# ---------------------------------------------------------------- cases


@dataclass(frozen=True)
class Case:
    """One line of the table.

    Args:
        what: For people.
        unit: Of the figures.
        goal: What is to be reached, and whether at least or at most.
        own: Measures.
        other: Measures the peer; None if it has nothing like it.
        less: What is asked of the peer instead.
    """

    what: str
    unit: str
    goal: tuple[str, float]
    own: Callable[[], dict[str, float]]
    other: Callable[[str], float | None] | None = None
    less: str = ""


def length(text: str, *, virtual: bool) -> Callable[[], dict[str, float]]:
    """How long a run takes."""

    def measure() -> dict[str, float]:
        ran = run(text, virtual=virtual)
        return {"value": ran.wall, "processor": ran.processor}

    return measure


def rate() -> dict[str, float]:
    """Wake-ups of timers in a second of the machine's."""
    number = 50_000
    ran = run(serial(*["wait elapsed(1s)"] * number), virtual=True)
    return {"value": number / ran.wall, "a second of processor": number / ran.processor}


CASES: Mapping[str, Case] = {
    "reaction": Case("event to reaction, the longest of 40", "ms", ("<", 1.0), reaction, peer_reaction),
    "short": Case(
        "20 waits of 10 ms",
        "s",
        ("<", 0.25),
        length(serial(*["wait elapsed(10ms)"] * 20), virtual=False),
        peer_length(serial(*["wait elapsed(10ms)"] * 20)),
    ),
    "idle": Case("processor time of 18 s, 1 waits", "ms", ("<", 10.0), lambda: waiting(1), peer_waiting(1)),
    "idle1000": Case(
        "processor time of 18 s, 1,000 wait", "ms", ("<", 10.0), lambda: waiting(1000), peer_waiting(100), "100"
    ),
    "side": Case(
        "10,000 waits of 1 s side by side",
        "s",
        ("<", 3.0),
        lambda: side_by_side(10_000),
        peer_length(parallel(*["wait elapsed(1s)"] * 300)),
        "300",
    ),
    "chain": Case(
        "100,000 steps that take no time",
        "s",
        ("<", 2.0),
        length(serial(*["log('x')"] * 100_000), virtual=True),
        peer_length(serial(*["log('x')"] * 300)),
        "300",
    ),
    "emits": Case(
        "100,000 emissions in one instant", "s", ("<", 2.0), length(
            serial(*["emit go"] * 100_000).replace("    do", "    event go\n    do"), virtual=True
        )
    ),
    "timers": Case("timers a second, virtual time", "1/s", (">", 50_000), rate),
    "event": Case(
        "one event, 10,000 wait for it", "s", ("<", 0.3), lambda: one_event(10_000), peer_event, "100"
    ),
    "nested": Case(
        "500 compositions within each other",
        "s",
        ("<", 1.0),
        length(nested(500), virtual=True),
        peer_length(nested(200)),
        "200",
    ),
    "invoked": Case("500 scenarios that invoke each other", "s", ("<", 1.0), length(invoked(500), virtual=True)),
    "late": Case("timers of the real clock, late, p99", "ms", ("<", 2.0), lateness),
    "growth": Case("cost of one of 100,000 over one of 1,000", "", ("<", 1.5), growth),
}  # fmt: skip


def measured(name: str) -> dict[str, float]:
    """The figures of a case, from a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, "--once", name], check=False, capture_output=True, text=True, timeout=600
    )
    if done.returncode != 0:
        return {}
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def report(name: str, python: str | None) -> None:
    """Measure a case and print its line."""
    case = CASES[name]
    found = measured(name)
    relation, goal = case.goal
    value = found.pop("value", None)
    reached = value is not None and (value < goal if relation == "<" else value > goal)
    own = (
        "fails" if value is None else f"{value:,.3g} {case.unit}" if value < 1000 else f"{value:,.0f} {case.unit}"
    )
    theirs = ""
    if python is not None and case.other is not None:
        other = case.other(python)
        theirs = ("fails" if other is None else f"{other:,.3g} {case.unit}") + (
            f" ({case.less})" * bool(case.less)
        )
    mark = "reached" if reached else "MISSED"
    print(
        f"{case.what:42} {own:>12} {relation + f' {goal:,g} ' + case.unit:>14} {mark:8} {theirs:>18}", flush=True
    )
    if found:
        print("    " + ", ".join(f"{key}: {each:,.4g}" for key, each in found.items()), flush=True)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="What the runtime costs.")
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)} (default: all)")
    peer.add_peer_arguments(parser)
    parser.add_argument("--once", choices=CASES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.once:
        gc.set_threshold(50_000, 20, 100)
        print(json.dumps(CASES[options.once].own()))
        return
    python = peer.peer_of(options)
    print(f"{'':42} {'here':>12} {'goal':>14} {'':8} {'peer':>18}")
    for name in options.cases or CASES:
        report(name, python)


if __name__ == "__main__":
    main()
