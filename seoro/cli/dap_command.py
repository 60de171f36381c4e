"""`seoro dap`: run a debug adapter for editors."""

from __future__ import annotations

import argparse
import asyncio
import sys

from seoro.cli.stdio import protocol_output
from seoro.errors import UsageError

EXAMPLES = """examples:
  seoro dap      (started by an editor, see docs/how-to/debug.md)

The adapter speaks the Debug Adapter Protocol on stdin and stdout, and ends when the editor disconnects."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    asyncio.run(_serve())


async def _serve() -> None:
    """Serve on stdin and stdout."""
    from seoro.dap.connection import Connection, InvalidMessage  # noqa: PLC0415 - slow to load
    from seoro.dap.session import Session  # noqa: PLC0415 - the same

    loop = asyncio.get_running_loop()
    with protocol_output() as out:
        reader = asyncio.StreamReader()
        try:
            await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
            transport, protocol = await loop.connect_write_pipe(asyncio.streams.FlowControlMixin, out)
        except ValueError as error:
            raise UsageError(
                "stdin and stdout are not pipes", help="an editor starts this command; see docs/how-to/debug.md"
            ) from error
        writer = asyncio.StreamWriter(transport, protocol, None, loop)
        try:
            await Session(Connection(reader, writer)).serve()
        except InvalidMessage as error:
            raise UsageError(f"invalid message of the editor: {error}") from error
        finally:
            writer.close()
