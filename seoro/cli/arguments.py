"""Parsers and converters of command-line arguments; errors name the expected form."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final, NoReturn, TypeAlias, TypeVar

from seoro.bridges.addresses import LARGEST_DOMAIN
from seoro.cli.exit_status import Exit
from seoro.lang.diagnostics import near
from seoro.robotics.tracks import MAX_POSE_RATE
from seoro.security.keys import VARIABLE

Container: TypeAlias = "argparse._ActionsContainer"
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

N = TypeVar("N", int, float)

TEXT: Final = "text"  # output format for people
_OPTION = re.compile(r"--[a-z][a-z-]*")


class Parser(argparse.ArgumentParser):
    """Argument parser that prints errors in the format of seoro."""

    place = ""  # place in a file of the arguments, in front of errors

    def error(self, message: str) -> NoReturn:
        """Print an error and end the process."""
        self.refuse(message, f"see `{self.prog} --help`")

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse an unknown value and name the nearest valid one, while argparse lists all."""
        if action.choices is None or value in action.choices:
            return
        choices = [str(choice) for choice in action.choices]
        if isinstance(action, argparse._SubParsersAction):
            what = f"unknown command `{self.prog} {value}`"
        else:
            what = f"unknown value `{value}` of `{'/'.join(action.option_strings) or action.metavar}`"
        self.refuse(what, near(str(value), choices) or f"expected {', '.join(choices)}")

    def refuse(self, message: str, hint: str) -> NoReturn:
        """Print an error with a hint, and end the process."""
        print(f"error: {self.place}{message}\n  = help: {hint}", file=sys.stderr)
        sys.exit(Exit.INVALID)

    def refuse_unknown(self, arguments: Sequence[str]) -> NoReturn:
        """End the process because of unknown or surplus arguments.

        Args:
            arguments: At least one.
        """
        unknown = next((argument for argument in arguments if argument.startswith("-")), None)
        if unknown is None:
            self.error(f"unexpected argument `{arguments[0]}`: `{self.prog}` takes no more arguments")
        name = unknown.partition("=")[0]
        if self.prog.endswith(" exec"):
            from seoro.cli.habits import OPTIONS  # noqa: PLC0415 - for this error only

            if name in OPTIONS:
                self.refuse(f"unknown option `{name}` of `{self.prog}`", OPTIONS[name])
        options = _OPTION.findall(self.format_help())
        self.refuse(
            f"unknown option `{name}` of `{self.prog}`",
            f"write it after `{self.prog}`"
            if name in options
            else near(name, options) or f"`{self.prog} --help` lists the options",
        )


def seed(text: str) -> int:
    """Convert a seed.

    Raises:
        ArgumentTypeError: The text is invalid.
    """
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"invalid seed {text!r}: expected a whole number from 0")
    return int(text)


def number(wanted: str, read: Callable[[str], N], fits: Callable[[N], bool]) -> Callable[[str], N]:
    """Make a converter of numbers.

    Args:
        wanted: Expected value, for the message.
        read: Conversion of a text; raises `ValueError` if it is invalid.
        fits: Whether a number is valid.
    """

    def convert(text: str) -> N:
        with suppress(ValueError):
            value = read(text)
            if fits(value):
                return value
        raise argparse.ArgumentTypeError(f"expected {wanted}, found {text!r}")

    return convert


positive = number("a positive number", float, lambda value: 0.0 < value < math.inf)
seconds = number("a number from 0", float, lambda value: 0.0 <= value < math.inf)
whole = number("a whole number from 1", lambda text: int(text) if text.isdecimal() else 0, lambda value: value > 0)
integer = number("a whole number", int, lambda _: True)  # may be negative
pose_rate = number(
    f"a number from 0 to {MAX_POSE_RATE:g}", float, lambda value: 0.0 <= value <= MAX_POSE_RATE
)  # [1/s]
_rate = number("a positive number, or max", float, lambda value: 0.0 < value < math.inf)


share = number(
    "a share between 0 and 1, such as 2%",
    lambda text: float(text[:-1]) / 100.0 if text.endswith("%") else float(text),
    lambda value: 0.0 < value < 1.0,
)


def rate(text: str) -> float:
    """Convert a rate in simulated seconds per second; `max` becomes infinity."""
    return math.inf if text == "max" else _rate(text)


def with_unit(expected: str, units: Mapping[str, float]) -> Callable[[str], float]:
    """Return a type of options for numbers with a unit.

    Args:
        expected: The expected form, for messages.
        units: Factors by unit.
    """
    form = re.compile(rf"(?P<number>\d+(\.\d+)?)\s*(?P<unit>{'|'.join(units)})")

    def convert(text: str) -> float:
        parts = form.fullmatch(text)
        if parts is None:
            raise argparse.ArgumentTypeError(f"expected {expected}, found {text!r}")
        return float(parts["number"]) * units[parts["unit"]]

    return convert


duration = with_unit(
    "a duration such as 90s, 30min, 2h or 1d", {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0}
)  # [s]


def domain(text: str) -> int:
    """Convert a ROS 2 domain ID.

    Raises:
        ArgumentTypeError: The text is invalid.
    """
    if not (text.isascii() and text.isdecimal() and len(text) < 10 and int(text) <= LARGEST_DOMAIN):
        raise argparse.ArgumentTypeError(f"invalid domain ID {text!r}: expected 0 to {LARGEST_DOMAIN}")
    return int(text)


def pattern(text: str) -> re.Pattern[str]:
    """Compile a regular expression.

    Raises:
        ArgumentTypeError: The text is invalid.
    """
    try:
        return re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(f"invalid regular expression {text!r}: {error}") from None


# Types of options by the placeholder of their value.
_TYPES: Final[Mapping[str, Callable[[str], Any]]] = {
    "DIR": Path,
    "FILE": Path,
    "HZ": positive,
    "N": whole,
    "SECONDS": positive,
}


def add_option(parser: Container, spec: str, help_text: str, *, repeatable: bool = False, **more: Any) -> None:
    """Declare an option.

    Args:
        parser: Parser or group.
        spec: Names, and the placeholder of the value, such as `-o --output-dir DIR`. Without placeholder and
            choices, the option is a flag.
        help_text: Description.
        repeatable: Whether the option may occur several times; its value is a list.
        more: Other arguments of `add_argument`. The default `type` is that of the placeholder, such as a path for
            `DIR` and `FILE`.
    """
    *names, last = spec.split()
    if last.startswith("-"):
        names.append(last)
        if "choices" not in more:
            more["action"] = "store_true"
    else:
        more = {"metavar": last, "type": _TYPES.get(last), **more}
    if repeatable:
        more |= {"action": "append", "default": []}
        help_text += " (repeatable)"
    parser.add_argument(*names, help=help_text, **more)


def given_option(options: argparse.Namespace, *names: str) -> str | None:
    """Return the first of some options that is given, as the user writes it, such as `--model-path`."""
    for name in names:
        value = getattr(options, name)
        if value is not None and value is not False and value != []:
            return f"--{name.replace('_', '-')}"
    return None


def option_texts(options: argparse.Namespace, names: Sequence[str]) -> list[str]:
    """Format the given options as arguments of the command line."""
    texts = []
    for name in names:
        value = getattr(options, name)
        if value is True:
            texts.append(f"--{name.replace('_', '-')}")
            continue
        values = value if isinstance(value, list) else [] if value in (None, False) else [value]
        texts += [f"--{name.replace('_', '-')}={'max' if each == math.inf else each}" for each in values]
    return texts


def add_command(commands: Commands, name: str, what: str) -> argparse.ArgumentParser:
    """Add a subcommand; its help text is also its description."""
    parser = commands.add_parser(name, help=what, description=f"{what[0].upper()}{what[1:]}.", allow_abbrev=False)
    parser.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
    parser.set_defaults(parser=parser)
    return parser


def actions_of(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser and of its subcommands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from actions_of(command)
        else:
            yield action


def add_dialect(parser: Container, when: str = "") -> None:
    """Declare the option for the key format of a ROS 2 system on Zenoh."""
    add_option(
        parser,
        "--dialect",
        f"{when}key format of the ROS 2 system on Zenoh (default: detected)",
        choices=("auto", "rmw_zenoh", "ros2dds"),
        default="auto",
    )


def add_output_format(parser: Container) -> None:
    """Declare the options for the format of findings; `--json` is short for `--output-format json`."""
    from seoro.text.findings import FORMATS  # noqa: PLC0415 - for commands with findings only

    add_option(
        parser,
        "--output-format --format",
        "format of the results: text for people, or one for CI services and programs (default: text)",
        choices=(TEXT, *FORMATS),
        default=TEXT,
    )
    parser.add_argument(
        "--json",
        action="store_const",
        const="json",
        dest="output_format",
        help="short for --output-format json",
    )


def add_keys_argument(parser: Container) -> None:
    """Declare the option for the folder of keys."""
    add_option(
        parser,
        "--keys DIR",
        "folder of keys, for endpoints on other machines (default: SEORO_KEYS, else ~/.config/seoro/keys)",
    )


@contextmanager
def using_keys(options: argparse.Namespace) -> Iterator[None]:
    """Use the keys of the options in this process and its child processes, during the block."""
    folder: Path | None = getattr(options, "keys", None)
    with using_variable(VARIABLE, None if folder is None else str(folder.absolute())):
        yield


@contextmanager
def using_variable(name: str, value: str | None) -> Iterator[None]:
    """Set a variable of the environment; None leaves it.

    The block restores it at its end, for programs that call `main`.
    """
    if value is None:
        yield
        return
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = before
