"""`seoro router`: run a Zenoh router that connects executors, simulators and bridges."""

from __future__ import annotations

import argparse

from seoro.cli.arguments import add_keys_argument, add_option
from seoro.cli.serving import endpoint_errors, wait_for_signal
from seoro.concurrency.background import background

EXAMPLES = """examples:
  seoro router
  seoro router --keys hub.keys --listen tls/0.0.0.0:7447
  seoro serve --keys lab-a.keys --connect tls/hub.example.org:7447      (on another machine)

Ctrl-C ends the router."""
ENDPOINT = "tcp/127.0.0.1:7447"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(parser, "--listen ENDPOINT", "Zenoh endpoint to listen on (default: %(default)s)", default=ENDPOINT)
    add_keys_argument(parser)


async def run(options: argparse.Namespace) -> None:
    """Run the command."""
    from seoro.bridges.routing import run_router  # noqa: PLC0415 - Zenoh, for this command only

    def ready() -> None:
        print(f"router listening on {options.listen}; Ctrl-C ends it", flush=True)

    with endpoint_errors("`--listen`"):
        async with background() as tasks:
            tasks.start_soon(run_router, options.listen, None, ready)
            await wait_for_signal()
