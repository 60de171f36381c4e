"""Shares of expected ends of all scenarios, with many seeds, in all engines.

    python benchmarks/seeds.py [--results FILE] [--seeds 30] [--first 1000] [--sim NAME] [FILE ...]

Prints a table of scenarios and engines, summarised in `docs/reference/scenarios.md`. Runs are appended to the
results, a file of JSON lines, and not repeated while their scenario file stays the same. So an interrupted
benchmark continues when it is called again. After any other change, name a new file. `--table` prints the table of
the results without runs. Runs are sequential, at low priority.
"""

from __future__ import annotations

import argparse
import asyncio
import hashlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from engines import PROJECT, directives_of
from results import read_results, write_result

import seoro
from seoro.bridges.launch import SIMULATORS

LIMIT = 600.0  # [s] of wall time for a run
NICE = 15
NOT_SIMULATED = {"wait_for_a_topic.osc"}  # needs a ROS 2 system


@dataclass(frozen=True)
class Result:
    """End of a run.

    Args:
        scenario: Its file, in the project.
        digest: Of the text of the file.
        engine: The engine.
        seed: Its seed.
        status: Status of the run; `none` if it has no verdict.
        reason: Reason of the verdict.
        good: Whether this is the end that the scenario expects.
        duration: On the clock of the simulator [s].
    """

    scenario: str
    digest: str
    engine: str
    seed: int
    status: str
    reason: str
    good: bool
    duration: float

    @property
    def key(self) -> tuple[str, str, str, int]:
        """Identity of the run: results with the same key are of the same run."""
        return self.scenario, self.digest, self.engine, self.seed


def digest_of(file: Path) -> str:
    """Return a digest of the text of a file."""
    return hashlib.sha256(file.read_bytes()).hexdigest()[:16]


@contextmanager
def node(engine: str) -> Iterator[str]:
    """Run a simulator node during the block; yields its endpoint."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    command = [sys.executable, "-m", "seoro", "sim", engine, "--listen", endpoint]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout is not None
        if not process.stdout.readline():  # written by the simulator when it is ready
            raise RuntimeError(f"the node of {engine} did not start: try `seoro sim {engine}`")
        try:
            yield endpoint
        finally:
            process.terminate()


async def run(file: Path, engine: str, seed: int, endpoint: str) -> Result:
    """Run a scenario on a node."""
    directives = directives_of(file)
    simulator = seoro.Simulator(endpoint=endpoint, world=_world(file, directives.world or "maze"))
    name, digest = str(file.relative_to(PROJECT)), digest_of(file)
    try:
        async with asyncio.timeout(LIMIT):
            async with seoro.start(seoro.load(str(file)), seed=seed, simulator=simulator) as started:
                verdict = await started.result()
    except (seoro.SeoroError, TimeoutError) as error:
        return Result(name, digest, engine, seed, "none", str(error) or f"no end in {LIMIT:g} s", False, 0.0)
    good = verdict.status.value == directives.expect and directives.reason in verdict.reason
    return Result(
        name, digest, engine, seed, verdict.status.value, verdict.reason, good, round(verdict.duration, 3)
    )


def _world(file: Path, world: str) -> str:
    """A world by its name, or the path of its file, which stands beside the scenario."""
    return str(file.parent / world) if world.endswith(".yaml") else world


def read(results: Path) -> list[Result]:
    """Return the stored results of the present files."""
    found = read_results(results, Result)
    return [each for each in found if digest_of(PROJECT / each.scenario) == each.digest]


def carry_out(files: Sequence[Path], engine: str, seed: int, results: Path) -> None:
    """Execute the missing runs of a seed on one node."""
    done = {each.key for each in read(results)}
    missing = [
        file for file in files if (str(file.relative_to(PROJECT)), digest_of(file), engine, seed) not in done
    ]
    if not missing:
        return
    with node(engine) as endpoint, results.open("a") as out:
        for file in missing:
            result = asyncio.run(run(file, engine, seed, endpoint))
            write_result(out, result)
            if not result.good:
                print(f"{result.scenario} {engine} {seed}: {result.status}: {result.reason}", flush=True)


def table(results: Sequence[Result], engines: Sequence[str]) -> Iterator[str]:
    """Return the lines of the table; engines without results are omitted."""
    engines = [engine for engine in engines if any(each.engine == engine for each in results)]
    yield f"| scenario | {' | '.join(engines)} |"
    yield f"|---|{'---|' * len(engines)}"
    for name in sorted({each.scenario for each in results}):
        cells = []
        for engine in engines:
            good = [each.good for each in results if (each.scenario, each.engine) == (name, engine)]
            cells.append(f"{sum(good)} of {len(good)}" if good else "")
        yield f"| `{name.removeprefix('scenarios/').removesuffix('.osc')}` | {' | '.join(cells)} |"


def main() -> int:
    """Make the runs and print the table; exit with 1 if a run did not end as expected."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument(
        "files", nargs="*", type=Path, metavar="FILE", help="scenarios (default: all of the project)"
    )
    parser.add_argument("--results", type=Path, default=Path("seeds.jsonl"), metavar="FILE")
    parser.add_argument("--seeds", type=int, default=30, metavar="N", help="how many (default: 30)")
    parser.add_argument("--first", type=int, default=1000, metavar="N", help="the first of them (default: 1000)")
    parser.add_argument("--sim", choices=SIMULATORS, action="append", help="an engine (repeatable, default: all)")
    parser.add_argument("--table", action="store_true", help="print the table of the results without runs")
    options = parser.parse_args()

    simulated = sorted(each for each in (PROJECT / "scenarios").rglob("*.osc") if each.name not in NOT_SIMULATED)
    files = [file.resolve() for file in options.files] or simulated
    engines = options.sim or list(SIMULATORS)
    if not options.table:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that the node is stopped, too
        os.nice(NICE)
        for seed in range(options.first, options.first + options.seeds):
            for engine in engines:
                carry_out(files, engine, seed, options.results)
    found = read(options.results)
    if not found:
        print(f"no results in {options.results}")
        return 0
    print("\n".join(table(found, engines)))
    return 0 if all(each.good for each in found) else 1


if __name__ == "__main__":
    sys.exit(main())
