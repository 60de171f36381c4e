"""Reading command lines: what is wrong with one is said in one error, with what would be right."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn, TypeAlias

from seoro.bridges.ros2.addresses import LARGEST_DOMAIN
from seoro.cli.exits import Exit
from seoro.lang.diagnostics import near

Container: TypeAlias = "argparse._ActionsContainer"

_OPTION = re.compile(r"--[a-z][a-z-]*")


class Parser(argparse.ArgumentParser):
    """A parser whose errors look like all others of seoro."""

    def error(self, message: str) -> NoReturn:
        """Print an error and end the process."""
        self.refuse(message, f"`{self.prog} --help` lists what there is")

    def refuse(self, message: str, hint: str) -> NoReturn:
        """Print an error with what to do, and end the process."""
        print(f"error: {message}\n  = help: {hint}", file=sys.stderr)
        sys.exit(Exit.INVALID)

    def refuse_unknown(self, arguments: Sequence[str]) -> NoReturn:
        """End the process because of arguments that the command does not take.

        Args:
            arguments: At least one.
        """
        unknown = next((argument for argument in arguments if argument.startswith("-")), None)
        if unknown is None:
            self.error(f"`{arguments[0]}` is too much: `{self.prog}` takes no more arguments")
        name = unknown.partition("=")[0]
        options = _OPTION.findall(self.format_help())
        self.refuse(
            f"`{self.prog}` has no option `{name}`",
            near(name, options) or f"`{self.prog} --help` lists those that it has",
        )


def seed(text: str) -> int:
    """A seed of the command line.

    Raises:
        ArgumentTypeError: It is none.
    """
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"a seed is a whole number from 0, not {text!r}")
    return int(text)


def number(text: str, wanted: str, fits: Callable[[float], bool]) -> float:
    """A finite number of the command line.

    Args:
        text: What the command line has.
        wanted: What it should be, for the message.
        fits: Whether a number is that.

    Raises:
        ArgumentTypeError: It is none, or it does not fit.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and fits(value)):
        raise argparse.ArgumentTypeError(f"expected {wanted}, not {text!r}")
    return value


def positive(text: str) -> float:
    """A positive number of the command line.

    Raises:
        ArgumentTypeError: It is none.
    """
    return number(text, "a positive number", lambda value: value > 0.0)


def rate(text: str) -> float:
    """Simulated seconds per second; infinite for `max`.

    Raises:
        ArgumentTypeError: It is no positive number.
    """
    return math.inf if text == "max" else number(text, "a positive number, or max", lambda value: value > 0.0)


def whole(text: str) -> int:
    """How many of something there are to be, at least one.

    Raises:
        ArgumentTypeError: It is no such number.
    """
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1, not {text!r}")
    return int(text)


def domain(text: str, called: str = "ROS_DOMAIN_ID") -> int:
    """The number of a domain of ROS 2.

    Raises:
        ArgumentTypeError: It is none.
    """
    if not (text.isascii() and text.isdecimal() and len(text) < 10 and int(text) <= LARGEST_DOMAIN):
        raise argparse.ArgumentTypeError(f"a {called} is a whole number from 0 to {LARGEST_DOMAIN}, not {text!r}")
    return int(text)


def add_dialect(parser: Container, when: str = "") -> None:
    """Declare the option that says how a ROS 2 system uses Zenoh."""
    parser.add_argument(
        "--dialect",
        choices=("auto", "rmw_zenoh", "ros2dds"),
        default="auto",
        help=f"{when}how the system uses Zenoh (default: what its tokens tell)",
    )


def add_folders(parser: Container, option: str, help_text: str) -> None:
    """Declare an option that names a folder each time that it is given."""
    parser.add_argument(
        option, type=Path, action="append", default=[], metavar="DIR", help=f"{help_text} (repeatable)"
    )
