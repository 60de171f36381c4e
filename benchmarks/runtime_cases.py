"""Texts of scenarios that load the runtime, and the measurements that `runtime.py` prints.

Each measurement runs from the plan to the verdict. The trace is read only for times and memory.
"""

from __future__ import annotations

import asyncio
import math
import resource
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from seoro.embed import Scenario, load
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan
from seoro.runtime.run import Execution

COLLECTOR = (200_000, 20, 100)  # thresholds of the garbage collector, as `seoro exec` sets them


def _import_first(*names: str) -> ModuleType:
    """Import the first module that exists: checkouts that are compared have different layouts."""
    for name in names[:-1]:
        try:
            return import_module(name)
        except ModuleNotFoundError:
            continue
    return import_module(names[-1])


_CLOCKS = _import_first("seoro.runtime.kernel.clock", "seoro.runtime.clock")
_SETTINGS = _import_first("seoro.runtime.execution.settings", "seoro.runtime.run")

HEADER = "import osc.helpers\n"
SIZES = (10, 100, 1000, 10_000, 100_000)  # behaviors


def serial(*members: str) -> str:
    """Return a scenario with members one after another."""
    return f"{HEADER}scenario main:\n    do serial:\n" + "".join(f"        {member}\n" for member in members)


def parallel(*members: str) -> str:
    """Return a scenario with an event, and members side by side."""
    lines = "".join(f"        {line}\n" for member in members for line in member.splitlines())
    return f"{HEADER}scenario main:\n    event go\n    do parallel:\n{lines}"


def nested(levels: int) -> str:
    """Return nested compositions."""
    lines = [f"{'    ' * (level + 2)}serial:\n" for level in range(levels - 1)]
    return f"{HEADER}scenario main:\n    do serial:\n{''.join(lines)}{'    ' * (levels + 1)}log('inside')\n"


def invoked(levels: int) -> str:
    """Return scenarios that invoke each other."""
    scenarios = [f"scenario s{n}:\n    do serial:\n        s{n - 1}()\n" for n in range(1, levels)]
    first = "scenario s0:\n    do serial:\n        log('inside')\n"
    return "".join([HEADER, first, *scenarios, f"scenario main:\n    do serial:\n        s{levels - 1}()\n"])


def waiters(number: int) -> str:
    """Return many waits for one event."""
    return parallel(*["wait @go"] * number, "serial:\n    wait elapsed(500ms)\n    log('sent')\n    emit go")


ROUNDS = 20


def ping(waiter_first: bool) -> str:
    """Return a sequence of events, logged by emitter and waiter."""
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
        """Observe a record of the trace."""
        if record["kind"] == "log":
            self.logged.append((time.perf_counter(), record["message"]))


class ProbeAtLog:
    """Takes a measurement when the first message is logged.

    Args:
        probe: Measures.
    """

    def __init__(self, probe: Callable[[], float]) -> None:
        self._probe = probe
        self.value = math.nan

    def record(self, record: dict[str, Any]) -> None:
        """Observe a record of the trace."""
        if record["kind"] == "log" and math.isnan(self.value):
            self.value = self._probe()


@dataclass(frozen=True)
class Ran:
    """Times of one run.

    Args:
        wall: Wall time, with the time before its start [s].
        processor: Processor time [s].
        ended: The processor time of this process at its end [s].
        start: Start time [s of `time.perf_counter`]; on the real clock only.
        duration: From its start to its end [s of its clock].
    """

    wall: float
    processor: float
    ended: float
    start: float
    duration: float


def prepare(text: str) -> tuple[Scenario, Plan]:
    """Load and lower a text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "main.osc"
        path.write_text(text)
        scenario = load(path)
        return scenario, lower(scenario.checked, "main")


def run(text: str, *, virtual: bool = False, observers: Sequence[Any] = ()) -> Ran:
    """Load and run a text; exit if it does not pass."""
    return run_plan(*prepare(text), virtual=virtual, observers=observers)


def run_plan(scenario: Scenario, plan: Plan, *, virtual: bool = False, observers: Sequence[Any] = ()) -> Ran:
    """Run a plan; exit if it does not pass."""
    clock = _CLOCKS.VirtualClock() if virtual else _CLOCKS.RealClock()

    async def carry() -> None:
        verdict = await Execution(plan, _settings(scenario, clock, observers)).run()
        if not verdict.passed:
            raise SystemExit(f"it {verdict.status.value}: {verdict.reason}")

    before, processor = time.perf_counter(), time.process_time()
    asyncio.run(carry())
    after, ended = time.perf_counter(), time.process_time()
    duration = clock.now()
    return Ran(after - before, ended - processor, ended, after - duration, duration)


def _settings(scenario: Scenario, clock: Any, observers: Sequence[Any] = ()) -> Any:
    functions = scenario.functions
    return _SETTINGS.Settings(
        seed=0, clock=clock, observers=observers, actions=functions.actions, modifiers=functions.modifiers
    )


def run_logged(text: str) -> tuple[Ran, list[tuple[float, str]]]:
    """Run a text on the real clock; also return its log messages with times after the start [s]."""
    stamps = Stamps()
    ran = run(text, observers=[stamps])
    return ran, [(at - ran.start, message) for at, message in stamps.logged]


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
        execution = Execution(plan, _settings(scenario, _CLOCKS.RealClock()))
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
    found = [each for first in (False, True) for each in delays(run_logged(ping(first))[1])]
    return {"value": max(found) * 1000}


def one_event(number: int) -> dict[str, float]:
    """From an event to the end of the last who waited for it."""
    ran, logged = run_logged(waiters(number))
    return {"value": ran.duration - logged[0][0], "processor, from the start": ran.processor}


def lateness() -> dict[str, float]:
    """Of timers of the real clock, after they are due; the first when all have long been started."""
    dues = [0.5 + 0.01 * n + 0.0003 * (n % 7) for n in range(300)]
    members = [f"serial:\n    wait elapsed({due:.4f}s)\n    log('{due:.4f}')" for due in dues]
    late = sorted(at - float(due) for at, due in run_logged(parallel(*members))[1])
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


def length(text: str, *, virtual: bool) -> Callable[[], dict[str, float]]:
    """Measure the time of a run."""

    def measure() -> dict[str, float]:
        ran = run(text, virtual=virtual)
        return {"value": ran.wall, "processor": ran.processor}

    return measure


def rate() -> dict[str, float]:
    """Wake-ups of timers in a second of the machine's."""
    number = 50_000
    ran = run(serial(*["wait elapsed(1s)"] * number), virtual=True)
    return {"value": number / ran.wall, "a second of processor": number / ran.processor}
