"""`seoro lsp`: run the language server for editors."""

from __future__ import annotations

import argparse
import gc
import json
import logging
import sys
from typing import TYPE_CHECKING, BinaryIO, cast

from seoro.cli.arguments import add_option
from seoro.cli.packages import require
from seoro.cli.stdio import protocol_output
from seoro.errors import UsageError
from seoro.lsp.frames import Frames
from seoro.text.logs import log_to_stderr

if TYPE_CHECKING:
    from seoro.lsp.server import SeoroServer

EXAMPLES = """examples:
  seoro lsp                        (started by an editor, see docs/how-to/edit.md)
  seoro lsp --tcp 127.0.0.1:2087   (for one editor that connects, to debug the server)

The server ends when the editor disconnects."""

_PARSE_ERROR = -32700  # of JSON-RPC
_LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})  # a client can read all files of the user


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(parser, "--tcp HOST:PORT", "listen for an editor on this machine (default: use stdin and stdout)")
    add_option(parser, "--strict", "also report extensions to the standard")


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    require("`seoro lsp`", "lsp", "pygls")
    address = _address(options.tcp) if options.tcp is not None else None
    from seoro.lsp.features import make_server  # noqa: PLC0415 - slow to load, and optional

    log_to_stderr(logging.BASIC_FORMAT, logging.DEBUG if options.debug else logging.WARNING)
    _tune_garbage_collector()
    server = make_server(options.strict)
    if address is not None:
        print(f"waiting for an editor on {address[0]}:{address[1]}", file=sys.stderr, flush=True)
        server.start_tcp(*address)
    else:
        _serve_stdio(server)


def _tune_garbage_collector() -> None:
    """Run the garbage collector less often: with many syntax trees, it would take a quarter of the time.

    Old analyses are garbage with cycles. They are collected after a few edits, before a collection takes longer
    than a check.
    """
    gc.freeze()
    gc.set_threshold(50_000, 4, 100)


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not port.isdecimal() or not 0 < int(port) < 2**16:
        raise UsageError(f"invalid address '{text}'", help="expected HOST:PORT, such as 127.0.0.1:2087")
    if host.strip("[]") not in _LOOPBACK:
        raise UsageError(
            f"'{host}' is not a loopback address; clients of the server can read all files",
            help=f"use 127.0.0.1:{port}",
        )
    return host.strip("[]"), int(port)


def _serve_stdio(server: SeoroServer) -> None:
    """Serve on stdin and stdout."""
    with protocol_output() as out:
        frames = Frames(sys.stdin.buffer, lambda reason: _refuse(out, reason))
        server.start_io(cast(BinaryIO, frames), out)


def _refuse(out: BinaryIO, reason: str) -> None:
    """Reply to an unreadable frame, whose `id` is unknown; a single write keeps the reply in one piece."""
    error = {"code": _PARSE_ERROR, "message": reason}
    body = json.dumps({"jsonrpc": "2.0", "id": None, "error": error}).encode()
    out.write(b"Content-Length: %d\r\n\r\n%b" % (len(body), body))
    out.flush()
    logging.getLogger(__name__).error("%s", reason)
