"""`seoro exec --on`: run a scenario on an executor, with the same output and exit status as here."""

from __future__ import annotations

import argparse
from dataclasses import replace

import anyio

from seoro.bundle.packing import Bundle, pack
from seoro.cli.following import Follower
from seoro.cli.lease_arguments import leasing_of
from seoro.cli.output import error_text
from seoro.cli.results import ResultFiles
from seoro.cli.run_arguments import settings_of
from seoro.client import Client
from seoro.embed.checking import check_options
from seoro.embed.scenarios import check_file
from seoro.errors import BackendError, InvalidScenario, InvalidUse


def run_remote(options: argparse.Namespace) -> int:
    """Run the command."""
    files = ResultFiles(options)
    try:
        bundle = _bundle(options)
        with files:  # before there is a loop, which would keep Ctrl-C from one who waits for a pipe to be opened
            return anyio.run(_submit, options, bundle, files)
    except (InvalidScenario, InvalidUse, BackendError) as error:
        files.write_unrun(options.file, error, error_text(error))
        raise


def _bundle(options: argparse.Namespace) -> Bundle:
    """What is sent; what is wrong with it is said here, as far as that can be known without its Python."""
    settings = replace(settings_of(options), leasing=leasing_of(options))
    check_options(settings)
    scenario = check_file(options.file, import_python=False)
    if scenario.checked.errors:
        raise InvalidScenario(scenario.checked.errors)
    return pack(scenario, settings, options.timeout)


async def _submit(options: argparse.Namespace, bundle: Bundle, files: ResultFiles) -> int:
    async with Client(options.executor) as client:
        run = await client.submit_bundle(options.on, bundle, options.stop_if_lost, options.priority or 0)
        return await Follower(options, files, stops=True).follow(run)
