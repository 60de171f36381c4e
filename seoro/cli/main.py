"""`seoro`: the commands, and what happens with errors."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from seoro import __version__
from seoro.cli import (
    check_command,
    exec_command,
    explain_command,
    fmt_command,
    lsp_command,
    sim_command,
    trace_command,
)
from seoro.cli.arguments import Parser
from seoro.cli.exits import Exit
from seoro.cli.output import print_error
from seoro.errors import BackendError, InvalidScenario, InvalidUse

COMMANDS = (
    exec_command,
    check_command,
    trace_command,
    fmt_command,
    explain_command,
    lsp_command,
    sim_command,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Of the command line; those of the process if they are None.

    Returns:
        The exit status.
    """
    options, unknown = _parser().parse_known_args(arguments)
    if unknown:
        options.parser.refuse_unknown(unknown)
    try:
        return int(options.run(options))
    except (InvalidScenario, InvalidUse) as error:
        print_error(error)
        return Exit.INVALID
    except BackendError as error:
        print_error(error)
        return Exit.ERROR
    except KeyboardInterrupt:
        return Exit.INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has gone; nothing more can be said.
        sys.stderr.close()
        return Exit.ERROR
    except OSError as error:
        print_error(error)
        return Exit.ERROR
    except Exception as error:
        if options.debug:
            raise
        while isinstance(error, ExceptionGroup):
            error = error.exceptions[0]
        print_error(RuntimeError(f"internal error: {type(error).__name__}: {error}; `--debug` shows where"))
        return Exit.ERROR


def _parser() -> Parser:
    parser = Parser(
        prog="seoro",
        description="Run OpenSCENARIO DSL scenarios against simulated and real robots.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"seoro {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for module in COMMANDS:
        command = commands.add_parser(
            module.NAME,
            help=module.HELP,
            description=module.HELP[0].upper() + module.HELP[1:] + ".",
            epilog=module.EXAMPLES,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        module.add_arguments(command)
        command.add_argument("--debug", action="store_true", help="show Python tracebacks of faults")
        command.set_defaults(run=module.run, parser=command)
    return parser


if __name__ == "__main__":
    sys.exit(main())
