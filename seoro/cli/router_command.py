"""`seoro router`: be a Zenoh router, where executors, simulators and bridges meet."""

from __future__ import annotations

import argparse

import anyio

from seoro.background import background
from seoro.cli.exits import Exit
from seoro.cli.keys_arguments import add_keys_argument
from seoro.cli.signals import ending_signals
from seoro.errors import InvalidUse, cause_of

EXAMPLES = """examples:
  seoro router
  seoro router --keys hub.keys --listen tls/0.0.0.0:7447
  seoro serve --keys lab-a.keys --connect tls/hub.example.org:7447      (on another machine)

It ends on Ctrl-C."""
ENDPOINT = "tcp/127.0.0.1:7447"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--listen", metavar="ENDPOINT", default=ENDPOINT, help="Zenoh endpoint to listen on (default: %(default)s)"
    )
    add_keys_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.bridges.session import SessionError  # noqa: PLC0415 - Zenoh, for this command only

    try:
        anyio.run(_route, options)
    except (SessionError, ExceptionGroup) as error:
        cause = cause_of(error)
        if not isinstance(cause, SessionError):
            raise
        raise InvalidUse(str(cause), help="`--listen` names another endpoint") from error
    return Exit.PASSED


async def _route(options: argparse.Namespace) -> None:
    from seoro.bridges.routing import route  # noqa: PLC0415 - Zenoh, for this command only

    def ready() -> None:
        print(f"the router listens on {options.listen}; Ctrl-C ends it", flush=True)

    with anyio.open_signal_receiver(*ending_signals()) as signals:
        async with background() as tasks:
            tasks.start_soon(route, options.listen, None, ready)
            async for _ in signals:
                break
