"""Report of a finished run: write its files and print its verdict, for local and remote runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.cli.files import shown_name
from seoro.cli.output import Progress, is_terminal, print_reason
from seoro.cli.results import STDOUT, ResultFiles, print_json, result
from seoro.errors import UsageError
from seoro.lang.frozen import Value
from seoro.runtime.trace.records import write_error_text
from seoro.runtime.verdict import Verdict, with_write_error

if TYPE_CHECKING:
    from seoro.bridges.wire import Artifact
    from seoro.cli.live_tree import LiveTree


class RunReport(Value):
    """Result of a finished run.

    Args:
        verdict: The verdict.
        parameters: The chosen value of every parameter.
        files: Files in the output folder, with descriptions.
        fault: Location of an exception in an action's code that ended the run, in one line; may be empty.
        traceback: Traceback of that exception.
        artifacts: Files of the simulator, still to be written.
    """

    verdict: Verdict
    parameters: Mapping[str, object]
    files: Sequence[tuple[Path, str]]
    fault: str = ""
    traceback: str = ""
    artifacts: Sequence[Artifact] = ()


async def report_run(
    found: RunReport, options: argparse.Namespace, results: ResultFiles, progress: Progress | LiveTree
) -> Verdict:
    """Write and print the result of a run; return its verdict, which is an error if a file was not written."""
    verdict = found.verdict
    if (error := await results.finish()) is not None:
        verdict = with_write_error(verdict, write_error_text(error))
    written = list(found.files)
    try:
        written += results.write(verdict, found.parameters, _why(verdict, found.traceback), found.artifacts)
    except UsageError as refused:
        verdict = with_write_error(verdict, str(refused))
    await _print(found, verdict, written, options, progress)
    return verdict


def _why(verdict: Verdict, traceback: str) -> str:
    """Return the reason and traceback of a run that did not pass, for JUnit files."""
    if not verdict.reason:
        return traceback
    from seoro.runtime.explain.reasons import reason_text  # noqa: PLC0415 - for runs that did not pass

    return "\n\n".join(filter(None, (reason_text(verdict), traceback)))


async def _print(
    found: RunReport,
    verdict: Verdict,
    files: Sequence[tuple[Path, str]],
    options: argparse.Namespace,
    progress: Progress | LiveTree,
) -> None:
    await progress.end_of_run()
    progress.print_verdict(verdict)
    width = max((len(str(path)) for path, _ in files), default=0)
    for path, what in files:
        progress.print_line(f"  {path!s:{width}}  {what}")
    await progress.finish()
    print_reason(verdict)
    if found.fault:
        print(found.traceback.rstrip() if options.debug else found.fault, file=sys.stderr)
    if options.json:
        print_json(result(verdict, found.parameters, files))


def report_dry_run(
    options: argparse.Namespace,
    progress: Progress | LiveTree,
    seed: int,
    parameters: Mapping[str, object],
    texts: Mapping[str, str],
    **more: object,
) -> None:
    """Print the values that a run would have.

    Args:
        options: Options of the command line.
        progress: Printer of the result.
        seed: Seed of the run.
        parameters: Chosen values, for `--json`.
        texts: Chosen values in the notation of the language, for people.
        more: More fields for `--json`.
    """
    if options.json:
        print_json({"seed": seed, "parameters": parameters, **more})
        return
    progress.print_line(f"{shown_name(options.file)} is ready to run: seed {seed}")
    for name, text in texts.items():
        progress.print_line(f"  {name} = {text}")


def make_progress(options: argparse.Namespace) -> Progress | LiveTree:
    """Make the display of a run: a live tree, or lines; on stderr if stdout has data for a program."""
    file = sys.stderr if options.json or options.trace == STDOUT else sys.stdout
    if not options.live_tree:
        return Progress(file)
    if not is_terminal(file):
        print("note: `--live-tree` needs a terminal; printing line by line instead", file=sys.stderr)
        return Progress(file)
    from seoro.cli.live_tree import LiveTree  # noqa: PLC0415 - drawing takes long to load

    return LiveTree(file)
