"""Entry point of `seoro`: parse the command line, run a command, report errors."""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Coroutine, Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import Final

from seoro import __version__
from seoro.cli.arguments import Parser, add_option, using_keys
from seoro.cli.exit_status import Exit
from seoro.cli.output import print_error, terminal_columns
from seoro.errors import InvalidScenario, SeoroError, UsageError, cause_of
from seoro.lang.diagnostics import near

# Help texts of the commands, in the order of `--help`; modules of commands are loaded on demand.
COMMANDS: Final[Mapping[str, str]] = {
    "exec": "run a scenario in this process or on an executor",
    "campaign": "run a scenario many times, with planned values of its parameters",
    "check": "parse and check scenario files without running them",
    "trace": "print, filter, summarise or convert the trace of a run",
    "redact": "remove names, hosts, paths and chosen fields from a trace, before it is shared",
    "report": "write a page that shows a run: verdict, timeline, world, source, plots, causes",
    "compare": "find where two recorded runs first differ",
    "accept": "check a recorded trace against its scenario",
    "replay": "repeat a recorded run, with the events that its application emitted",
    "bag": "show the contents of a ROS 2 bag, or repair a truncated one",
    "fmt": "format scenario files (coding style guide of the standard)",
    "explain": "explain error codes, with examples",
    "dap": "run a debug adapter for editors (breakpoints, steps, variables)",
    "lsp": "run the language server for editors (diagnostics, completion, hover, definitions)",
    "serve": "run an executor: accept scenarios over the network and run them",
    "ui": "show and start runs in a browser: live and past, of this machine and of executors",
    "check-node": "check whether a simulator node keeps the rules of the protocol",
    "doctor": "check the installation and the network, and suggest fixes",
    "ps": "list the runs of executors",
    "attach": "follow a run on an executor from its first record to its end",
    "logs": "print the progress of a run on an executor so far",
    "stop": "stop runs on executors",
    "estop": "emergency stop: stop all robots, or the named ones, until they are released",
    "get": "download the output files of a run",
    "runs": "delete old runs by age and size",
    "rm": "delete a run and its files",
    "router": "run a Zenoh router that connects executors, simulators and bridges",
    "keys": "create, renew and revoke the keys of a lab",
    "lab": "show, lease, release and stop the robots of a lab",
    "sim": "start a simulator node that runs connect to",
    "bridge": "expose a simulator as ROS 2 nodes, or ROS 2 robots to seoro",
    "ros": "inspect and use a ROS 2 system: topics, services, actions, parameters, bags",
}

REPLACED: Final = {"sweep": "campaign run"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Command line; None for that of the process.

    Returns:
        The exit status.
    """
    arguments = _with_aliases(sys.argv[1:] if arguments is None else arguments)
    options, unknown = _parser(arguments).parse_known_args(arguments)
    if unknown:
        options.parser.refuse_unknown(unknown)
    options.arguments = arguments
    try:
        with using_keys(options):
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


def _parser(arguments: Sequence[str]) -> Parser:
    """Make the parser of a command line; only the chosen command has its options."""
    columns = terminal_columns() - 2
    parser = Parser(
        prog="seoro",
        formatter_class=partial(argparse.HelpFormatter, width=columns),
        description="Run OpenSCENARIO DSL scenarios against simulated and real robots.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"seoro {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
    if chosen in REPLACED:
        parser.refuse(f"`seoro {chosen}` was replaced", f"use `seoro {REPLACED[chosen]}`")
    if chosen is not None and chosen not in COMMANDS:
        parser.refuse(f"unknown command `{chosen}`", near(chosen, COMMANDS) or "`seoro --help` lists the commands")
    comes_first = chosen is not None and arguments[0] == chosen  # then no help lists the other commands
    for name, what in COMMANDS.items():
        if name != chosen:
            if not comes_first:
                commands.add_parser(name, help=what, add_help=False)
            continue
        module = import_module(f"seoro.cli.{name.replace('-', '_')}_command")
        command = commands.add_parser(
            name,
            help=what,
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
    gc.set_threshold(200_000, 20, 100)
    status = main()
    gc.freeze()
    return status


if __name__ == "__main__":
    sys.exit(run_process())
