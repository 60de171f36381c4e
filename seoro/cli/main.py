"""`seoro`: the commands, and what happens with errors."""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Final

from seoro import __version__
from seoro.cli.arguments import Parser
from seoro.cli.exits import Exit
from seoro.cli.keys_arguments import using_keys
from seoro.cli.output import print_error
from seoro.errors import InvalidScenario, InvalidUse, SeoroError, cause_of
from seoro.lang.diagnostics import near

# What each command does, in the order of `--help`; its module is loaded when it is asked for.
COMMANDS: Final[Mapping[str, str]] = {
    "exec": "run a scenario here, in this process, or on an executor",
    "sweep": "run a scenario once for each combination of what varies in it",
    "check": "parse and check scenario files, without running",
    "trace": "show the trace of a run, sum it up, convert it",
    "accept": "check whether the trace of a run is accepted by its scenario",
    "bag": "show what is in a bag of ROS 2, and make one whole that was cut off",
    "fmt": "lay scenario files out after the standard's coding style guide",
    "explain": "say what the code of a message means, with examples",
    "lsp": "serve editors: diagnostics, completion, hover, definitions (Language Server Protocol)",
    "serve": "be an executor, which runs scenarios that come over the network",
    "doctor": "say what is installed and reachable, and what to do about what is not",
    "ps": "list the runs of executors",
    "attach": "follow a run on an executor, from its first record to its end",
    "logs": "show what has happened in a run on an executor so far",
    "stop": "stop runs on executors",
    "estop": "emergency stop: stop all robots of a lab, or those of some nodes, until they are released",
    "get": "bring home what a run on an executor has left",
    "rm": "have executors forget a run, with all that it has left",
    "router": "be a Zenoh router, where executors, simulators and bridges meet",
    "keys": "make the keys of a lab, which say who may take part over the network, and take them back",
    "lab": "robots of a lab: how they are, who has them; lease, release and stop them",
    "sim": "start a simulator node, for runs that connect to it",
    "bridge": "stand between seoro and ROS 2: show a simulator as a ROS 2 system",
    "ros": "look at a ROS 2 system, and talk to it",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Of the command line; those of the process if they are None.

    Returns:
        The exit status.
    """
    arguments = _with_aliases(sys.argv[1:] if arguments is None else arguments)
    options, unknown = _parser(arguments).parse_known_args(arguments)
    if unknown:
        options.parser.refuse_unknown(unknown)
    try:
        with using_keys(options):
            return int(options.run(options))
    except KeyboardInterrupt:
        return Exit.INTERRUPTED
    except Exception as error:
        error = cause_of(error)
        if options.debug and not isinstance(error, SeoroError | OSError):
            raise
        return _status_of(error)


def _with_aliases(arguments: Sequence[str]) -> Sequence[str]:
    """Replace what users of other tools type: `run` for `exec`, and `help COMMAND` for `COMMAND --help`."""
    match arguments:
        case ["run", *rest]:
            return ["exec", *rest]
        case ["help", *rest]:
            return [*rest[:1], "--help"]
    return arguments


def _status_of(error: Exception) -> Exit:
    """The exit status of what went wrong, which is printed."""
    match error:
        case InvalidScenario() | InvalidUse():
            print_error(error)
            return Exit.INVALID
        case BrokenPipeError():
            # Whoever read the output has gone; nothing more can be said.
            sys.stderr.close()
        case SeoroError() | OSError():
            print_error(error)
        case _:
            print_error(RuntimeError(f"internal error: {type(error).__name__}: {error}; `--debug` shows where"))
    return Exit.ERROR


def _parser(arguments: Sequence[str]) -> Parser:
    """The parser of a command line: of the commands, it knows the options of the one that comes first."""
    parser = Parser(
        prog="seoro",
        description="Run OpenSCENARIO DSL scenarios against simulated and real robots.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"seoro {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
    if chosen is not None and chosen not in COMMANDS:
        parser.refuse(f"unknown command `{chosen}`", near(chosen, COMMANDS) or "`seoro --help` lists the commands")
    for name, what in COMMANDS.items():
        if name != chosen:
            commands.add_parser(name, help=what)
            continue
        module = import_module(f"seoro.cli.{name}_command")
        command = commands.add_parser(
            name,
            help=what,
            description=what[0].upper() + what[1:] + ".",
            epilog=module.EXAMPLES,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        module.add_arguments(command)
        command.add_argument("--debug", action="store_true", help="show Python tracebacks of faults")
        command.set_defaults(run=module.run, parser=command)
    return parser


def run_process() -> int:
    """Run the command that this process was started for.

    What is loaded and built here lasts nearly as long as the process, so that looking through it for garbage, as
    Python does often and once more at its end, finds none and takes a tenth of a short run.
    """
    gc.set_threshold(200_000, 20, 100)
    status = main()
    gc.freeze()
    return status


if __name__ == "__main__":
    sys.exit(run_process())
