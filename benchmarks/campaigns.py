"""Measurements of campaigns: `python -m benchmarks.campaigns PART`.

Part `intervals`: how often intervals exclude the true rate, and how many runs a test needs.
Part `search`: runs until the first failure of each strategy, for failures planted in one place and in four.
Part `covering`: rows and processor time of covering arrays.
Part `shrink`: runs to shrink planted failures of five parameters.
Part `compare`: how often comparisons of two campaigns find a planted regression, and how often they err.
Part `rank`: processor time of the choice of runs that keep all buckets.
Part `report`: processor time and memory of the results of many runs.
Part `rate`: processor time of campaigns of short runs, of all their processes, and time to the first row.
Part `overhead`: processor time of a campaign in simulators, beyond that of its simulators.
"""

from __future__ import annotations

import argparse
import asyncio
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from random import Random
from typing import Final

from seoro.campaign.after.shrinking import Shrinking
from seoro.campaign.comparison.comparing import Outcome
from seoro.campaign.comparison.comparing import compare as compare_campaigns
from seoro.campaign.pool.simulators import simulator_node
from seoro.campaign.ranking import Ranking
from seoro.campaign.report.page import REPORT, write_report
from seoro.campaign.results.files import write_results
from seoro.campaign.runs import End, Row
from seoro.campaign.statistics.rates import fixed_bounds, live_bounds
from seoro.campaign.statistics.sequential_test import SequentialTest
from seoro.campaign.store.folder import read_rows
from seoro.campaign.strategies.contract import Strategy
from seoro.campaign.strategies.covering import covering_rows
from seoro.campaign.strategies.latin import Latin
from seoro.campaign.strategies.optimizers import CmaEs, Tpe
from seoro.campaign.strategies.random import Uniform
from seoro.campaign.strategies.search import Search
from seoro.campaign.strategies.sobol import Sobol
from tests.campaign.compared import draw_ends, rows, write
from tests.campaign.generated import generate
from tests.campaign.planted import COLUMN, in_four_places, in_one_place, runs_until_failure
from tests.campaign.shrunk import FAILURE, carry_out, planted
from tests.campaign.statistics.exact import decisions, probability_of_exclusion

CAMPAIGN = [sys.executable, "-m", "seoro", "campaign", "run"]
OBSTACLE = "scenarios/navigation/obstacle.osc"
TRIVIAL = """import osc.types
import osc.helpers

scenario trivial:
    pause: time with:
        keep(it in [1s, 2s, 3s, 4s, 5s, 6s, 7s, 8s])
    load: float with:
        keep(it in [0.0..1.0])
    cover(load, range: [0..1], every: 0.1)
    record(pause, unit: s)
    do serial:
        wait elapsed(pause)
        compare(load, "<", 0.9)
"""
RATES = (0.5, 0.9, 0.97)
MOST = 400  # runs of a search
ARRAYS = ((10, 4, 2), (20, 5, 2), (8, 3, 3), (10, 4, 3))  # parameters, values, strength
TEST = SequentialTest(good=0.97, bad=0.90)


def intervals(runs: int) -> None:
    """Print exact probabilities for campaigns whose runs pass independently with a rate.

    Args:
        runs: Number of runs, after each of which the interval is read.
    """
    print(f"95 % interval read after each of {runs:,} runs; it excludes the true rate at some time:")
    for rate in RATES:
        live, naive = (probability_of_exclusion(each, rate, runs) for each in (live_bounds, fixed_bounds))
        print(f"  rate {rate}: confidence sequence {live:.1%}, Clopper-Pearson {naive:.1%}", flush=True)
    print(f"test of {TEST.good} against {TEST.bad}, errors {TEST.errors}:")
    for rate in (0.8, TEST.bad, 0.93, 0.95, TEST.good, 0.99):
        accepted, mean = decisions(TEST, rate)
        print(f"  rate {rate}: decides for {TEST.good} in {accepted:.1%}, after {mean:.0f} runs on average")


def search(repetitions: int) -> None:
    """Print the runs until the first failure."""
    learning: tuple[Strategy, ...] = (Search(COLUMN), Tpe(COLUMN), CmaEs(COLUMN))
    strategies: tuple[Strategy, ...] = (Uniform(), Sobol(), Latin(MOST), *learning)
    for title, place in (("0.26 % fails, in one place", in_one_place), ("1.25 %, in four places", in_four_places)):
        print(f"{title}\n{'strategy':10} {'median':>7} {'90 %':>7} {'found':>10} {'ms a run':>9}")
        for strategy in strategies:
            begun = time.process_time()
            runs = [runs_until_failure(strategy, place(seed), seed, MOST) for seed in range(repetitions)]
            cost = (time.process_time() - begun) / sum(runs) * 1000
            found = sum(number <= MOST for number in runs)
            shown = f"{statistics.median(runs):7.0f} {sorted(runs)[int(0.9 * repetitions)]:7}"
            print(f"{strategy.name:10} {shown} {found:4} of {repetitions} {cost:9.3f}", flush=True)


def covering(repetitions: int) -> None:
    """Print the sizes of covering arrays."""
    for number, values, strength in ARRAYS:
        begun = time.process_time()
        sizes = [
            len(list(covering_rows([values] * number, strength, seed, lambda _: True)))
            for seed in range(repetitions)
        ]
        cost = (time.process_time() - begun) / repetitions
        print(
            f"{number} parameters with {values} values, {strength} at a time: "
            f"{min(sizes)} to {max(sizes)} rows, {cost:.2f} s"
        )


def shrink(repetitions: int) -> None:
    """Print the runs to shrink planted failures."""
    for kind, name in enumerate(("two limits", "a limit of a sum", "a small box")):
        runs = []
        for seed in range(repetitions):
            fails, values = planted(3 * seed + kind)
            runs.append(len(carry_out(Shrinking(1, values, FAILURE), fails)))
        print(f"{name:16}: median {statistics.median(runs):.0f} runs, at most {max(runs)}")


def compare(repetitions: int) -> None:
    """Print how often comparisons call a campaign worse."""
    cases = {
        "3 % of runs newly fail": {"broken": 0.03},
        "the same, and half of the runs change by chance": {"broken": 0.03, "unstable": 0.5},
        "half of the runs change by chance": {"unstable": 0.5},
    }
    for title, case in cases.items():
        for is_paired in (True, False):
            found = Counter(_outcome(Random(seed), case, is_paired) for seed in range(repetitions))
            shares = ", ".join(f"{each.value} {found[each] / repetitions:.0%}" for each in Outcome)
            print(f"300 {'pairs' if is_paired else 'independent runs each'}, {title}: {shares}", flush=True)


def _outcome(random: Random, case: dict[str, float], is_paired: bool) -> Outcome:
    first, second = draw_ends(random, 300, **case)
    with tempfile.TemporaryDirectory() as folder:
        before = write(Path(folder) / "before", rows(first))
        after = write(Path(folder) / "after", rows(second, 1 if is_paired else 1000))
        return compare_campaigns(before, after).outcome


def rank(runs: int) -> None:
    """Print what the choice among generated runs takes, of which each has 30 of 300 buckets, some of them rare."""
    draw, weights = Random(1), [1 / number for number in range(1, 301)]
    ranking = Ranking()
    for number in range(1, runs + 1):
        buckets = {str(bucket): 1 for bucket in draw.choices(range(300), weights, k=30)}
        item = {"item": "a", "kind": "cover", "buckets": buckets, "total": 300}
        ranking.add(Row(number, "", number, 1, 1, End.PASSED, coverage=(item,)))
    begun = time.process_time()
    chosen = ranking.chosen()
    taken = time.process_time() - begun
    print(f"{len(chosen)} of {runs:,} runs keep all {ranking.buckets} buckets: {taken:.3f} s")


def report(runs: int) -> None:
    """Print what the results of a campaign with generated rows take; the memory is that of the process.

    Args:
        runs: Number of rows.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        generate(folder, runs)
        for write, what in ((write_report, "report"), (write_results, "report, tables and JUnit")):
            begun = time.process_time()
            write(folder)
            taken, size = time.process_time() - begun, (folder / REPORT).stat().st_size
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(
                f"{what} of {runs:,} runs: {taken:.1f} s, {memory:.0f} MB; report.html {size:,} bytes", flush=True
            )


def _processor_time(command: list[str]) -> float:
    """Run a command; returns the processor time of its processes [s]."""
    before = _of_children()
    subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    return _of_children() - before


def _of_children() -> float:
    """Return the processor time of ended child processes [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def rate(runs: int) -> None:
    """Print what short runs take, with one worker.

    Args:
        runs: Number of runs.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trivial.osc"
        file.write_text(TRIVIAL)
        command = [*CAMPAIGN, str(file), "--clock", "virtual", "--seed", "1"]
        for number, wanted in ((1, "one run"), (runs, f"{runs:,} runs")):
            out = Path(folder) / str(number)
            begun = time.time()
            options = ["--levels", "125000", "--runs", str(number), "-j", "1", "--keep", "none", "-o", str(out)]
            taken = _processor_time([*command, *options])
            first = min(datetime.fromisoformat(row.started).timestamp() for row in read_rows(out)) - begun
            print(
                f"{wanted}: {taken:.2f} s, {number / taken:.0f} runs per s; the first begins after {first:.2f} s"
            )


def overhead(runs: int) -> None:
    """Print what a campaign takes beside its simulators.

    Args:
        runs: Number of runs; at least 100, since a start takes as long as a run.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        options = ["--rate", "max", "--seed", "1", "--strategy", "random", "--runs", str(runs), "-o", str(out)]
        taken = _processor_time([*CAMPAIGN, OBSTACLE, "--sim", "mujoco", *options, "-j", "1"])
        rows = list(read_rows(out))
    start, simulated, made = _start_of_simulator(), sum(row.sim_cpu for row in rows), sum(row.cpu for row in rows)
    print(f"{len(rows)} runs: {taken:.1f} s, of this the simulator {start:.1f} and {simulated:.1f} s")
    print(f"processes of runs: {made:.1f} s")
    print(
        f"beyond the simulator: {taken / (start + simulated) - 1:.1%}; with its start: {taken / simulated - 1:.1%}"
    )


def _start_of_simulator() -> float:
    """Return the processor time of the start and the end of a simulator [s]."""

    async def start() -> None:
        async with simulator_node("mujoco"):
            pass

    before = _of_children()
    asyncio.run(start())
    return _of_children() - before


_OF_RUNS: Final[Mapping[str, Callable[[int], None]]] = {
    "intervals": intervals,
    "report": report,
    "rate": rate,
    "overhead": overhead,
    "rank": rank,
}
_OF_REPETITIONS: Final[Mapping[str, Callable[[int], None]]] = {
    "search": search,
    "covering": covering,
    "compare": compare,
    "shrink": shrink,
}


def main() -> None:
    """Run a part."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=[*_OF_RUNS, *_OF_REPETITIONS])
    parser.add_argument("--runs", type=int, default=2000, help=f"of {', '.join(_OF_RUNS)}")
    parser.add_argument("--repetitions", type=int, default=100, help=f"of {', '.join(_OF_REPETITIONS)}")
    options = parser.parse_args()
    if options.part in _OF_RUNS:
        _OF_RUNS[options.part](options.runs)
    else:
        _OF_REPETITIONS[options.part](options.repetitions)


if __name__ == "__main__":
    main()
