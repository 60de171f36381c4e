"""`seoro sweep`: run a scenario once per combination of varied parameters."""

from __future__ import annotations

import argparse
import secrets
import shutil
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import anyio

from seoro.cli.arguments import add_option, option_texts
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.cli.jobs import simultaneous_runs
from seoro.cli.output import is_terminal
from seoro.cli.parquet import add_parquet_argument, check_parquet
from seoro.cli.run_arguments import add_run_arguments, overrides_of, settings_of, use_file_settings
from seoro.cli.video_arguments import OUTPUT_FOLDER, VIDEO_OPTIONS, add_view_arguments, video_of
from seoro.concurrency.background import background
from seoro.embed import SEED_BITS, Scenario, load, prepare
from seoro.embed.options import Options
from seoro.embed.parameter_files import read_parameters
from seoro.errors import CONFLICT, UsageError
from seoro.lab.selectors import split_selectors
from seoro.lang.frontend import lower
from seoro.lang.lower.lower import find_entry
from seoro.runtime.verdict import RunStatus
from seoro.sweep.axes import Axis, combinations, find_axes
from seoro.sweep.emit import emitted
from seoro.sweep.results import JUNIT, TABLE, write_results
from seoro.sweep.running import Planned, Ran, run_all, title_of

EXAMPLES = """examples:
  seoro sweep noise.osc --list
  seoro sweep noise.osc --sim mujoco --rate max --seed 1 --repeat 3 -o out/
  seoro sweep noise.osc --set drop=0.0 --emit variants/

A sweep varies each parameter with a list of values, such as `keep(noise in [0.0, 0.1, 0.2])`, that is not set with
`--set` or `--params`.

exit status: 0 all passed, 1 some failed, 2 the command line or the scenario is invalid, 3 some ended without a
verdict, 130 by Ctrl-C"""

_RUNS = "runs"  # folder for the results of runs
_PASSED = (
    "scenario", "params", "clock", "sim", "connect", "ros", "lab", "world", "from_snapshot", "rate", "timeout",
    "set", "model_path", "ros_interfaces", "parquet", *VIDEO_OPTIONS,
)  # fmt: skip # options of `seoro exec` that are the same for all runs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("file", metavar="FILE", help="scenario file (.osc)")
    add_run_arguments(parser)
    add_option(
        parser,
        "-o --output-dir DIR",
        f"folder for {TABLE}, test.xml and the results of runs (default: sweep)",
        default=Path("sweep"),
    )
    add_parquet_argument(parser)
    add_option(parser, "--overwrite", "replace the results of an earlier sweep")
    add_option(parser, "-j --jobs N", "number of simultaneous runs (default: number of processors)")
    add_option(
        parser,
        "--repeat N",
        "run each combination N times, with the seeds SEED, SEED + 1, ... (default: 1)",
        default=1,
    )
    parser.add_argument(
        "--record-video",
        action="store_const",
        const=OUTPUT_FOLDER,
        help="record a video of each run to its folder",
    )
    add_view_arguments(parser)
    what = parser.add_mutually_exclusive_group()
    add_option(what, "--list", "list the combinations without running them")
    add_option(what, "--emit DIR", "write each combination as a scenario file, without running it")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    return anyio.run(_Sweep(options, load(options.file)).main)


class _Sweep:
    """Run of the command."""

    def __init__(self, options: argparse.Namespace, scenario: Scenario) -> None:
        self._options = options
        self._scenario = scenario
        self._entry = find_entry(scenario.checked, options.scenario).qualified_name
        self._given, _ = split_selectors(overrides_of(options.set))  # selectors of robots are not varied
        self._seeds = use_file_settings(options, scenario, repeats=True).seeds

    async def main(self) -> int:
        """Find the combinations, then list, write or run them."""
        options = self._options
        settings = settings_of(options)
        video_of(options)  # checks that options are consistent
        check_parquet(options)
        if options.from_snapshot is not None:
            from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415 - the messages of simulators

            saved_by = read_snapshot(options.from_snapshot).engine
            if options.sim is None and options.connect is None:
                options.sim = saved_by  # runs share a named simulator
        jobs = simultaneous_runs(settings, options.jobs)
        axes = self._axes()
        values_of_runs = list(combinations(axes))
        possible = await self._possible(values_of_runs)
        self._announce(axes, len(possible), len(values_of_runs) - len(possible))
        if options.list:
            print()
            for number, values in enumerate(possible, start=1):
                print(f"{number:>{len(str(len(possible)))}}  {title_of(values)}")
        elif options.emit is not None:
            self._emit(axes, possible)
        else:
            return await self._run(self._plan(possible), jobs)
        return Exit.PASSED

    # -------------------------------------------------------- combinations

    def _axes(self) -> Sequence[Axis]:
        parameters = self._options.params
        given = {*self._given, *(read_parameters(parameters, self._entry) if parameters is not None else ())}
        plan = lower(self._scenario.checked, self._options.scenario, self._given)
        axes = find_axes(plan, given)
        if not axes and self._options.repeat == 1 and len(self._seeds) < 2:
            raise UsageError(
                f"no varied parameter in `{self._entry}`",
                help="list values in the scenario, `keep(noise in [0.0, 0.1])`, or repeat it with `--repeat 10`",
            )
        return axes

    async def _possible(self, values: Sequence[Mapping[str, str]]) -> Sequence[Mapping[str, str]]:
        """Return the combinations that satisfy all constraints."""
        possible: list[Mapping[str, str]] = []
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
            except UsageError as error:
                # Other errors, such as a missing simulator, are reported by the run itself.
                if error.code != CONFLICT:
                    possible.append(each)
        if not possible:
            raise UsageError(f"the constraints of `{self._entry}` rule out all {len(values)} combinations")
        return possible

    def _announce(self, axes: Sequence[Axis], possible: int, ruled_out: int) -> None:
        print(f"{self._options.file}: {count(possible, 'combination')} of {count(len(axes), 'parameter')}")
        for axis in axes:
            print(f"  {axis.path} in [{', '.join(axis.values)}]")
        if ruled_out:
            print(f"  {count(ruled_out, 'combination')} ruled out by other constraints")
        sys.stdout.flush()

    def _emit(self, axes: Sequence[Axis], possible: Sequence[Mapping[str, str]]) -> None:
        folder: Path = self._options.emit
        stem = Path(self._options.file).stem
        with write_errors(folder):
            folder.mkdir(parents=True, exist_ok=True)
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

            def on_end(each: Ran) -> None:
                ran.append(each)
                show(each)

            async with background() as group:
                group.start_soon(_stop_on_signals, stop, group.cancel_scope)
                try:
                    await run_all(planned, self._arguments(), jobs, stop, on_end)
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
        """Create the folder; refuse or remove the results of an earlier sweep."""
        runs = folder / _RUNS
        if runs.exists() or (folder / TABLE).exists():
            if not self._options.overwrite:
                raise UsageError(
                    f"{folder} contains the results of another sweep",
                    help="choose another folder with `-o`, or replace them with `--overwrite`",
                )
            shutil.rmtree(runs, ignore_errors=True)
            for name in (TABLE, JUNIT):  # a killed sweep must not show old results
                (folder / name).unlink(missing_ok=True)
        runs.mkdir(parents=True, exist_ok=True)

    def _arguments(self) -> Sequence[str]:
        """Return the arguments of `seoro exec` for all runs."""
        return [self._options.file, *option_texts(self._options, _PASSED)]


async def _stop_on_signals(stop: anyio.Event, scope: anyio.CancelScope) -> None:
    """Stop the runs at the first signal; drop them at the second."""
    with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
        async for _ in signals:
            if stop.is_set():
                scope.cancel()
                return
            stop.set()
            print("stopping active runs; press again to stop at once", file=sys.stderr, flush=True)


@contextmanager
def _progress(number: int) -> Iterator[Callable[[Ran], None]]:
    """Show the progress: a bar on a terminal, otherwise a line per run."""
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
