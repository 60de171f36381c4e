"""`seoro sweep`: run a scenario once for each combination of what varies in it."""

from __future__ import annotations

import argparse
import os
import secrets
import shutil
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import anyio

from seoro.background import background
from seoro.cli.arguments import whole
from seoro.cli.exits import Exit
from seoro.cli.files import count
from seoro.cli.film_arguments import BESIDE, add_view_arguments, film_of, film_texts
from seoro.cli.output import is_terminal
from seoro.cli.run_arguments import (
    add_run_arguments,
    lab_of,
    overrides_of,
    ros_of,
    simulator_of,
    use_file_settings,
)
from seoro.embed import SEED_BITS, Scenario, load, prepare
from seoro.embed.options import Options
from seoro.errors import CONFLICT, InvalidUse
from seoro.lab.wishes import split_wishes
from seoro.lang.frontend import lower
from seoro.lang.lower.entry import find_entry
from seoro.parameters import read_parameters
from seoro.runtime.verdict import RunStatus
from seoro.sweep.axes import Axis, combinations, find_axes
from seoro.sweep.emit import emitted
from seoro.sweep.results import JUNIT, TABLE, write_results
from seoro.sweep.running import Planned, Ran, run_all

EXAMPLES = """examples:
  seoro sweep noise.osc --list
  seoro sweep noise.osc --sim mujoco --rate max --seed 1 --repeat 3 -o out/
  seoro sweep noise.osc --set drop=0.0 --emit variants/

What varies are the parameters with a list of values, `keep(noise in [0.0, 0.1, 0.2])`, that are not given
with `--set` or `--params`.

exit status: 0 all passed, 1 some failed, 3 some had no verdict, 2 the command line or the scenario is invalid,
130 by Ctrl-C"""

_RUNS = "runs"  # the folder of the results of runs, in that of the sweep


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="the scenario file (.osc)")
    add_run_arguments(parser)
    parser.add_argument(
        "-o",
        "--output-dir",
        type=Path,
        default=Path("sweep"),
        metavar="DIR",
        help=f"write {TABLE}, test.xml and a folder for each run there (default: sweep)",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace the results of another sweep there")
    parser.add_argument(
        "-j", "--jobs", type=whole, metavar="N", help="runs at a time (default: one for each processor)"
    )
    parser.add_argument(
        "--repeat",
        type=whole,
        default=1,
        metavar="N",
        help="run each combination so often, with the seeds SEED, SEED + 1, ... (default: 1)",
    )
    parser.add_argument(
        "--record-video",
        action="store_const",
        const=BESIDE,
        help="record a film of each run of the simulator into its folder",
    )
    add_view_arguments(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--list", action="store_true", help="list the combinations, and run nothing")
    what.add_argument(
        "--emit", type=Path, metavar="DIR", help="write each combination there as a scenario file, and run nothing"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    return anyio.run(_Sweep(options, load(options.file)).main)


class _Sweep:
    """One sweep."""

    def __init__(self, options: argparse.Namespace, scenario: Scenario) -> None:
        self._options = options
        self._scenario = scenario
        self._entry = find_entry(scenario.checked, options.scenario).qualified_name
        self._given, _ = split_wishes(overrides_of(options.set))  # robots vary nothing
        self._seeds = use_file_settings(options, scenario, repeats=True).seeds

    async def main(self) -> int:
        """Find what there is to run, and do what is asked for."""
        options = self._options
        simulator_of(options)  # which says what does not go together, as do the next
        ros_of(options)
        lab_of(options)
        film_of(options)
        if options.from_snapshot is not None:
            from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415 - the messages of simulators

            saved_by = read_snapshot(options.from_snapshot).engine
            if options.sim is None and options.connect is None:
                options.sim = saved_by  # which runs share when it is named
        jobs = self._jobs()
        axes = self._axes()
        possible, ruled_out = await self._possible(list(combinations(axes)))
        self._announce(axes, possible, ruled_out)
        if options.list:
            self._list(possible)
            return Exit.PASSED
        if options.emit is not None:
            self._emit(axes, possible)
            return Exit.PASSED
        return await self._run(self._plan(possible), jobs)

    # -------------------------------------------------------- what there is to run

    def _axes(self) -> Sequence[Axis]:
        parameters = self._options.params
        given = {*self._given, *(read_parameters(parameters, self._entry) if parameters is not None else ())}
        plan = lower(self._scenario.checked, self._options.scenario, self._given)
        axes = find_axes(plan, given)
        if not axes and self._options.repeat == 1 and len(self._seeds) < 2:
            raise InvalidUse(
                f"nothing varies in `{self._entry}`",
                help="give a parameter a list of values: `keep(noise in [0.0, 0.1])`, or repeat it: `--repeat 10`",
            )
        return axes

    async def _possible(
        self, values: Sequence[Mapping[str, str]]
    ) -> tuple[Sequence[Mapping[str, str]], Sequence[Mapping[str, str]]]:
        """The combinations that other constraints allow, and those that they rule out."""
        possible: list[Mapping[str, str]] = []
        ruled_out: list[Mapping[str, str]] = []
        for each in values:
            settings = Options(
                name=self._options.scenario,
                seed=0,
                overrides={**self._given, **each},
                parameters=self._options.params,
            )
            try:
                async with prepare(self._scenario, settings):
                    possible.append(each)
            except InvalidUse as error:
                # What else is wrong, such as that there is no simulator here, the run itself tells.
                (ruled_out if error.code == CONFLICT else possible).append(each)
        if not possible:
            raise InvalidUse(f"the constraints of `{self._entry}` rule out all {len(values)} combinations")
        return possible, ruled_out

    def _announce(
        self, axes: Sequence[Axis], possible: Sequence[Mapping[str, str]], ruled_out: Sequence[object]
    ) -> None:
        print(f"{self._options.file}: {count(len(possible), 'combination')} of {count(len(axes), 'parameter')}")
        for axis in axes:
            print(f"  {axis.path} in [{', '.join(axis.values)}]")
        if ruled_out:
            print(f"  {count(len(ruled_out), 'combination')} ruled out by other constraints")
        sys.stdout.flush()

    def _list(self, possible: Sequence[Mapping[str, str]]) -> None:
        print()
        for number, values in enumerate(possible, start=1):
            print(f"{number:>{len(str(len(possible)))}}  {Planned(number, values, 0, Path()).title}")

    def _emit(self, axes: Sequence[Axis], possible: Sequence[Mapping[str, str]]) -> None:
        folder: Path = self._options.emit
        folder.mkdir(parents=True, exist_ok=True)
        stem = Path(self._options.file).stem
        for number, values in enumerate(possible, start=1):
            path = folder / f"{stem}_{number:0{len(str(len(possible)))}}.osc"
            path.write_text(emitted(self._scenario, axes, values, folder), encoding="utf-8")
        print(f"\n  {folder}/{stem}_*.osc  {count(len(possible))}")

    def _plan(self, possible: Sequence[Mapping[str, str]]) -> Sequence[Planned]:
        options = self._options
        seed = secrets.randbits(SEED_BITS) if options.seed is None else options.seed
        repeated = range(seed, seed + options.repeat)
        seeds = self._seeds if len(self._seeds) > 1 and options.repeat == 1 else repeated
        runs = [(values, each) for values in possible for each in seeds]
        width = len(str(len(runs)))
        folder = options.output_dir / _RUNS
        shown = f"{seed} to {seeds[-1]}" if options.repeat > 1 else ", ".join(map(str, seeds))
        print(f"{count(len(runs), 'run')}, seed {shown}", flush=True)
        return [
            Planned(number, values, chosen, folder / f"{number:0{width}}")
            for number, (values, chosen) in enumerate(runs, start=1)
        ]

    # -------------------------------------------------------- running

    async def _run(self, planned: Sequence[Planned], jobs: int) -> int:
        options = self._options
        self._clear(options.output_dir)
        ran: list[Ran] = []
        stop = anyio.Event()
        with _progress(len(planned)) as show:

            def told(each: Ran) -> None:
                ran.append(each)
                show(each)

            async with background() as group:
                group.start_soon(_stop_on_signals, stop, group.cancel_scope)
                try:
                    await run_all(planned, self._arguments(), jobs, stop, told)
                finally:
                    files = write_results(ran, options.output_dir, options.file)
        _print_end(ran, len(planned), files)
        if stop.is_set():
            return Exit.INTERRUPTED
        statuses = {each.status for each in ran}
        if statuses <= {RunStatus.PASSED}:
            return Exit.PASSED
        return Exit.FAILED if statuses <= {RunStatus.PASSED, RunStatus.FAILED} else Exit.ERROR

    def _clear(self, folder: Path) -> None:
        """Make the folder, without results of another sweep."""
        runs = folder / _RUNS
        if runs.exists() or (folder / TABLE).exists():
            if not self._options.overwrite:
                raise InvalidUse(
                    f"{folder} has the results of another sweep",
                    help="name another folder with `-o`, or replace them with `--overwrite`",
                )
            shutil.rmtree(runs, ignore_errors=True)
            for name in (TABLE, JUNIT):  # a sweep that is killed has none, and must not show the old ones
                (folder / name).unlink(missing_ok=True)
        runs.mkdir(parents=True, exist_ok=True)

    def _jobs(self) -> int:
        options = self._options
        if options.connect is not None or options.ros is not None:
            if options.jobs not in (None, 1):
                what, way = ("robot", "") if options.ros is not None else ("simulator", "`--sim`, or ")
                raise InvalidUse(f"one {what} carries out one run at a time", help=f"use {way}`--jobs 1`")
            return 1
        if options.lab is not None and _is_shared(options.lab):
            if options.jobs not in (None, 1):
                raise InvalidUse("the lab has what one run at a time can use", help="leave out `--jobs`")
            return 1
        return int(options.jobs or os.cpu_count() or 1)

    def _arguments(self) -> Sequence[str]:
        """What all runs are given."""
        options = self._options
        texts = {
            "--scenario": options.scenario,
            "--params": options.params,
            "--clock": options.clock,
            "--sim": options.sim,
            "--connect": options.connect,
            "--ros": options.ros,
            "--lab": options.lab,
            "--world": options.world,
            "--from-snapshot": options.from_snapshot,
            "--rate": options.rate,
            "--timeout": options.timeout,
        }
        given = [f"{name}={value}" for name, value in texts.items() if value is not None]
        given = ["--rate=max" if text == "--rate=inf" else text for text in given]
        settings = [f"--set={setting}" for setting in options.set]
        return [
            options.file,
            *given,
            *film_texts(options),
            *settings,
            *(f"--model-path={path}" for path in options.model_path),
            *(f"--ros-interfaces={path}" for path in options.ros_interfaces),
        ]


def _is_shared(lab: Path) -> bool:
    """Whether what a lab consists of is there for all runs: robots, or a simulator that is running."""
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file

    read = read_lab(lab)
    return bool(read.bridges) or (read.simulator is not None and read.simulator[1].connect is not None)


async def _stop_on_signals(stop: anyio.Event, scope: anyio.CancelScope) -> None:
    """The first signal stops the runs in order; the second drops everything."""
    with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
        async for _ in signals:
            if stop.is_set():
                scope.cancel()
                return
            stop.set()
            print("stopping what runs; once more to stop at once", file=sys.stderr, flush=True)


@contextmanager
def _progress(number: int) -> Iterator[Callable[[Ran], None]]:
    """Shows the ends of runs: as a bar on a terminal, else a line for each."""
    if not is_terminal(sys.stdout):
        yield lambda ran: print(_line(ran, number), flush=True)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.fields[last]}"))
    with Progress(*columns) as progress:
        task = progress.add_task("", total=number, last="")
        found: Counter[RunStatus] = Counter()

        def show(ran: Ran) -> None:
            found[ran.status] += 1
            if ran.status is not RunStatus.PASSED:
                progress.print(_line(ran, number), markup=False, highlight=False)
            progress.update(task, advance=1, last=_counts(found))

        yield show


def _line(ran: Ran, number: int) -> str:
    reason = f"  {ran.reason}" if ran.reason else ""
    place = f"{ran.planned.number:>{len(str(number))}}"
    return f"{place}  {ran.status.value:9}  {ran.wall_duration:7.2f} s  {ran.planned.title}{reason}"


def _counts(found: Mapping[RunStatus, int]) -> str:
    return ", ".join(f"{found[status]} {status.value}" for status in RunStatus if status in found)


def _print_end(ran: Sequence[Ran], planned: int, files: Sequence[Path]) -> None:
    missing = planned - len(ran)
    left = f"; {missing} not started" if missing else ""
    print(f"\n{count(len(ran), 'run')}: {_counts(Counter(each.status for each in ran))}{left}")
    for path in files:
        print(f"  {path}")
