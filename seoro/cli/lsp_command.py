"""`seoro lsp`: the language server, for editors."""

from __future__ import annotations

import argparse
import gc
import json
import logging
import os
import sys
from importlib.util import find_spec
from typing import TYPE_CHECKING, BinaryIO, cast

from seoro.cli.exits import Exit
from seoro.errors import InvalidUse
from seoro.lsp.frames import Frames
from seoro.terminal_text import log_to_stderr

if TYPE_CHECKING:
    from seoro.lsp.server import SeoroServer

EXAMPLES = """examples:
  seoro lsp                        (started by an editor, see docs/editors.md)
  seoro lsp --tcp 127.0.0.1:2087   (for one editor that connects; to look into the server)

It ends when the editor goes."""

_PARSE_ERROR = -32700  # of JSON-RPC
_LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})  # whoever connects can read all files of the user


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--tcp", metavar="HOST:PORT", help="wait for a connection on this machine (default: stdin and stdout)"
    )
    parser.add_argument("--strict", action="store_true", help="report the use of extensions to the standard")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if find_spec("pygls") is None:
        raise InvalidUse("the language server needs pygls", help="install it with: pip install 'seoro[lsp]'")
    address = _address(options.tcp) if options.tcp is not None else None
    from seoro.lsp.features import make_server  # noqa: PLC0415 - slow to load, and optional

    log_to_stderr(logging.BASIC_FORMAT, logging.DEBUG if options.debug else logging.WARNING)
    _calm_collector()
    server = make_server(options.strict)
    if address is not None:
        print(f"waiting for an editor on {address[0]}:{address[1]}", file=sys.stderr, flush=True)
        server.start_tcp(*address)
    else:
        _serve_stdio(server)
    return Exit.PASSED


def _calm_collector() -> None:
    """Look for garbage less often: trees are many objects, and a quarter of the time would go into looking.

    An earlier analysis is garbage with cycles. It is collected after a few edits, before there are so many that
    collecting them takes longer than a check.
    """
    gc.freeze()
    gc.set_threshold(50_000, 4, 100)


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not port.isdecimal() or not 0 < int(port) < 2**16:
        raise InvalidUse(f"'{text}' is no address", help="it looks like 127.0.0.1:2087")
    if host.strip("[]") not in _LOOPBACK:
        raise InvalidUse(
            f"'{host}' is not this machine itself, and the server shows files to whoever connects",
            help=f"use 127.0.0.1:{port}",
        )
    return host.strip("[]"), int(port)


def _serve_stdio(server: SeoroServer) -> None:
    """Serve on stdin and stdout; what libraries print goes to stderr, as it would break the protocol."""
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        frames = Frames(sys.stdin.buffer, lambda reason: _refuse(out, reason))
        server.start_io(cast(BinaryIO, frames), out)


def _refuse(out: BinaryIO, reason: str) -> None:
    """Answer a frame that could not be read; its `id` is unknown. One write is one frame, whoever else writes."""
    error = {"code": _PARSE_ERROR, "message": reason}
    body = json.dumps({"jsonrpc": "2.0", "id": None, "error": error}).encode()
    out.write(b"Content-Length: %d\r\n\r\n%b" % (len(body), body))
    out.flush()
    logging.getLogger(__name__).error("%s", reason)
