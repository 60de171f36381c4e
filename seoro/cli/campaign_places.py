"""Options that choose where the runs of a campaign are carried out."""

from __future__ import annotations

import argparse

from seoro.campaign.places import HERE, Places
from seoro.cli.arguments import add_option, option_texts
from seoro.cli.remote_arguments import add_executor_argument


def add_places(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    group = parser.add_argument_group("places")
    add_option(group, "-j --jobs N", "number of simultaneous runs on this machine (default: number of processors)")
    add_option(
        group,
        "--on EXECUTOR",
        f"use the slots of this executor, started with `seoro serve`; `{HERE}` is this machine (default: {HERE})",
        repeatable=True,
    )
    add_executor_argument(group)
    add_option(
        group,
        "--dask ADDRESS",
        "use a Dask cluster: the address of its scheduler, or local:N for N processes (needs seoro[dask])",
    )


def places_of(options: argparse.Namespace) -> Places:
    """Return the places that the options choose."""
    return Places(options.jobs, tuple(options.on), options.executor, options.dask)


def place_texts(options: argparse.Namespace) -> list[str]:
    """Return the options that choose other places than the default, as arguments of the command line."""
    return option_texts(options, ["on", "executor", "dask", "keys"])
