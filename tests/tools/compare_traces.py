"""Compare runs of the same scenarios in another checkout and this one: traces, output and exit status.

    python tests/tools/compare_traces.py CHECKOUT [--cases FOLDER] [--quick] [--simulators NAME,...] [PATTERN ...]

Runs the conformance cases of a folder and the scenarios of this project with the seed 0. Each checkout has one
process that runs all scenarios in turn. Records, printed lines, exit status and names of files have to be the
same, byte for byte, except for what `VOLATILE` in `trace_files.py` lists with reasons.
Prints the first difference of each scenario. Exit status: 0 all are the same, 1 there are differences.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # as a script, only its own folder is in the path

from tests.tools.trace_files import first_difference
from tests.tools.trace_runs import PROJECT, Run, conformance_runs, project_runs
from tests.tools.workers import Worker, WorkerFailed

COMPARED: Final = ("trace.jsonl", "stdout", "stderr", "coverage.json")
SHOWN: Final = 600  # characters of a line that differs


@dataclass(frozen=True)
class Compared:
    """A run in both checkouts.

    Args:
        run: The command line.
        status: Its exit status in this checkout.
        differences: A description of each output that differs.
    """

    run: Run
    status: str
    differences: list[str]


class Comparison:
    """Runs scenarios in two checkouts and compares their traces and output.

    Args:
        checkouts: The other one and this one.
        folder: Folder for output.
        limit: Wall time of a run [s].
    """

    def __init__(self, checkouts: tuple[Path, Path], folder: Path, limit: float) -> None:
        self._checkouts = checkouts
        self._workers = [Worker(checkout, limit) for checkout in checkouts]
        self._folder = folder

    def compare(self, runs: Sequence[Run]) -> Iterator[Compared]:
        """Run scenarios in both checkouts and compare them. While one is compared, the next one runs."""
        before: tuple[Run, list[Path], list[str]] | None = None
        for number, run in enumerate(runs):
            folders = [self._folder / f"{number}-{where}" for where in ("there", "here")]
            for worker, folder in zip(self._workers, folders, strict=True):
                folder.mkdir()
                output = ("-o", str(folder / "out")) if run.has_output else ()
                worker.send([*run.arguments, *output], folder)
            if before is not None:
                yield self._compared(*before)
            before = run, folders, [worker.receive() for worker in self._workers]
        if before is not None:
            yield self._compared(*before)

    def stop(self) -> None:
        """End the processes."""
        for worker in self._workers:
            worker.stop()

    def _compared(self, run: Run, folders: Sequence[Path], statuses: Sequence[str]) -> Compared:
        found = [] if statuses[0] == statuses[1] else [f"exit status: there {statuses[0]}, here {statuses[1]}"]
        found += self._different_files(folders)
        for folder in folders:
            shutil.rmtree(folder)
        return Compared(run, statuses[1], found)

    def _different_files(self, folders: Sequence[Path]) -> Iterator[str]:
        # Files of this checkout are run in both, so that its path occurs in both. Longer paths come first.
        checkouts = sorted((str(checkout.resolve()) for checkout in self._checkouts), key=len, reverse=True)
        places = {str(folder): "OUTPUT" for folder in folders} | dict.fromkeys(checkouts, "CHECKOUT")
        for name in COMPARED:
            difference = first_difference(_file(folders[0], name), _file(folders[1], name), places)
            if difference is not None:
                number, one, other = difference
                yield f"{name}:{number}:\n    there {_cut(one)}\n    here  {_cut(other)}"
        names = [sorted(path.name for path in (folder / "out").glob("*")) for folder in folders]
        if names[0] != names[1]:
            yield f"files: there {names[0]}, here {names[1]}"


def _file(folder: Path, name: str) -> Path:
    """Return the path of a file of a run: its stdout or stderr, or a file of its output folder."""
    return folder / name if name in ("stdout", "stderr") else folder / "out" / name


def _cut(line: str | None) -> str:
    if line is None:
        return "(nothing)"
    return line if len(line) <= SHOWN else f"{line[:SHOWN]}..."


def compare(checkouts: tuple[Path, Path], runs: Sequence[Run], limit: float) -> list[Compared]:
    """Compare runs and print each difference.

    Args:
        checkouts: The other one and this one.
        runs: The command lines.
        limit: Wall time of a run [s].

    Raises:
        WorkerFailed: A checkout cannot be run.
    """
    compared: list[Compared] = []
    with tempfile.TemporaryDirectory(prefix="seoro-traces-") as folder:
        comparison = Comparison(checkouts, Path(folder), limit)
        try:
            for each in comparison.compare(runs):
                compared.append(each)
                if each.differences:
                    print(f"DIFFERENT {each.run.name}", *each.differences, sep="\n  ", flush=True)
        finally:
            comparison.stop()
    return compared


def _runs(options: argparse.Namespace) -> list[Run]:
    """The runs that the options ask for."""
    simulators = [] if options.quick else options.simulators.split(",")
    runs = [*project_runs(simulators)]
    if options.cases is not None:
        runs += conformance_runs(options.cases)
    return [run for run in runs if not options.patterns or any(each in run.name for each in options.patterns)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, and return the exit status."""
    parser = argparse.ArgumentParser(description="Compare traces of another checkout and of this one.")
    parser.add_argument("checkout", type=Path, metavar="CHECKOUT", help="folder of the other checkout")
    parser.add_argument("patterns", nargs="*", metavar="PATTERN", help="parts of names to run (default: all)")
    parser.add_argument("--cases", type=Path, metavar="FOLDER", help="folder of a conformance suite with a run.py")
    parser.add_argument("--quick", action="store_true", help="leave out scenarios that need a simulator")
    parser.add_argument(
        "--simulators", default="mujoco", metavar="NAME,...", help="simulators to use (default: %(default)s)"
    )
    parser.add_argument("--limit", type=float, default=120.0, metavar="SECONDS", help="for a run (default: 120)")
    options = parser.parse_intermixed_args(arguments)
    runs = _runs(options)
    if not runs:
        parser.error("nothing to compare")
    began = time.monotonic()
    try:
        compared = compare((options.checkout, PROJECT), runs, options.limit)
    except WorkerFailed as failure:
        parser.error(str(failure))
    different = sum(bool(each.differences) for each in compared)
    statuses = Counter(each.status for each in compared)
    ended = ", ".join(f"{number} with {status}" for status, number in sorted(statuses.items()))
    took = time.monotonic() - began
    print(
        f"{len(compared) - different} the same, {different} different in {took:.0f} s; exit status here: {ended}"
    )
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
