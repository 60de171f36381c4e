"""`seoro exec --on`: run a scenario on an executor, with the same output and exit status as here."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import anyio

from seoro.bundle.packing import Bundle, pack
from seoro.cli.concluding import progress_of, tell_dry_run
from seoro.cli.exits import Exit
from seoro.cli.files import STDIN, STDIN_NAME, count, read_stdin, shown_name
from seoro.cli.film_arguments import film_of
from seoro.cli.following import Follower
from seoro.cli.lease_arguments import leasing_of
from seoro.cli.output import error_text
from seoro.cli.results import ResultFiles, check_place
from seoro.cli.run_arguments import inputs_of, settings_of, use_file_settings
from seoro.client import Client
from seoro.embed.checking import check_options
from seoro.embed.scenarios import Scenario, check_file
from seoro.embed.walltime import WallLimit
from seoro.errors import BackendError, InvalidScenario, InvalidUse
from seoro.film import Film
from seoro.lang.loader import read_file


def run_remote(options: argparse.Namespace) -> int:
    """Run the command."""
    files = ResultFiles(options)
    try:
        with TemporaryDirectory() as folder:
            scenario, contents = _read(options, Path(folder))
            limit = use_file_settings(options, scenario).limit
            files.check_inputs(inputs_of(options, scenario))
            film = film_of(options)
            bundle = _bundle(options, scenario, limit, contents, film and film[0])
            if options.dry_run:
                return anyio.run(_try, options, bundle)
            if film is not None:
                check_place(film[1])
            # Files are opened before there is a loop, which would keep Ctrl-C from one who waits for a pipe.
            with files:
                return anyio.run(_submit, options, bundle, files, film and film[1])
    except (InvalidScenario, InvalidUse, BackendError) as error:
        files.write_unrun(shown_name(options.file), error, error_text(error))
        raise


def _read(options: argparse.Namespace, folder: Path) -> tuple[Scenario, Path | None]:
    """Check the scenario without its Python; returns it, and the file with its text if that came from stdin.

    Raises:
        InvalidScenario: It has errors.
    """
    if options.file != STDIN:
        return check_file(options.file, import_python=False).without_errors(), None
    path, text = Path(STDIN_NAME), read_stdin()  # what it imports is looked for from the working directory
    contents = folder / "scenario.osc"
    contents.write_text(text, encoding="utf-8")
    scenario = check_file(
        path, import_python=False, read=lambda other: text if other == path else read_file(other)
    )
    return scenario.without_errors(), contents


def _bundle(
    options: argparse.Namespace, scenario: Scenario, limit: WallLimit, contents: Path | None, film: Film | None
) -> Bundle:
    """Pack what is sent; errors are found here, as far as that is possible without the executor."""
    settings = replace(settings_of(options), leasing=leasing_of(options))
    check_options(settings)
    return pack(scenario, settings, limit, contents, film)


async def _try(options: argparse.Namespace, bundle: Bundle) -> int:
    async with Client(options.executor) as client:
        found = await client.dry_run_bundle(options.on, bundle)
    progress = progress_of(options, sys.stderr if options.json else sys.stdout)
    sent = {"files": found.files, "bytes": found.size, "known": found.known}
    tell_dry_run(options, progress, found.seed, found.parameters, found.texts, bundle=sent)
    await progress.finish()
    there = f", {found.known} of which {options.on} has already" if found.known else ""
    print(f"note: {count(found.files)} with {found.size} bytes would be sent{there}", file=sys.stderr)
    return Exit.PASSED


async def _submit(options: argparse.Namespace, bundle: Bundle, files: ResultFiles, film: Path | None) -> int:
    async with Client(options.executor) as client:
        run = await client.submit_bundle(options.on, bundle, options.stop_if_lost, options.priority or 0)
        return await Follower(options, files, stops=True, film=film).follow(run)
