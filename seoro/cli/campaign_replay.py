"""`seoro campaign replay`: one run of a campaign again, compared with the first time."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path

from seoro.campaign.after.exec_options import words_of_run
from seoro.campaign.after.finding import FoundRun, find_run
from seoro.campaign.after.traces import clock_of, digest_of, first_difference
from seoro.campaign.opening import check_unchanged
from seoro.campaign.store.folder import REPLAYED, TRACE
from seoro.cli import exec_command
from seoro.cli.arguments import Commands, Parser, add_command, add_option, option_texts
from seoro.cli.exit_status import Exit
from seoro.cli.results import ResultFiles
from seoro.cli.video_arguments import VIEWS, add_video_arguments
from seoro.errors import UsageError
from seoro.runtime.verdict import RunStatus


def add_replay(commands: Commands) -> None:
    """Declare the subcommand."""
    parser = add_command(commands, "replay", "repeat a run, and compare its trace with that of the campaign")
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="folder of the campaign")
    parser.add_argument("number", metavar="RUN", help="number of the run, or the beginning of its id")
    add_option(parser, "-o --output-dir DIR", f"folder for the results (default: FOLDER/{REPLAYED}/RUN)")
    add_option(parser, "-t --live-tree", "show a live tree of running behaviors")
    add_video_arguments(parser)


def replay(options: argparse.Namespace) -> int:
    """Run the subcommand."""
    found = find_run(options.folder, options.number)
    check_unchanged(found.campaign, f"run {found.row.run} cannot be repeated", "start another campaign")
    if options.record_video is not None and found.campaign.manifest.options.simulator is None:
        raise UsageError(
            "`--record-video` needs a simulator, and the campaign has none", help="leave out the video"
        )
    options.output_dir = options.output_dir or options.folder / REPLAYED / f"{found.row.run:06}"
    trace = options.output_dir / TRACE
    manifest = found.campaign.manifest
    directory = Path(manifest.root or ".") / manifest.directory
    if not directory.samefile(Path.cwd()):  # paths in traces are relative to that of the campaign
        options.output_dir = options.output_dir.absolute()
        if options.record_video:
            options.record_video = str(Path(options.record_video).absolute())
    with contextlib.chdir(directory):
        status = _exec(found, options)
    if status in (Exit.INVALID, Exit.INTERRUPTED, Exit.CANCELLED) or not trace.is_file():
        return status
    if clock_of(trace) == "real":
        return _compare_verdicts(found, status)
    return _compare(found, trace)


def _exec(found: FoundRun, options: argparse.Namespace) -> int:
    from seoro.cli.exec_local import run_local  # noqa: PLC0415 - loads what runs a scenario

    parser = Parser()
    exec_command.add_arguments(parser)
    words = words_of_run(found.campaign, found.planned)
    words += option_texts(options, ["output_dir", "live_tree", "record_video", *VIEWS.values()])
    options = parser.parse_args(words)
    return run_local(options, ResultFiles(options))


def _compare_verdicts(found: FoundRun, status: int) -> Exit:
    """Print whether the verdict is that of the campaign."""
    row = found.row
    is_same = status == Exit.of_run(RunStatus(row.status.value))
    what = "the same verdict" if is_same else "another verdict"
    print(f"\n{what} as run {row.run}, {row.status.value}; times differ on the real clock", flush=True)
    return Exit.PASSED if is_same else Exit.FAILED


def _compare(found: FoundRun, trace: Path) -> Exit:
    """Print whether the trace is equal to that of the campaign."""
    row = found.row
    if not row.trace_sha:
        print(f"\nrun {row.run} ended without a trace; nothing to compare", flush=True)
        return Exit.ERROR
    if digest_of(trace) == row.trace_sha:
        print(f"\nequal: the trace is that of run {row.run} to the bit")
        return Exit.PASSED
    print(f"\ndifferent: the trace is not that of run {row.run}")
    kept = found.folder / row.folder / TRACE
    difference = first_difference(kept, trace) if row.folder and kept.is_file() else None
    if difference is not None:
        print(f"  record {difference.record}: {difference.text}")
    elif not row.folder:
        print("  the campaign did not keep its trace; `--keep all` keeps those of all runs")
    return Exit.FAILED
