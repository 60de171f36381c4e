"""The files that a run leaves: traces, which grow with it, and its result as JUnit XML and JSON."""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, Self

from seoro.errors import BackendError, InvalidScenario, InvalidUse, SeoroError
from seoro.lang.render import to_json as diagnostic_json
from seoro.runtime.jsonl import JsonLines, to_json
from seoro.runtime.verdict import Verdict
from seoro.runtime.writer import unbuffered

if TYPE_CHECKING:
    from seoro.bridges.wire import Artifact

STDOUT = "-"
_COVERAGE = "coverage.json"


def add_result_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options that say what is shown and written of a run."""
    parser.add_argument(
        "-o",
        "--output-dir",
        type=Path,
        metavar="DIR",
        help="write trace, test.xml, coverage.json and pictures there",
    )
    parser.add_argument("--trace", metavar="FILE", help="write the trace (JSON Lines) there; - for stdout")
    parser.add_argument(
        "-t", "--live-tree", action="store_true", help="show the tree of what runs, drawn again as it changes"
    )
    parser.add_argument("--junit", type=Path, metavar="FILE", help="write the result as JUnit XML there")
    parser.add_argument(
        "--json", action="store_true", help="print the result, or the chosen values, as one JSON object on stdout"
    )


class ResultFiles:
    """The files that the options of a command line ask for; traces are open while the block lasts.

    Args:
        options: With `trace`, `junit` and `output_dir`.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._open = ExitStack()
        self.traces: list[JsonLines] = []  # observers

    def __enter__(self) -> Self:
        """Open the traces; a dry run writes nothing.

        Raises:
            InvalidUse: One cannot be written, or there will be no place for the result.
        """
        options = self._options
        if options.dry_run:
            return self
        self._check()
        with ExitStack() as opened:
            if options.trace == STDOUT:
                self.traces.append(JsonLines(unbuffered(sys.stdout), "stdout"))
            self.traces += [self._trace(path, opened) for path in self._trace_paths()]
            self._open = opened.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OSError):  # said by `finish`
            self._open.close()

    def _check(self) -> None:
        """Refuse before the run what would be wrong after it."""
        options = self._options
        if options.trace == STDOUT and options.json:
            raise InvalidUse("`--json` and `--trace -` both write to stdout", help="name a file for the trace")
        traces = {path.resolve() for path in self._trace_paths()}
        results = [*self._junit_paths(), *self._with_folder([], _COVERAGE)]
        for path in results:
            if path.resolve() in traces and path.resolve().parent != Path("/dev"):
                raise InvalidUse(f"both the trace and the result would be written to {path}")
        for path in results:
            check_place(path)

    @staticmethod
    def _trace(path: Path, opened: ExitStack) -> JsonLines:
        return JsonLines(opened.enter_context(_create(path)), str(path))

    def when_failed(self, tell: Callable[[Exception], object]) -> None:
        """Have something called, in another thread, as soon as a trace cannot be written."""
        for trace in self.traces:
            trace.when_failed(tell)

    async def finish(self) -> Exception | None:
        """Wait until the traces are complete; returns why one is not."""
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
        self, verdict: Verdict, parameters: Mapping[str, object], why: str, artifacts: Sequence[Artifact]
    ) -> list[tuple[Path, str]]:
        """Write the rest; returns all files, and what they are.

        Raises:
            InvalidUse: One cannot be written.
        """
        folder: Path | None = self._options.output_dir
        written = [(path, "every step of the run") for path in self._trace_paths()]
        if folder:
            for artifact in artifacts:
                path = folder / Path(artifact.name).name
                _write(path, artifact.data)
                written.append((path, artifact.description))
            written += _write_coverage(folder / _COVERAGE, verdict)
        if self._junit_paths():
            from seoro.runtime.junit import case_of, junit  # noqa: PLC0415 - XML takes long to load

            written += self._write_junit(junit([case_of(verdict, parameters, why)]))
        return written

    def write_unrun(self, file: str, error: SeoroError, text: str) -> None:
        """Write, and print for `--json`, the result of a file that could not be run.

        What cannot be written is not said besides.

        Args:
            file: The file.
            error: What is wrong with it, with how it was to be run, or with the simulator.
            text: The same in full, for people.
        """
        found = unrun(file, error)
        if self._options.json and self._options.trace != STDOUT:
            print(to_json(found))
        if self._junit_paths() and not self._options.dry_run:
            from seoro.runtime.junit import junit, unrun_case  # noqa: PLC0415 - as above

            with suppress(InvalidUse):
                self._write_junit(junit([unrun_case(file, found["status"], found["reason"], text)]))

    def _write_junit(self, document: str) -> list[tuple[Path, str]]:
        for path in self._junit_paths():
            _write(path, document.encode())
        return [(path, "result as JUnit XML") for path in self._junit_paths()]

    def _trace_paths(self) -> list[Path]:
        trace = [Path(self._options.trace)] if self._options.trace not in (None, STDOUT) else []
        return self._with_folder(trace, "trace.jsonl")

    def _junit_paths(self) -> list[Path]:
        return self._with_folder([self._options.junit] if self._options.junit else [], "test.xml")

    def _with_folder(self, named: list[Path], name: str) -> list[Path]:
        """The files that are named, and that of the output folder if it is another."""
        folder = self._options.output_dir
        inside = [folder / name] if folder else []
        return [*named, *(path for path in inside if path.resolve() not in {other.resolve() for other in named})]


def _write_coverage(path: Path, verdict: Verdict) -> list[tuple[Path, str]]:
    """Write what was sampled of coverage items; where there is none, nothing stays there of another run."""
    if not verdict.coverage:
        with suppress(OSError):
            path.unlink()
        return []
    found = {
        "scenario": verdict.scenario,
        "file": verdict.file,
        "seed": verdict.seed,
        "coverage": [item.plain() for item in verdict.coverage],
    }
    _write(path, f"{to_json(found)}\n".encode())
    return [(path, "what was sampled of coverage items")]


def result(
    verdict: Verdict, parameters: Mapping[str, object], files: Sequence[tuple[Path, str]]
) -> dict[str, Any]:
    """The result of a run as plain data, for `--json`."""
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
        "coverage": [item.plain() for item in verdict.coverage],
        "files": [str(path) for path, _ in files],
    }


def unrun(file: str, error: SeoroError) -> dict[str, Any]:
    """The result of a file that could not be run, as plain data: `invalid`, or an error of the simulator."""
    diagnostics = error.diagnostics if isinstance(error, InvalidScenario) else ()
    if isinstance(error, InvalidUse) and error.diagnostic is not None:
        diagnostics = (error.diagnostic,)
    more = f", and {len(diagnostics) - 1} more" if len(diagnostics) > 1 else ""
    return {
        "status": "error" if isinstance(error, BackendError) else "invalid",
        "reason": diagnostics[0].message + more if diagnostics else str(error),
        "file": file,
        "diagnostics": [diagnostic_json(diagnostic) for diagnostic in diagnostics],
    }


def silence(file: IO[str]) -> None:
    """Let what is still written to a file that nobody reads any more, such as a pipe to `head`, go nowhere.

    Else Python itself would complain when it flushes the file at its end.
    """
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())


def _create(path: Path) -> FileIO:
    """Open a file for writing, in a folder that is made for it."""
    with _refusing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("wb", buffering=0)


def _write(path: Path, data: bytes) -> None:
    with _refusing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            path.write_bytes(data)
        except OSError:
            if path.is_file() and not path.is_symlink():
                path.unlink()  # half of a result would be taken for one
            raise


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """Says for a file that cannot be written which one it is."""
    try:
        yield
    except OSError as error:
        raise InvalidUse(f"cannot write {path}: {error.strerror}") from error


def check_place(path: Path) -> None:
    """Check that a file can be written, without writing it: an empty one would be taken for a result."""
    with _refusing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        raise InvalidUse(f"cannot write {path}: it is a folder")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InvalidUse(f"cannot write {path}: {os.strerror(errno.EACCES)}")
