"""Entry point of `seoro`: parse the command line, run a command, report errors."""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Coroutine, Sequence
from functools import partial
from importlib import import_module

from seoro import __version__
from seoro.cli.arguments import Parser, add_option, using_keys, using_variable
from seoro.cli.commands import COMMANDS, REPLACED, listed
from seoro.cli.exit_status import Exit
from seoro.cli.remote_arguments import EXECUTOR_VARIABLE, endpoint_of_project
from seoro.cli.terminal import print_error, terminal_columns
from seoro.errors import InvalidScenario, SeoroError, UsageError, cause_of
from seoro.lang.diagnostics import near


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Command line; None for that of the process.

    Returns:
        The exit status.
    """
    arguments = _with_aliases(sys.argv[1:] if arguments is None else arguments)
    parser = command_parser(arguments)
    if not arguments:
        parser.print_help(sys.stderr)
        return Exit.INVALID
    options, unknown = parser.parse_known_args(arguments)
    if unknown:
        options.parser.refuse_unknown(unknown)
    options.arguments = arguments
    try:
        with using_keys(options), using_variable(EXECUTOR_VARIABLE, endpoint_of_project(options)):
            status = options.run(options)
            if isinstance(status, Coroutine):
                import asyncio  # noqa: PLC0415 - for commands with an event loop only

                status = asyncio.run(status)
            return int(status or Exit.PASSED)
    except KeyboardInterrupt:
        return Exit.INTERRUPTED
    except Exception as error:
        error = cause_of(error)
        if options.debug and not isinstance(error, SeoroError | OSError):
            raise
        return _status_of(error)


def _with_aliases(arguments: Sequence[str]) -> Sequence[str]:
    """Replace habits from other tools, such as `run` by `exec`, and `trace redact` by `redact`."""
    match arguments:
        case ["run", *rest]:
            return ["exec", *rest]
        case ["help", *rest]:
            return [*rest[:1], "--help"]
        case ["trace", "redact", *rest]:
            return ["redact", *rest]
    return arguments


def _status_of(error: Exception) -> Exit:
    """Print an error and return its exit status."""
    match error:
        case InvalidScenario() | UsageError():
            print_error(error)
            return Exit.INVALID
        case BrokenPipeError():
            # The reader has closed the pipe; nothing more can be printed.
            sys.stderr.close()
        case SeoroError() | OSError():
            print_error(error)
        case _:
            print_error(
                RuntimeError(f"internal error: {type(error).__name__}: {error}; `--debug` shows the traceback")
            )
    return Exit.ERROR


def command_parser(arguments: Sequence[str]) -> Parser:
    """Make the parser of a command line; only the chosen command has its options."""
    columns = terminal_columns() - 2
    parser = Parser(
        prog="seoro",
        usage="%(prog)s [-h] [--version] COMMAND ...",
        formatter_class=partial(argparse.RawDescriptionHelpFormatter, width=columns),
        description="Run OpenSCENARIO DSL scenarios against simulated and real robots.",
        epilog=f"{listed(columns)}\n\n`seoro COMMAND --help` describes a command, with examples.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"seoro {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, help=argparse.SUPPRESS, prog="seoro")
    chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
    if chosen is None:
        return parser
    if chosen in REPLACED:
        parser.refuse(f"`seoro {chosen}` was replaced", f"use `seoro {REPLACED[chosen]}`")
    if chosen not in COMMANDS:
        parser.refuse(f"unknown command `{chosen}`", near(chosen, COMMANDS) or "`seoro --help` lists the commands")
    what, module = COMMANDS[chosen], import_module(f"seoro.cli.{chosen.replace('-', '_')}_command")
    command = commands.add_parser(
        chosen,
        description=what[0].upper() + what[1:] + ".",
        epilog=module.EXAMPLES,
        formatter_class=partial(argparse.RawDescriptionHelpFormatter, width=columns),
        allow_abbrev=False,
    )
    module.add_arguments(command)
    add_option(command, "--debug", "show Python tracebacks of errors")
    command.set_defaults(run=module.run, parser=command)
    return parser


def run_process() -> int:
    """Run the command of this process, with a tuned garbage collector.

    Most objects live as long as the process. Searching them for garbage, also at its end, finds none and takes a
    tenth of a short run.
    """
    if "_ARGCOMPLETE" in os.environ:
        from seoro.cli.completing import complete  # noqa: PLC0415 - at a TAB only

        complete()
    gc.set_threshold(200_000, 20, 100)
    status = main()
    gc.freeze()
    return status
