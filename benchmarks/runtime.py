"""Cost of the runtime (waits, reactions, steps, timers, nesting), compared with `scenario-execution`.

    python benchmarks/runtime.py [CASE ...] [--peer PYTHON | --install-peer]
    python benchmarks/runtime.py [CASE ...] --against CHECKOUT [--rounds N] [--peer PYTHON | --install-peer]

Each case runs in its own process, from the plan to the verdict, with the garbage collector settings of `seoro
exec`. The trace is read only where the measurement needs it. Processor time is printed beside wall time where
it
matters: on a busy machine, it is less.

The times of the peer are those in its log, from the start of a scenario to its end, without loading. Cases that
would take it minutes are smaller, as the table shows.

`--against` measures other cases, in turn with the seoro of another checkout; see `runtime_against.py`.
"""

from __future__ import annotations

import argparse
import gc
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import peer
import runtime_against
from runtime_cases import (
    COLLECTOR,
    delays,
    growth,
    invoked,
    lateness,
    length,
    nested,
    one_event,
    parallel,
    ping,
    rate,
    reaction,
    serial,
    side_by_side,
    waiters,
    waiting,
)

# ---------------------------------------------------------------- the peer


def peer_run(python: str, text: str) -> list[tuple[float, str]]:
    """Return the log of the peer after the start of the scenario; empty if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "main.osc"
        path.write_text(text)
        stamps = peer.stamps(python, path)
    start = next((at for at, message in stamps if message.startswith("Executing")), 0.0)
    return [(at - start, message) for at, message in stamps]


def peer_length(text: str) -> Callable[[str], float | None]:
    """Return the time of the peer from the start of a scenario to its end."""
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
        goal: Target, as a minimum or a maximum.
        own: Measures.
        other: Measures the peer; None if it has nothing like it.
        less: Size of the case for the peer.
    """

    what: str
    unit: str
    goal: tuple[str, float]
    own: Callable[[], dict[str, float]]
    other: Callable[[str], float | None] | None = None
    less: str = ""


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
    parser = argparse.ArgumentParser(description="Measure the cost of the runtime.")
    known = f"of {', '.join(CASES)}; with --against, of {', '.join(runtime_against.ROWS)} (default: all)"
    parser.add_argument("cases", nargs="*", metavar="CASE", help=known)
    peer.add_peer_arguments(parser)
    runtime_against.add_arguments(parser)
    parser.add_argument("--once", choices=CASES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.once:
        gc.set_threshold(*COLLECTOR)
        print(json.dumps(CASES[options.once].own()))
        return
    unknown = set(options.cases) - set(CASES if options.against is None else runtime_against.ROWS)
    if unknown:
        parser.error(f"unknown case `{min(unknown)}`; expected one {known}")
    python = peer.peer_of(options)
    if options.against is not None:
        runtime_against.compare(
            options.against, options.cases or list(runtime_against.ROWS), options.rounds, python
        )
        return
    print(f"{'':42} {'here':>12} {'goal':>14} {'':8} {'peer':>18}")
    for name in options.cases or CASES:
        report(name, python)


if __name__ == "__main__":
    main()
