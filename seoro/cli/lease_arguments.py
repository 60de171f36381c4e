"""The options by which `seoro exec` gets robots that others may have."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

from seoro.cli.arguments import positive
from seoro.embed.options import Leasing
from seoro.errors import InvalidUse


def add_lease_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare them."""
    group = parser.add_argument_group("robots that others may have")
    waiting = group.add_mutually_exclusive_group()
    waiting.add_argument(
        "--when-free", action="store_true", help="wait for busy robots, and for nodes that do not answer yet"
    )
    waiting.add_argument(
        "--wait", type=positive, metavar="SECONDS", help="wait for that, so long at most (default: not at all)"
    )
    group.add_argument("--lease", metavar="ID", help="have the robots of this lease of `seoro lab lease`")


def leasing_of(options: argparse.Namespace, say: Callable[[str], object] | None = None) -> Leasing:
    """How the options ask for robots.

    Args:
        options: Of the command line.
        say: Told who has them, while the run waits.
    """
    named: dict[str, object] = {"--when-free": options.when_free, "--wait": options.wait, "--lease": options.lease}
    if options.on is None:  # else it is about a place at the executor, too
        named["--priority"] = options.priority
    given = [name for name, value in named.items() if value is not None and value is not False]
    if given and options.lab is None and options.connect is None:
        raise InvalidUse(
            f"`{given[0]}` is about what others may have, too, and the run has nothing of that",
            help="`--lab` or `--connect` says what it has",
        )
    wait = math.inf if options.when_free else options.wait
    return Leasing(wait=wait, priority=options.priority or 0, lease=options.lease or "", say=say)
