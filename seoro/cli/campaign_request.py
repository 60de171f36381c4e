"""Options of `seoro campaign run`, as the request for a campaign."""

from __future__ import annotations

import argparse
import secrets
import sys
from collections.abc import Sequence

from seoro.campaign.opening import Asked, listed_seeds
from seoro.campaign.strategies.contract import Sampling, Strategy
from seoro.cli.campaign_strategies import chosen_strategy
from seoro.cli.parquet import add_parquet_argument, check_parquet
from seoro.cli.run_arguments import use_file_settings
from seoro.cli.video_arguments import OUTPUT_FOLDER, add_view_arguments, video_of
from seoro.embed import SEED_BITS
from seoro.embed.runnable import Runnable


def add_kept_files(parser: argparse.ArgumentParser) -> None:
    """Declare the options for the files of each run that is kept."""
    parser.add_argument(
        "--record-video",
        action="store_const",
        const=OUTPUT_FOLDER,
        help="record a video of each run, and keep it with the other files of the run",
    )
    add_view_arguments(parser)
    add_parquet_argument(parser)


def asked_of(options: argparse.Namespace, scenario: Runnable) -> Asked:
    """Return the request of the options and of the directives in the scenario file; fills in both.

    Raises:
        InvalidScenario, UsageError: A directive or an option is invalid.
    """
    found = use_file_settings(options, scenario, repeats=True)
    if options.seed is None:
        options.seed = secrets.randbits(SEED_BITS)
    _use_simulator_of_snapshot(options)
    film = video_of(options)
    check_parquet(options)
    strategy = chosen_strategy(options)
    seeds = _listed_seeds(options, strategy, found.seeds)
    return Asked(
        strategy=strategy,
        seed=options.seed,
        runs=options.runs,
        repeat=len(seeds) or options.repeat,
        keep=options.keep,
        isolation=options.isolation,
        limit=found.limit,
        until=tuple(options.until),
        budget=options.budget,
        seeds=seeds,
        film=None if film is None else film[0],
        parquet=options.parquet,
    )


def _use_simulator_of_snapshot(options: argparse.Namespace) -> None:
    """Name the simulator that saved the snapshot, so that the runs of a worker share one."""
    if options.from_snapshot is None:
        return
    from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415 - the messages of simulators

    saved_by = read_snapshot(options.from_snapshot).engine
    if options.sim is None and options.connect is None:
        options.sim = saved_by


def _listed_seeds(options: argparse.Namespace, strategy: Strategy, seeds: Sequence[int]) -> tuple[int, ...]:
    """Return the seeds of the file for each point; print a note if the strategy draws others."""
    if len(seeds) > 1 and options.repeat == 1 and strategy.sampling is not Sampling.NONE:
        print(
            f"note: {options.file}: the strategy `{strategy.name}` draws a seed for each run, beginning with "
            f"{seeds[0]}",
            file=sys.stderr,
        )
    return listed_seeds(strategy, options.repeat, seeds)
