"""The end of a run on the command line: its files are written and it is told how it went, wherever it ran."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from seoro.cli.files import shown_name
from seoro.cli.output import Progress, is_terminal, print_reason
from seoro.cli.results import ResultFiles, result
from seoro.errors import InvalidUse
from seoro.reasons import reason_text
from seoro.runtime.jsonl import to_json
from seoro.runtime.trace import unwritten
from seoro.runtime.verdict import Verdict, unproved

if TYPE_CHECKING:
    from seoro.bridges.wire import Artifact
    from seoro.cli.live_tree import LiveTree


@dataclass(frozen=True)
class Conclusion:
    """What a run ends with.

    Args:
        verdict: The verdict.
        parameters: The chosen value of every parameter.
        files: What lies in its output folder, and what that is.
        fault: Where an action's own code has raised what ended the run, in a line; empty if none did.
        traceback: Of that.
        artifacts: What is still to be written there.
    """

    verdict: Verdict
    parameters: Mapping[str, object]
    files: Sequence[tuple[Path, str]]
    fault: str = ""
    traceback: str = ""
    artifacts: Sequence[Artifact] = ()


async def conclude(
    found: Conclusion, options: argparse.Namespace, results: ResultFiles, progress: Progress | LiveTree
) -> Verdict:
    """Write what a run leaves, and tell of its end; returns the verdict, an error if something was not written."""
    verdict = found.verdict
    if (error := await results.finish()) is not None:
        verdict = unproved(verdict, unwritten(error))
    written = list(found.files)
    try:
        why = "\n\n".join(filter(None, (reason_text(verdict), found.traceback)))  # for those who read it later
        written += results.write(verdict, found.parameters, why, found.artifacts)
    except InvalidUse as refused:
        verdict = unproved(verdict, str(refused))
    await _print(replace(found, verdict=verdict, files=written), options, progress)
    return verdict


async def _print(found: Conclusion, options: argparse.Namespace, progress: Progress | LiveTree) -> None:
    verdict = found.verdict
    await progress.end_of_run()
    progress.verdict(verdict)
    width = max((len(str(path)) for path, _ in found.files), default=0)
    for path, what in found.files:
        progress.say(f"  {path!s:{width}}  {what}")
    await progress.finish()
    print_reason(verdict)
    if found.fault:
        print(found.traceback.rstrip() if options.debug else found.fault, file=sys.stderr)
    if options.json:
        print(to_json(result(verdict, found.parameters, found.files)))


def tell_dry_run(
    options: argparse.Namespace,
    progress: Progress | LiveTree,
    seed: int,
    parameters: Mapping[str, object],
    texts: Mapping[str, str],
    **more: object,
) -> None:
    """Print the values that a run would have.

    Args:
        options: Of the command line.
        progress: Prints.
        seed: Of the run.
        parameters: The chosen values, for `--json`.
        texts: The same as the language writes them, for people.
        more: What else is known of the run, for `--json`.
    """
    if options.json:
        print(to_json({"seed": seed, "parameters": parameters, **more}))
        return
    progress.say(f"{shown_name(options.file)} can be run: seed {seed}")
    for name, text in texts.items():
        progress.say(f"  {name} = {text}")


def progress_of(options: argparse.Namespace, file: TextIO) -> Progress | LiveTree:
    """What shows a run to people."""
    if not options.live_tree:
        return Progress(file)
    if not is_terminal(file):
        print("note: `--live-tree` needs a terminal; what happens is printed line by line", file=sys.stderr)
        return Progress(file)
    from seoro.cli.live_tree import LiveTree  # noqa: PLC0415 - drawing takes long to load

    return LiveTree(file)
