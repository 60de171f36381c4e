"""`seoro exec --on`: run a scenario on an executor, with the output and exit status of a local run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import anyio

from seoro.bundle.pack import Bundle, pack
from seoro.cli.exit_status import Exit
from seoro.cli.files import STDIN, count, named_source
from seoro.cli.follower import Follower
from seoro.cli.report import RunReport
from seoro.cli.results import ResultFiles, check_writable
from seoro.cli.run_arguments import inputs_of, leasing_of, settings_of, use_file_settings
from seoro.cli.video_arguments import video_of
from seoro.client import Client
from seoro.embed.option_checks import check_options
from seoro.embed.scenarios import Scenario, check_file


def run_remote(options: argparse.Namespace, files: ResultFiles) -> int:
    """Run the command."""
    with files.writing_refusals(), TemporaryDirectory() as folder:
        scenario, contents = _read(options, Path(folder))
        limit = use_file_settings(options, scenario).limit
        files.check_inputs(inputs_of(options, scenario))
        video = video_of(options)
        settings = settings_of(options, leasing=leasing_of(options))
        check_options(settings)
        bundle = pack(scenario, settings, limit, contents, video and video[0])
        if options.dry_run:
            return anyio.run(_dry_run, options, bundle, files)
        if video is not None:
            check_writable(video[1])
        # Files first: an event loop would block Ctrl-C while a pipe waits for its reader.
        with files.open():
            return anyio.run(_submit, options, bundle, files, video and video[1])


def _read(options: argparse.Namespace, folder: Path) -> tuple[Scenario, Path | None]:
    """Check the scenario without its Python; return it, and a file with the text from stdin, if any.

    Raises:
        InvalidScenario: The scenario has errors.
    """
    path, read = named_source(options.file)
    scenario = check_file(path, import_python=False, read=read).without_errors()
    if options.file != STDIN:
        return scenario, None
    contents = folder / "scenario.osc"
    contents.write_text(scenario.file.text, encoding="utf-8")
    return scenario, contents


async def _dry_run(options: argparse.Namespace, bundle: Bundle, files: ResultFiles) -> int:
    async with Client(options.executor) as client:
        found = await client.dry_run_bundle(options.on, bundle)
    report = RunReport(options, files)
    sent = {"files": found.files, "bytes": found.size, "known": found.known}
    report.dry_run(found.seed, found.parameters, found.texts, bundle=sent)
    await report.finish()
    cached = f"; {options.on} already has {found.known} of them" if found.known else ""
    print(f"note: would send {count(found.files)} with {found.size} bytes{cached}", file=sys.stderr)
    return Exit.PASSED


async def _submit(options: argparse.Namespace, bundle: Bundle, files: ResultFiles, video: Path | None) -> int:
    async with Client(options.executor) as client:
        run = await client.submit_bundle(options.on, bundle, options.stop_if_lost, options.priority or 0)
        return await Follower(options, files, stops=True, video=video).follow(run)
