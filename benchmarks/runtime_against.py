"""Rows of `runtime.py --against CHECKOUT`: what the runtime costs, in turn with another checkout of seoro.

Each measurement runs in a process of its own, with the same interpreter and installed packages for both checkouts;
only `seoro` comes from one or the other. Compiled modules are written before. In each round, the other
checkout is measured first, then this one. The table has medians and, in brackets, the least and the largest value;
the ratio is the median of the ratios of the rounds. Times are of the processor, except for `reaction`, whose ratio
is that of the medians: other load prolongs a few of its rounds by a multiple.

The targets were set on another machine, beside the figures of the starting commit there. If an absolute target
depends on the machine, its ratio to that figure is the target here.
"""

from __future__ import annotations

import argparse
import compileall
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import peer
from startup import HELLO, measure

PROJECT: Final = Path(__file__).resolve().parents[1]
ROWS_SCRIPT: Final = Path(__file__).with_name("runtime_rows.py")
LIMIT: Final = 600.0  # [s] of wall time for a measurement
STARTS: Final = 5  # the median of these is one measurement of `start`

_EXEC: Final = "import sys; from seoro.cli.main import run_process; sys.exit(run_process())"
_COUNT: Final = (
    "import sys; before = len(sys.modules); from seoro.cli.main import run_process; status = run_process(); "
    "print(len(sys.modules) - before, file=sys.stderr); sys.exit(status)"
)


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Args:
        what: Title.
        unit: Of the figures.
        before: Figure of the starting commit on the machine where the targets were set.
        must: Figure that has to be reached there.
        goal: Figure that is aimed at there.
        is_rate: Whether more is better.
        is_wall: Whether it is a time of the wall clock.
    """

    what: str
    unit: str
    before: float
    must: float
    goal: float
    is_rate: bool = False
    is_wall: bool = False

    def ratio(self, there: Sequence[float], here: Sequence[float]) -> float:
        """Compare the figures of this checkout with those of the other one, round by round."""
        if self.is_wall:
            return statistics.median(here) / statistics.median(there)
        return statistics.median(ours / theirs for theirs, ours in zip(there, here, strict=True))

    def mark(self, ratio: float) -> str:
        """Return the reached target of a ratio to the other checkout."""
        sign = -1 if self.is_rate else 1
        reached = [sign * ratio <= sign * figure / self.before for figure in (self.must, self.goal)]
        return "goal" if all(reached) else "must" if reached[0] else "MISSED"


ROWS: Final[Mapping[str, Row]] = {
    "side": Row("10,000 waits of 1 s side by side, virtual clock", "s", 1.16, 0.9, 0.6),
    "event": Row("one event, 10,000 wait for it: whole run", "s", 1.73, 1.3, 0.9),
    "emission": Row("from that emission to the end of the run", "s", 0.32, 0.25, 0.15),
    "small": Row("3,000 times `parallel` of two waits", "s", 0.89, 0.8, 0.5),
    "wakeups": Row("wake-ups a second, virtual clock", "1/s", 60_000, 80_000, 120_000, is_rate=True),
    "reaction": Row("event to reaction, longest of 40, real clock", "ms", 0.32, 0.32, 0.2, is_wall=True),
    "start": Row("`seoro exec` of three lines", "s", 0.41, 0.33, 0.25),  # in times of the peer
    "modules": Row("modules imported for that, again", "", 428, 300, 220),
    "memory": Row("memory of a waiting branch, of 10,000", "B", 5900, 5000, 3500),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of a comparison."""
    parser.add_argument(
        "--against", type=Path, metavar="CHECKOUT", help="measure in turn with the seoro of another checkout"
    )
    parser.add_argument(
        "--rounds", type=int, default=5, metavar="N", help="of a comparison (default: %(default)s)"
    )


# ---------------------------------------------------------------- measuring


def compare(checkout: Path, names: Sequence[str], rounds: int, peer_python: str | None) -> None:
    """Measure rows in two checkouts and print the table.

    Args:
        checkout: The other one; this one is that of this file.
        names: Of the rows.
        rounds: Measurements of each row in each checkout.
        peer_python: Interpreter of an environment with `scenario-execution`; None to leave it out.
    """
    checkouts = (checkout.resolve(), PROJECT)
    for each in checkouts:
        check_checkout(each)
        compileall.compile_dir(each / "seoro", quiet=2)
    print(f"{'':48} {'there':>25} {'here':>25} {'ratio':>6}  {'must':>24} {'goal':>24}")
    for name in names:
        row = ROWS[name]
        there, here, beside = _measure_in_turn(name, checkouts, rounds, peer_python if name == "start" else None)
        print(_line(row, there, here), flush=True)
        if beside:
            print(_peer_line(row, there, here, beside), flush=True)


def check_checkout(checkout: Path) -> None:
    """Exit unless the interpreter takes `seoro` from a checkout when it comes first in PYTHONPATH."""
    code = "import seoro; print(seoro.__file__)"
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", code],
            check=False,
            capture_output=True,
            text=True,
            cwd=folder,
            env=environment(checkout),
        )
    found = done.stdout.strip() or done.stderr.strip().rpartition("\n")[2]
    if done.returncode != 0 or not Path(found).resolve().is_relative_to(checkout.resolve()):
        raise SystemExit(
            f"{sys.executable} does not import seoro from {checkout} (got {found}); "
            "expected a folder with the package `seoro`, and no installation that precedes PYTHONPATH"
        )


def environment(checkout: Path, seed: int = 0) -> dict[str, str]:
    """Environment of a process that imports `seoro` from a checkout.

    Args:
        checkout: The checkout.
        seed: Of the hashes of strings.
    """
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, "PYTHONPATH": str(checkout), "PYTHONHASHSEED": str(seed)}


def _measure_in_turn(
    name: str, checkouts: tuple[Path, Path], rounds: int, peer_python: str | None
) -> tuple[list[float], list[float], list[float]]:
    """Return the figures of a row in the other checkout, in this one, and of the peer, one for each round."""
    there, here, beside = [], [], []
    for number in range(rounds):
        there.append(_measured(name, environment(checkouts[0], number)))
        here.append(_measured(name, environment(checkouts[1], number)))
        if peer_python is not None:
            beside.append(_start_time(peer.command(peer_python), dict(os.environ)))
    return there, here, beside


def _measured(name: str, variables: dict[str, str]) -> float:
    """Measure a row once, in a process of its own; exit if it fails."""
    if name == "start":
        return _start_time([sys.executable, "-c", _EXEC, "exec"], variables)
    with tempfile.TemporaryDirectory() as folder:
        hello = _hello(folder)
        command = [sys.executable, str(ROWS_SCRIPT), name]
        if name == "modules":
            command = [sys.executable, "-c", _COUNT, "exec", str(hello)]
        for _ in range(2 if name == "modules" else 1):  # the first run of a file caches its plan
            done = subprocess.run(
                command, check=False, capture_output=True, text=True, timeout=LIMIT, cwd=folder, env=variables
            )
    if done.returncode != 0:
        raise SystemExit(f"`{name}` failed in {variables['PYTHONPATH']}:\n{done.stderr}")
    output = done.stderr if name == "modules" else done.stdout
    return float(json.loads(output.splitlines()[-1]))


def _start_time(command: Sequence[str], variables: Mapping[str, str]) -> float:
    """Return the processor time of a command with a scenario of three lines [s]: the median of several."""
    with tempfile.TemporaryDirectory() as folder:
        hello = _hello(folder)
        return statistics.median(
            measure([*command, str(hello)], cwd=folder, env=variables)[1] for _ in range(STARTS)
        )


def _hello(folder: str) -> Path:
    path = Path(folder) / "hello.osc"
    path.write_text(HELLO)
    return path


# ---------------------------------------------------------------- the table


def _line(row: Row, there: Sequence[float], here: Sequence[float]) -> str:
    """The row with the figures of both checkouts."""
    ratio = row.ratio(there, here)
    figures = f"{_figures(there, row.unit):>25} {_figures(here, row.unit):>25} {ratio:6.2f}"
    targets = f"{_target(row, row.must):>24} {_target(row, row.goal):>24}"
    return f"{row.what:48} {figures}  {targets}  {row.mark(ratio)}"


def _peer_line(row: Row, there: Sequence[float], here: Sequence[float], beside: Sequence[float]) -> str:
    """The row with both checkouts in times of the peer."""
    beside_there, beside_here = (
        [own / other for own, other in zip(figures, beside, strict=True)] for figures in (there, here)
    )
    ratio = statistics.median(beside_here)
    figures = f"{_figures(beside_there, 'x'):>25} {_figures(beside_here, 'x'):>25} {'':6}"
    mark = row.mark(ratio / row.before)
    return (
        f"{f'  in times of {peer.PEER}':48} {figures}  {f'<= {row.must:g}':>24} {f'<= {row.goal:g}':>24}  {mark}"
    )


def _target(row: Row, figure: float) -> str:
    """A target as a ratio, with the figures that it comes from."""
    relation = ">=" if row.is_rate else "<="
    return f"{relation} {figure / row.before:.2f} ({figure:g}/{row.before:g})"


def _figures(values: Sequence[float], unit: str) -> str:
    """Return median, minimum and maximum."""
    return f"{_number(statistics.median(values))} {unit} ({_number(min(values))}-{_number(max(values))})"


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
