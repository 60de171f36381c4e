"""`seoro runs prune`: delete old runs by age and size."""

from __future__ import annotations

import argparse
import asyncio
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from seoro.cli.arguments import add_command, add_option, duration, with_unit
from seoro.cli.exit_status import Exit
from seoro.cli.run_folders import find_runs, size_of
from seoro.errors import UsageError

EXAMPLES = """examples:
  seoro runs prune results/ --older 30d --keep-failed --dry-run
  seoro runs prune results/ --older 30d --keep-failed
  seoro runs prune results/ --larger 20GB            # delete the oldest until 20 GB are left
  seoro runs prune ~/.local/state/seoro/lab-a --older 7d    # of an executor that is stopped

Only results of runs are deleted: files that `seoro exec -o` lists in .seoro-results, kept runs of campaigns, and
runs in the folder of an executor. Other files in these folders stay. Runs that have not ended stay for a day.

exit status: 0; 3 if a folder cannot be deleted"""

UNENDED: Final = 86_400.0  # [s] for which runs without an end stay, as they may be active
_UNITS: Final = {"kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
_bytes = with_unit("a size such as 500MB or 20GB", _UNITS)
_STORE: Final = "runs.sqlite"
_PASSED: Final = "passed"


@dataclass(frozen=True)
class StoredRun:
    """A run that may be deleted.

    Attributes:
        name: Its folder, or its id on an executor.
        ended: Time of its end [s since the epoch].
        size: Size of its files [bytes].
        status: Its status; empty if it has not ended.
        remove: Deletes it.
    """

    name: str
    ended: float
    size: int
    status: str
    remove: Callable[[], object]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    commands = parser.add_subparsers(title="subcommands", dest="what", metavar="SUBCOMMAND", required=True)
    prune = add_command(commands, "prune", "delete runs by age and size")
    prune.add_argument("folders", metavar="FOLDER", nargs="+", type=Path, help="folder with runs, at any depth")
    add_option(prune, "--older DURATION", "delete runs that ended longer ago, such as 12h or 30d", type=duration)
    add_option(prune, "--larger SIZE", "delete the oldest runs while all are larger, such as 20GB", type=_bytes)
    add_option(prune, "--keep-failed", "keep runs that did not pass")
    add_option(prune, "-n --dry-run", "print the runs that would be deleted, and delete none")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.older is None and options.larger is None:
        raise UsageError("missing `--older` or `--larger`", help="for example `--older 30d`")
    for folder in options.folders:
        if not folder.is_dir():
            raise UsageError(f"folder not found: {folder}")
    with ExitStack() as opened:
        runs = [each for folder in options.folders for each in _runs_in(folder, opened)]
        doomed = choose(runs, options.older, options.larger, time.time(), keep_failed=options.keep_failed)
        failures = _delete(doomed, is_dry=options.dry_run)
    size = sum(each.size for each in doomed)
    what = "would delete" if options.dry_run else "deleted"
    print(f"{what} {len(doomed) - failures} of {len(runs)} runs, {_size_text(size)}")
    return Exit.ERROR if failures else Exit.PASSED


def choose(
    runs: Sequence[StoredRun], older: float | None, larger: float | None, now: float, *, keep_failed: bool
) -> list[StoredRun]:
    """Choose the runs to delete, oldest first.

    Args:
        runs: All runs.
        older: Age from which runs are deleted [s]; None for any.
        larger: Size of all runs above which the oldest are deleted [bytes]; None for any.
        now: Present time [s since the epoch].
        keep_failed: Whether runs that did not pass stay.
    """
    total = sum(each.size for each in runs)
    chosen = []
    for each in sorted(runs, key=lambda each: each.ended):
        is_active = not each.status and now - each.ended < UNENDED
        if is_active or (keep_failed and each.status != _PASSED):
            continue
        is_old = older is not None and now - each.ended > older
        if is_old or (larger is not None and total > larger):
            chosen.append(each)
            total -= each.size
    return chosen


def _delete(runs: Sequence[StoredRun], *, is_dry: bool) -> int:
    """Delete runs, and print them; return the number of failures."""
    failures = 0
    for each in runs:
        problem = ""
        if not is_dry:
            try:
                each.remove()
            except OSError as error:
                failures += 1
                problem = f"  cannot delete it: {error.strerror or error}"
        ended = time.strftime("%Y-%m-%d %H:%M", time.localtime(each.ended))
        print(f"  {ended}  {each.status or 'no end':9}  {_size_text(each.size):>8}  {each.name}{problem}")
    return failures


def _runs_in(folder: Path, opened: ExitStack) -> Iterator[StoredRun]:
    """Yield the runs below a folder; that of an executor stays open until the end of the command."""
    if (folder / _STORE).is_file():
        yield from _runs_of_executor(folder, opened)
        return
    for found in find_runs(folder):
        yield StoredRun(str(found.path), found.ended, found.size, found.status, found.remove)


def _runs_of_executor(folder: Path, opened: ExitStack) -> Iterator[StoredRun]:
    from seoro.executor.storage.store import open_store  # noqa: PLC0415 - for folders of executors only

    store = opened.enter_context(open_store(folder))
    runner = opened.enter_context(asyncio.Runner())
    for info in runner.run(store.youngest(-1)):
        if info.ended is None:
            continue
        status = info.state.value if info.state.is_final else ""

        def remove(run: str = info.run) -> None:
            runner.run(store.remove(run))

        yield StoredRun(
            f"{folder} {info.run[:8]}", info.ended, size_of(store.folder(info.run).path), status, remove
        )


def _size_text(size: float) -> str:
    """Format a size [bytes]."""
    for unit, scale in reversed(_UNITS.items()):
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size:.0f} B"
