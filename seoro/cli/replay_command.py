"""`seoro replay`: repeat a recorded run, with the events that its application emitted."""

from __future__ import annotations

import argparse

from seoro.cli.arguments import add_keys_argument
from seoro.cli.exec_command import add_local_arguments
from seoro.cli.results import ResultFiles
from seoro.cli.trace_input import read_records
from seoro.embed.api import recorded_options

EXAMPLES = """examples:
  seoro exec maze.osc --clock virtual --trace trace.jsonl
  seoro replay trace.jsonl maze.osc --trace again.jsonl
  seoro replay trace.jsonl maze.osc --sim mujoco -o out/

Seed, parameters and clock are those of the trace, unless options give others.

exit status: as `seoro exec`"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("recorded", metavar="TRACE", help="trace of `seoro exec --trace`")
    parser.add_argument("file", metavar="SCENARIO", help="scenario file (.osc) of the run")
    parser.set_defaults(on=None, priority=None)
    add_local_arguments(parser)
    add_keys_argument(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from seoro.cli.exec_local import run_local  # noqa: PLC0415 - loads what runs a scenario

    options.recorded = read_records(options.recorded)
    recorded = recorded_options(options.recorded)
    options.external = recorded["external"]
    options.scenario = options.scenario or recorded["name"]
    options.seed = recorded["seed"] if options.seed is None else options.seed
    options.clock = options.clock or recorded["clock"]
    options.set = [*(f"{path}={value}" for path, value in recorded["overrides"].items()), *options.set]
    options.constrain = [*recorded["constraints"], *options.constrain]
    return run_local(options, ResultFiles(options))
