"""`seoro campaign shrink`: the simplest values at which a failed run still fails, as a scenario file."""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
from pathlib import Path

import anyio

from seoro.campaign.after.around import Start, start_at
from seoro.campaign.after.exec_options import words_beyond_directives
from seoro.campaign.after.finding import find_failed
from seoro.campaign.after.findings import Shrunk
from seoro.campaign.after.same_failure import SameFailure
from seoro.campaign.after.shrink import RUNS, Shrink
from seoro.campaign.emit import Emitted, check_replaceable
from seoro.campaign.store.folder import NEIGHBOURS, SHRINK
from seoro.campaign.work.measurements import reason_key
from seoro.cli.arguments import Commands, add_option
from seoro.cli.campaign_around import add_around, announce, carry_out, flaky_text, printer
from seoro.cli.campaign_places import places_of
from seoro.cli.exit_status import Exit
from seoro.cli.files import write_errors
from seoro.cli.results import check_writable
from seoro.cli.tables import table
from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.runtime.verdict import RunStatus


def add_shrink(commands: Commands) -> None:
    """Declare the subcommand."""
    parser = add_around(commands, SHRINK, "find the simplest values at which a failed run still fails", RUNS)
    add_option(parser, "-o --output FILE", "scenario file with these values (default: NAME_RUN.osc)", dest="file")


def shrink(options: argparse.Namespace) -> int:
    """Run the subcommand."""
    return anyio.run(_shrink, options)


async def _shrink(options: argparse.Namespace) -> int:
    start = start_at(find_failed(options.folder, options.number))
    row = start.found.row
    file = options.file or Path(f"{Path(start.found.campaign.manifest.entry).stem}_{row.run}.osc")
    _check_file(file, start)
    with write_errors(start.found.folder):
        work = Shrink(start, any_failure=options.any_failure, runs=options.runs, repeat=options.repeat)
    announce(start)
    is_interrupted = await carry_out(work.campaign, start, places_of(options), printer(work.failure))
    with write_errors(start.found.folder):
        shrunk = work.conclude()
    is_same = False
    if shrunk.has_failed:
        _print_values(shrunk, start)
        with write_errors(file):
            emitted = work.write(file)
        is_same = not is_interrupted and _verify(file, emitted, start, work.failure)
        around = ["seoro", "campaign", NEIGHBOURS, str(work.campaign.folder), str(shrunk.best)]
        print(f"  {shlex.join(around)} shows how far away it passes")
    if is_interrupted:
        print(f"  continue with the same command; its runs are in {work.campaign.folder}")
        return Exit.INTERRUPTED
    if shrunk.outcome == "gone":
        print(flaky_text(work.strategy.repeated, work.failure, row))
        return Exit.FAILED
    return Exit.PASSED if is_same else Exit.ERROR


def _check_file(file: Path, start: Start) -> None:
    """Check before the runs that the file can be written.

    Raises:
        UsageError: It is not a scenario file, or one of the user.
    """
    if file.suffix != ".osc":
        raise UsageError(f"expected a scenario file for `-o`, found {file}", help="for example `-o small.osc`")
    if resolved(file) in {resolved(source.path) for source in start.scenario.files if source.path is not None}:
        raise UsageError(f"{file} is a file of the scenario", help="choose another file with `-o`")
    check_replaceable(file)
    check_writable(file)


def _print_values(shrunk: Shrunk, start: Start) -> None:
    lines = [["parameter", f"run {shrunk.run}", "shrunk", "matters"]]
    for path, text in shrunk.values.items():
        lines.append([path, shrunk.before[path], text, "yes" if shrunk.matters(path) else "no"])
    print(f"\n{table(lines, '  ')}\n")
    unknown = [axis.path for axis in start.space.axes if axis.path not in shrunk.before]
    if unknown:
        print(f"  each run draws {', '.join(unknown)}: the trace of run {shrunk.run} was not kept")
    if shrunk.outcome == "failing":
        print("  stopped early: there may be simpler values")


def _verify(file: Path, emitted: Emitted, start: Start, failure: SameFailure) -> bool:
    """Run the scenario file, and print whether it fails the same way."""
    words = [str(file), *words_beyond_directives(start.options)]
    print(f"  {shlex.join(['seoro', 'exec', *words])}", flush=True)
    command = [sys.executable, "-m", "seoro", "exec", *words, "--json"]
    ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    try:
        result = json.loads(ended.stdout)
    except json.JSONDecodeError:
        result = {"reason": ended.stderr.strip() or f"exit status {ended.returncode}"}
    if "source" not in result:
        print(f"  it could not be run: {result['reason']}")
        return False
    is_failure = result["status"] == RunStatus.FAILED.value
    where = _place_in(emitted, start.found.campaign.manifest.shown, failure.where)
    is_alike = reason_key(result["reason"]) == failure.reason_key and _place(result["source"]) == where
    if is_failure and (failure.any_failure or is_alike):
        print("  it fails the same way")
        return True
    print(f"  it does not fail the same way: {result['status']} {result['reason']} {result['source']}".rstrip())
    return False


def _place_in(emitted: Emitted, shown: str, where: str) -> tuple[str, ...]:
    """Return the place in a written file of a place in the scenario: name, line and column."""
    file, *numbers = where.rsplit(":", 2)
    if file != shown:
        return _place(where)
    return (emitted.path.name, str(emitted.line_of(int(numbers[0]))), numbers[1])


def _place(where: str) -> tuple[str, ...]:
    file, *numbers = where.rsplit(":", 2)
    return (Path(file).name, *numbers)
