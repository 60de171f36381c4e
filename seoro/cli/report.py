"""Output of a run on the terminal and in files, for local and remote runs."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.cli.exit_status import Exit
from seoro.cli.files import shown_name
from seoro.cli.output import Progress, print_reason
from seoro.cli.results import STDOUT, ResultFiles, print_json, result
from seoro.cli.terminal import is_terminal
from seoro.errors import UsageError
from seoro.runtime.trace.records import write_error_text
from seoro.runtime.verdict import Verdict, with_write_error

if TYPE_CHECKING:
    from seoro.bridges.wire import Artifact
    from seoro.cli.live_tree import LiveTree


class RunReport:
    """Progress and result of a run.

    Args:
        options: Options of the command line.
        files: Output files of the run.
    """

    def __init__(self, options: argparse.Namespace, files: ResultFiles) -> None:
        self.progress = _make_progress(options)
        self.interrupted: Exit | None = None  # the exit status, when a signal ends the run
        self._options = options
        self._files = files

    def interrupt(self, number: int) -> tuple[str, bool]:
        """Note that a signal ends the run; return the name of the signal, and whether it is a later one."""
        is_again = self.interrupted is not None
        self.interrupted = Exit.INTERRUPTED if number == signal.SIGINT else Exit.CANCELLED
        return "Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name, is_again

    def dry_run(
        self, seed: int, parameters: Mapping[str, object], texts: Mapping[str, str], **more: object
    ) -> None:
        """Print the values that a run would have.

        Args:
            seed: Seed of the run.
            parameters: Chosen values, for `--json`.
            texts: Chosen values in the notation of the language, for people.
            more: More fields for `--json`.
        """
        if self._options.json:
            print_json({"seed": seed, "parameters": parameters, **more})
            return
        self.progress.print_line(f"{shown_name(self._options.file)} is ready to run: seed {seed}")
        for name, text in texts.items():
            self.progress.print_line(f"  {name} = {text}")

    async def finish(self) -> None:
        """Wait until all output is written."""
        await self._files.finish()
        await self.progress.finish()

    async def conclude(
        self,
        verdict: Verdict,
        parameters: Mapping[str, object],
        files: Sequence[tuple[Path, str]],
        fault: tuple[str, str],
        artifacts: Sequence[Artifact],
    ) -> Exit:
        """Write and print the result of a finished run.

        Args:
            verdict: The verdict; it becomes an error if a file cannot be written.
            parameters: The chosen value of every parameter.
            files: Files in the output folder, with descriptions.
            fault: Location and traceback of an exception in an action's code that ended the run; may be empty.
            artifacts: Files of the simulator, still to be written.

        Returns:
            The exit status.
        """
        location, traceback = fault
        if (error := await self._files.finish()) is not None:
            verdict = with_write_error(verdict, write_error_text(error))
        written = list(files)
        try:
            written += self._files.write(verdict, parameters, _why(verdict, traceback), artifacts)
        except UsageError as refused:
            verdict = with_write_error(verdict, str(refused))
        await self.progress.end_of_run()
        self.progress.print_verdict(verdict)
        width = max((len(str(path)) for path, _ in written), default=0)
        for path, what in written:
            self.progress.print_line(f"  {path!s:{width}}  {what}")
        await self.progress.finish()
        print_reason(verdict)
        if location:
            print(traceback.rstrip() if self._options.debug else location, file=sys.stderr)
        self._files.result = found = result(verdict, parameters, written)
        if self._options.json:
            print_json(found)
        return self.interrupted or Exit.of_run(verdict.status)


def _why(verdict: Verdict, traceback: str) -> str:
    """Return the reason and traceback of a run that did not pass, for JUnit files."""
    if not verdict.reason:
        return traceback
    from seoro.runtime.explain.reasons import reason_text  # noqa: PLC0415 - for runs that did not pass

    return "\n\n".join(filter(None, (reason_text(verdict), traceback)))


def _make_progress(options: argparse.Namespace) -> Progress | LiveTree:
    """Make the display of a run: a live tree, or lines; on stderr if stdout has data for a program."""
    file = sys.stderr if options.json or options.trace == STDOUT else sys.stdout
    if not options.live_tree:
        return Progress(file)
    if not is_terminal(file):
        print("note: `--live-tree` needs a terminal; printing line by line instead", file=sys.stderr)
        return Progress(file)
    from seoro.cli.live_tree import LiveTree  # noqa: PLC0415 - drawing takes long to load

    return LiveTree(file)
