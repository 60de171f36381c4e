"""Options of `seoro campaign run` that list or write its runs instead of running them."""

from __future__ import annotations

import shlex
from itertools import islice
from pathlib import Path
from typing import Final

from seoro.campaign.after.exec_options import words_beyond_directives
from seoro.campaign.emit import Emitter
from seoro.campaign.listing import possible_runs
from seoro.campaign.opening import Asked
from seoro.campaign.runs import title_of
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.cli.arguments import Container, add_option
from seoro.cli.files import count, write_errors
from seoro.embed import Scenario
from seoro.embed.options import Options
from seoro.errors import UsageError

LISTED: Final = 100  # runs, without `--runs`
MOST: Final = 10_000  # files


def add_listing(parser: Container) -> None:
    """Declare the options."""
    add_option(parser, "--list", f"list the first {LISTED} runs, or as many as `--runs`, without running them")
    add_option(parser, "--emit DIR", "write each run as a scenario file, without running it")


def list_runs(space: Space, asked: Asked) -> None:
    """Print what varies, and the first runs.

    Raises:
        UsageError: The strategy cannot be used with these axes, or no run is possible.
    """
    runs = possible_runs(space, asked)
    listed = list(runs) if asked.runs is not None else list(islice(runs, LISTED))
    for axis in space.axes:
        print(f"  {axis.path} in {_values(axis)}")
    if not space.axes:
        print("  nothing varies; `--vary 'PARAMETER in [VALUE, VALUE]'` varies a parameter")
    print()
    width = len(str(max((run.number for run in listed), default=0)))
    for run in listed:
        print(f"{run.number:>{width}}  {title_of(run.values)}  seed {run.seed}")
    if next(runs, None) is not None:
        print(f"{'':>{width}}  and more; `--runs N` lists the first N")


def _values(axis: Axis) -> str:
    if isinstance(axis, Choices):
        return f"[{', '.join(axis.texts)}]"
    return f"[{axis.text(axis.low)}..{axis.text(axis.high)}]"


def emit_runs(scenario: Scenario, options: Options, space: Space, asked: Asked, folder: Path) -> None:
    """Write the runs as scenario files, and print how to run one.

    Args:
        scenario: Result of `load`.
        options: Options that all runs share.
        space: Axes of the campaign, and their constraints.
        asked: The request.
        folder: Folder of the files.

    Raises:
        UsageError: No run is possible, there are too many, or a file cannot be written.
    """
    runs = list(islice(possible_runs(space, asked), MOST + 1))
    if len(runs) > MOST:
        raise UsageError(f"more than {MOST:,} files would be written", help="write fewer with `--runs N`")
    stem = Path(scenario.file.name).stem
    with write_errors(folder):
        emitter = Emitter(scenario, options, folder)
        for run in runs:
            emitter.write(f"{stem}_{run.number}.osc", run.values, run.seed)
    print(f"  {folder}/{stem}_*.osc  {count(len(runs))}")
    command = ["seoro", "exec", str(folder / f"{stem}_{runs[0].number}.osc"), *words_beyond_directives(options)]
    print(f"  run one with `{shlex.join(command)}`")
