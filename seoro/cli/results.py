"""Output files of a run: traces, written during the run, and its result as JUnit XML and JSON."""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from io import FileIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from seoro.cli.arguments import add_option
from seoro.cli.files import shown_name, write_errors
from seoro.cli.parquet import add_parquet_argument, as_parquet, check_parquet
from seoro.errors import BackendError, InvalidScenario, SeoroError, UsageError
from seoro.files.inputs import resolved
from seoro.runtime.execution.outputs import RESULT_NAMES, TRACE
from seoro.runtime.trace.writer import unbuffered
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.bridges.wire import Artifact
    from seoro.embed.output_folder import OutputFolder
    from seoro.runtime.trace.jsonl import JsonLines

STDOUT = "-"
_COVERAGE = "coverage.json"


def add_result_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options for the output of a run."""
    add_option(
        parser, "-o --output-dir DIR", "write the trace, test.xml, coverage.json and other results to this folder"
    )
    add_parquet_argument(parser)
    add_option(parser, "--report", "also write report.html, a page that shows the run, to the output folder")
    add_option(parser, "--trace FILE", "write the trace (JSON Lines) to this file; - for stdout", type=str)
    add_option(parser, "-t --live-tree", "show a live tree of running behaviors")
    add_option(parser, "--junit FILE", "write the result as JUnit XML to this file")
    add_option(parser, "--json", "print the result (or the values of a dry run) as one JSON object on stdout")


class ResultFiles:
    """Output files that the options ask for.

    Args:
        options: Options with `trace`, `junit` and `output_dir`.

    Attributes:
        result: Result of the run as JSON data; None while it has none.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._folder: OutputFolder | None = None
        if options.output_dir is not None:
            from seoro.embed.output_folder import OutputFolder  # noqa: PLC0415 - for `-o` only

            self._folder = OutputFolder(options.output_dir)
        trace = None if options.trace in (None, STDOUT) else Path(options.trace)
        self._trace_paths = self._with_folder(trace, TRACE)
        self._junit_paths = self._with_folder(options.junit, "test.xml")
        self._is_claimed = False
        self._are_inputs = False
        self.traces: list[JsonLines] = []  # observers
        self.result: dict[str, Any] | None = None

    @contextmanager
    def open(self) -> Iterator[None]:
        """Open the traces while the block lasts; a dry run writes nothing.

        Raises:
            UsageError: A file cannot be written.
        """
        if self._options.dry_run:
            yield
            return
        self._check()
        self._claim()
        opened = ExitStack()
        try:
            self.traces += self._traces(opened)
            yield
        finally:
            with suppress(OSError):  # reported by `finish`
                opened.close()
            if self._folder is not None:
                with suppress(OSError):  # a folder that was removed during the run
                    self._folder.close()

    def _claim(self) -> None:
        """Remove the results of an earlier run from the output folder."""
        if self._folder is not None and not self._is_claimed:
            with write_errors(self._options.output_dir):
                self._folder.claim()
            self._is_claimed = True

    def _check(self) -> None:
        """Check before the run that all results can be written."""
        options = self._options
        check_parquet(options)
        if options.report and options.output_dir is None:
            raise UsageError("`--report` needs an output folder", help="add `-o DIR`")
        if options.trace == STDOUT and options.json:
            raise UsageError("`--json` and `--trace -` both write to stdout", help="name a file for the trace")
        traces = {resolved(path) for path in self._trace_paths}
        results = [*self._junit_paths, *self._with_folder(None, _COVERAGE)]
        for path in results:
            if resolved(path) in traces and resolved(path).parent != Path("/dev"):
                raise UsageError(f"the trace and the result would be written to the same file, {path}")
        for path in results:
            check_writable(path)

    def _traces(self, opened: ExitStack) -> Iterator[JsonLines]:
        """Open the requested traces."""
        paths = self._trace_paths
        if self._options.trace != STDOUT and not paths:
            return
        from seoro.runtime.trace.jsonl import JsonLines  # noqa: PLC0415 - for runs with a trace only

        if self._options.trace == STDOUT:
            yield JsonLines(unbuffered(sys.stdout), "stdout")
        for path in paths:
            yield JsonLines(opened.enter_context(_create(path)), str(path))

    def check_inputs(self, inputs: Iterable[Path]) -> None:
        """Check that no output overwrites a file that the run reads.

        Args:
            inputs: Files that the run reads.

        Raises:
            UsageError: An output is an input.
        """
        outputs = {path.resolve() for path in [*self._trace_paths, *self._junit_paths]}
        if self._options.output_dir:
            outputs |= {(self._options.output_dir / name).resolve() for name in RESULT_NAMES}
        if self._options.record_video:
            outputs.add(Path(self._options.record_video).resolve())
        for path in inputs:
            if path.resolve() in outputs:
                self._are_inputs = True
                raise UsageError(
                    f"the output would overwrite {path}, which the run reads", help="choose another output"
                )

    def on_failure(self, callback: Callable[[Exception], object]) -> None:
        """Register a callback for write errors of traces; it is called in another thread."""
        for trace in self.traces:
            trace.on_error = callback

    async def finish(self) -> Exception | None:
        """Wait until the traces are complete; return the first error, if any."""
        failed: Exception | None = None
        for trace in self.traces:
            try:
                await trace.finish()
            except Exception as error:
                failed = failed or error
                if isinstance(error, OSError) and error.filename == "stdout":
                    silence(sys.stdout)
        return failed

    def write(
        self, verdict: Verdict, parameters: Mapping[str, object], reason: str, artifacts: Sequence[Artifact]
    ) -> list[tuple[Path, str]]:
        """Write all other files; return all files with descriptions.

        Raises:
            UsageError: A file cannot be written.
        """
        folder: Path | None = self._options.output_dir
        written = [(path, "trace of the run") for path in self._trace_paths]
        if folder:
            for artifact in artifacts:
                path = folder / Path(artifact.name).name
                _write(path, artifact.data)
                written.append((path, artifact.description))
                if self._options.parquet:
                    written += as_parquet(path, artifact.data, artifact.description, _write)
            from seoro.cli.recordings import recorded  # noqa: PLC0415 - for runs with `-o` only

            written += recorded(folder / TRACE)
            written += _write_coverage(folder / _COVERAGE, verdict)
        if self._junit_paths:
            from seoro.runtime.trace.junit import case_of, junit  # noqa: PLC0415 - XML takes long to load

            written += self._write_junit(junit([case_of(verdict, parameters, reason)]))
        if folder and self._options.report:
            written.append(_write_report(folder))
        return written

    @contextmanager
    def writing_refusals(self) -> Iterator[None]:
        """Write the result of a file that the block cannot run, and print it for `--json`.

        Write errors are ignored; the error of the file, the options or the simulator propagates.
        """
        try:
            yield
        except (InvalidScenario, UsageError, BackendError) as error:
            self._write_unrun(shown_name(self._options.file), error)
            raise

    def _write_unrun(self, file: str, error: SeoroError) -> None:
        from seoro.cli.terminal import error_text  # noqa: PLC0415 - imports this module

        self.result = found = unrun(file, error)
        self._remove_empty_traces()
        if self._options.json and self._options.trace != STDOUT:
            print_json(found)
        if self._junit_paths and not self._options.dry_run and not self._are_inputs:
            from seoro.runtime.trace.junit import junit, unrun_case  # noqa: PLC0415 - as above

            with suppress(UsageError):
                self._claim()
                self._write_junit(junit([unrun_case(file, found["status"], found["reason"], error_text(error))]))

    def _remove_empty_traces(self) -> None:
        """Remove empty traces of a run that did not start."""
        for path in self._trace_paths if self.traces else ():
            with suppress(OSError):
                if path.is_file() and not path.is_symlink() and path.stat().st_size == 0:
                    path.unlink()

    def _write_junit(self, document: str) -> list[tuple[Path, str]]:
        for path in self._junit_paths:
            _write(path, document.encode())
        return [(path, "result as JUnit XML") for path in self._junit_paths]

    def _with_folder(self, named: Path | None, name: str) -> list[Path]:
        """Return the named file, if any, and the file of this name in the output folder."""
        folder: Path | None = self._options.output_dir
        files: dict[Path, Path] = {}
        for path in filter(None, (named, folder and folder / name)):
            files.setdefault(resolved(path), path)
        return list(files.values())


def _write_coverage(path: Path, verdict: Verdict) -> list[tuple[Path, str]]:
    """Write the samples of coverage items, if there are any."""
    if not verdict.coverage:
        return []
    found = {
        "scenario": verdict.scenario,
        "file": verdict.file,
        "seed": verdict.seed,
        "coverage": [item.plain() for item in verdict.coverage],
    }
    from seoro.runtime.trace.jsonl import to_json  # noqa: PLC0415 - seldom needed

    _write(path, f"{to_json(found)}\n".encode())
    return [(path, "samples of coverage items")]


def result(
    verdict: Verdict, parameters: Mapping[str, object], files: Sequence[tuple[Path, str]]
) -> dict[str, Any]:
    """Return the result of a run as JSON data."""
    return {
        "status": verdict.status.value,
        "reason": verdict.reason,
        "source": str(verdict.span) if verdict.span else "",
        "explanation": verdict.explanation.plain() if verdict.explanation else None,
        "scenario": verdict.scenario,
        "file": verdict.file,
        "seed": verdict.seed,
        "duration": verdict.duration,
        "wall_duration": verdict.wall_duration,
        "parameters": parameters,
        "cancelled": [each.plain() for each in verdict.cancelled],
        "margin": verdict.margin,
        "requirements": list(verdict.requirements),
        "unobserved": list(verdict.unobserved),
        "coverage": [item.plain() for item in verdict.coverage],
        "files": [str(path) for path, _ in files],
    }


def unrun(file: str, error: SeoroError) -> dict[str, Any]:
    """Return the result of a file that could not be run as JSON data, with status `invalid` or `error`."""
    from seoro.cli.terminal import diagnostics_of  # noqa: PLC0415 - imports this module
    from seoro.lang.render import to_json as diagnostic_json  # noqa: PLC0415 - the same

    diagnostics = diagnostics_of(error)
    more = f", and {len(diagnostics) - 1} more" if len(diagnostics) > 1 else ""
    return {
        "status": "error" if isinstance(error, BackendError) else "invalid",
        "reason": diagnostics[0].message + more if diagnostics else str(error),
        "file": file,
        "diagnostics": [diagnostic_json(diagnostic) for diagnostic in diagnostics],
    }


def print_json(value: object) -> None:
    """Print data as JSON in one line."""
    from seoro.runtime.trace.jsonl import to_json  # noqa: PLC0415 - for `--json` only

    print(to_json(value))


def silence(file: IO[str]) -> None:
    """Discard further output to a file without a reader, such as a pipe to `head`.

    Otherwise Python would print an error when it flushes the file at exit.
    """
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())


def _write_report(folder: Path) -> tuple[Path, str]:
    """Write the report of a finished run, after all files that it shows."""
    from seoro.cli.report_command import write_file  # noqa: PLC0415 - for `--report` only
    from seoro.report.page import REPORT  # noqa: PLC0415 - the same

    path = folder / REPORT
    write_file(str(folder / TRACE), folder, path)
    return path, "report of the run: open it in a browser"


def _create(path: Path) -> FileIO:
    """Open a file for writing; create its folder if missing."""
    with write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("wb", buffering=0)


def _write(path: Path, data: bytes) -> None:
    with write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            path.write_bytes(data)
        except OSError:
            if path.is_file() and not path.is_symlink():
                path.unlink()  # a partial result could be mistaken for a complete one
            raise


def check_writable(path: Path) -> None:
    """Check that a file can be written, without creating it: an empty file could be mistaken for a result."""
    with write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        raise UsageError(f"cannot write {path}: is a folder")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UsageError(f"cannot write {path}: {os.strerror(errno.EACCES)}")
