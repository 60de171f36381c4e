"""`seoro ui`: serve pages that show and start runs."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from seoro.bridges.addresses import EXECUTOR
from seoro.cli.arguments import add_keys_argument, add_option, number
from seoro.cli.event_loop import fast_loop
from seoro.cli.exit_status import Exit
from seoro.cli.files import state_folder
from seoro.cli.lab_command import VARIABLE as LAB
from seoro.cli.packages import require
from seoro.cli.serving import wait_for_signal
from seoro.errors import UsageError
from seoro.text.logs import log_to_stderr

if TYPE_CHECKING:
    from seoro.ui.server import SiteOptions

EXAMPLES = """examples:
  seoro ui
  seoro ui --demo
  seoro ui --listen lab-pc.example.org:7480 --certificate lab-pc.keys --keys ann.keys
  seoro ui results/ scenarios/ --port 8000

Open the printed URL in a browser: it has the access token. Ctrl-C ends the server."""
PORT = 7480
_port = number("a port from 0 to 65535", int, lambda port: 0 <= port <= 65_535)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "folders",
        metavar="FOLDER",
        nargs="*",
        type=Path,
        help="folder with runs, scenarios and campaigns (default: the current folder)",
    )
    place = parser.add_mutually_exclusive_group()
    add_option(
        place,
        "--connect ENDPOINT",
        f"Zenoh endpoint of executors or of their router (default: SEORO_EXECUTOR, else {EXECUTOR})",
    )
    add_option(place, "--demo", "show examples that come with seoro, in place of folders and executors")
    add_option(parser, "--lab FILE.yaml", "lab file, for the page of the lab (default: SEORO_LAB)", type=Path)
    where = parser.add_mutually_exclusive_group()
    add_option(
        where, "--port N", "port of the server, 0 for a free one (default: %(default)s)", type=_port, default=PORT
    )
    add_option(where, "--listen HOST:PORT", "listen for other machines, too, by TLS; needs `--certificate`")
    add_option(parser, "--certificate DIR", "folder of keys with the role site, for `--listen`", type=Path)
    add_keys_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    require("`seoro ui`", "ui", "starlette", "uvicorn", "websockets")
    from seoro.ui.examples import FOLDER  # noqa: PLC0415 - for this command only
    from seoro.ui.listening import Address, parse_address  # noqa: PLC0415 - the same
    from seoro.ui.server import SiteOptions  # noqa: PLC0415 - the same

    if options.demo and options.folders:
        raise UsageError("`--demo` shows its own folder", help="leave out the folders, or `--demo`")
    if options.certificate is not None and options.listen is None:
        raise UsageError("`--certificate` needs `--listen`", help="add `--listen HOST:PORT`")
    lab = options.lab or (Path(os.environ[LAB]) if os.environ.get(LAB) else None)
    settings = SiteOptions(
        (FOLDER,) if options.demo else tuple(options.folders) or (Path(),),
        state_folder() / "ui",
        options.connect,
        options.keys,
        Address(port=options.port) if options.listen is None else parse_address(options.listen),
        lab,
        options.demo,
        options.certificate,
    )
    log_to_stderr("%(message)s")
    return anyio.run(_serve, settings, backend_options={"loop_factory": fast_loop()})


async def _serve(settings: SiteOptions) -> int:
    from seoro.ui.server import open_site  # noqa: PLC0415 - as above

    async with open_site(settings) as served:
        print(f"{served.access.url}\nOpen this URL in a browser. Ctrl-C ends the server.", flush=True)
        await wait_for_signal()
    return Exit.PASSED
