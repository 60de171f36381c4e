"""`seoro mcp`: serve scenarios and results to agents over the Model Context Protocol."""

from __future__ import annotations

import argparse
import logging
from pathlib import Path
from typing import Final

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.packages import require
from seoro.text.logs import log_to_stderr

EXAMPLES: Final = """examples:
  seoro mcp                        (started by a client, see docs/how-to/agents.md)
  seoro mcp scenarios/
  seoro mcp --allow-run .

The server speaks on stdin and stdout, and ends with all its runs when the client disconnects."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "folder",
        metavar="FOLDER",
        nargs="?",
        type=Path,
        default=Path(),
        help="folder with scenarios and results; no other files are served (default: the current folder)",
    )
    add_option(
        parser, "--allow-run", "let agents run scenarios in simulators, with your rights (default: read only)"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    require("`seoro mcp`", "mcp", "mcp")
    log_to_stderr(logging.BASIC_FORMAT, logging.DEBUG if options.debug else logging.WARNING)
    import anyio  # noqa: PLC0415 - for this command only

    return anyio.run(_serve, options)


async def _serve(options: argparse.Namespace) -> int:
    from seoro.cli.signals import Terminated, cancel_on_signals, status_of  # noqa: PLC0415 - as above
    from seoro.mcp.server import serve  # noqa: PLC0415 - optional, and slow to load

    try:
        with cancel_on_signals():
            await serve(options.folder, allow_run=options.allow_run)
    except Terminated as ended:
        return status_of(ended.number)
    return Exit.PASSED
