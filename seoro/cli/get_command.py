"""`seoro get`: bring home what a run on an executor has left."""

from __future__ import annotations

import argparse
from pathlib import Path

import anyio

from seoro.cli.exits import Exit
from seoro.cli.output_folder import OutputFolder
from seoro.cli.remote_arguments import add_run_argument, named_run
from seoro.errors import InvalidUse
from seoro.runtime.jsonl import to_line
from seoro.terminal_text import one_line

EXAMPLES = """examples:
  seoro get 3f9a
  seoro get 3f9a -o out/

Beside what its actions have left, that is the trace. `seoro attach RUN -o DIR` also writes test.xml and
coverage.json."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)
    parser.add_argument(
        "-o", "--output-dir", type=Path, metavar="DIR", help="where to (default: a folder with the id of the run)"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    for path in anyio.run(_get, options):
        print(one_line(str(path)))
    return Exit.PASSED


async def _get(options: argparse.Namespace) -> list[Path]:
    async with named_run(options) as found:
        folder = options.output_dir or Path(found.id[:8])
        trace = folder / "trace.jsonl"
        output = OutputFolder(folder)
        output.claim()
        try:
            async with await anyio.open_file(trace, "wb") as file:
                async for record in found.records_so_far():
                    await file.write(to_line(record))
        except OSError as error:
            raise InvalidUse(f"cannot write {trace}: {error.strerror}") from error
        try:
            return [trace, *await found.fetch(folder)]
        finally:
            output.close()
