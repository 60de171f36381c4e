"""`seoro get`: download the output files of a run."""

from __future__ import annotations

import argparse
from pathlib import Path

import anyio

from seoro.cli.arguments import add_option
from seoro.cli.files import write_errors
from seoro.cli.remote_arguments import add_run_argument, named_run
from seoro.embed.output_folder import OutputFolder
from seoro.runtime.execution.outputs import TRACE
from seoro.runtime.trace.jsonl import to_line
from seoro.text.printable import one_line

EXAMPLES = """examples:
  seoro get 3f9a
  seoro get 3f9a -o out/

Downloads the trace and the files of its actions and simulator. `seoro attach RUN -o DIR` also writes test.xml and
coverage.json."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_run_argument(parser)
    add_option(parser, "-o --output-dir DIR", "output folder (default: the id of the run)")


async def run(options: argparse.Namespace) -> None:
    """Run the command."""
    for path in await _get(options):
        print(one_line(str(path)))


async def _get(options: argparse.Namespace) -> list[Path]:
    async with named_run(options) as found:
        folder = options.output_dir or Path(found.id[:8])
        trace = folder / TRACE
        output = OutputFolder(folder)
        output.claim()
        with write_errors(trace):
            async with await anyio.open_file(trace, "wb") as file:
                async for record in found.records_so_far():
                    await file.write(to_line(record))
        try:
            return [trace, *await found.fetch(folder)]
        finally:
            output.close()
