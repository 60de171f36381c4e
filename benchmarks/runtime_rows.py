"""One measurement of `runtime_against.py`, in this process, with the `seoro` that PYTHONPATH names.

PYTHONPATH=CHECKOUT python benchmarks/runtime_rows.py ROW
"""

from __future__ import annotations

import gc
import sys
import time
import tracemalloc
from collections.abc import Callable, Mapping
from statistics import median
from typing import Final

from runtime_cases import COLLECTOR, HEADER, ProbeAtLog, parallel, prepare, rate, reaction, run, run_plan, waiters

NUMBER: Final = 10_000  # of branches

# Two runs of this are "twice": the figure is of one.
SMALL: Final = f"""{HEADER}scenario main:
    do parallel:
        wait elapsed(1s)
        wait elapsed(2s)
    with:
        repeat(3000)
"""


def side() -> float:
    """Processor time of waits side by side on the virtual clock [s]."""
    return run(parallel(*["wait elapsed(1s)"] * NUMBER), virtual=True).processor


def event() -> float:
    """Processor time of a run in which one event ends all waits [s]."""
    return run(waiters(NUMBER), virtual=True).processor


def emission() -> float:
    """Processor time from the emission to the end of the run, the median of three runs [s].

    The garbage collector is off meanwhile: a pass takes a fifth of this time, and whether one falls into it
    depends on how much was allocated before.
    """
    scenario, plan = prepare(waiters(NUMBER))
    taken = []
    for _ in range(3):
        probe = ProbeAtLog(_time_without_collector)
        taken.append(run_plan(scenario, plan, virtual=True, observers=[probe]).ended - probe.value)
        gc.enable()
    return median(taken)


def _time_without_collector() -> float:
    gc.disable()
    return time.process_time()


def small() -> float:
    """Processor time of many small compositions, of two runs in turn the mean [s]."""
    scenario, plan = prepare(SMALL)
    return sum(run_plan(scenario, plan, virtual=True).processor for _ in range(2)) / 2


def wakeups() -> float:
    """Wake-ups on the virtual clock in a second of processor time [1/s]."""
    return rate()["a second of processor"]


def longest_reaction() -> float:
    """Longest time from an event to the reaction on the real clock [ms]."""
    return reaction()["value"]


def memory() -> float:
    """Memory that Python allocates for a run while all branches wait, for each [B]."""
    branches = ["wait elapsed(1s)"] * NUMBER
    scenario, plan = prepare(parallel(*branches, "serial:\n    wait elapsed(500ms)\n    log('waiting')"))
    probe = ProbeAtLog(lambda: tracemalloc.get_traced_memory()[0])
    tracemalloc.start()
    run_plan(scenario, plan, virtual=True, observers=[probe])
    return probe.value / NUMBER


MEASURES: Final[Mapping[str, Callable[[], float]]] = {
    "side": side,
    "event": event,
    "emission": emission,
    "small": small,
    "wakeups": wakeups,
    "reaction": longest_reaction,
    "memory": memory,
}

if __name__ == "__main__":
    gc.set_threshold(*COLLECTOR)
    print(MEASURES[sys.argv[1]]())
