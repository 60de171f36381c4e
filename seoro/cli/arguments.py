"""Reading command lines: what is wrong with one is said in one error, with what would be right."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from typing import NoReturn

from seoro.cli.exits import Exit
from seoro.lang.diagnostics import near

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
