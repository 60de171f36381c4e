"""`seoro campaign`: many runs of one scenario."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

import anyio

from seoro.campaign.opening import new_campaign, space_of
from seoro.campaign.places import Places, checked_places
from seoro.campaign.results.results import read
from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End
from seoro.campaign.session import Campaign
from seoro.campaign.starting import reopened
from seoro.campaign.store.folder import CAMPAIGN
from seoro.cli.arguments import add_command, add_option
from seoro.cli.campaign_after import AFTER, add_after
from seoro.cli.campaign_compare import add_compare, run_compare
from seoro.cli.campaign_coverage import add_coverage, print_coverage
from seoro.cli.campaign_end import CampaignEnd
from seoro.cli.campaign_file import is_campaign_file, use_campaign_file
from seoro.cli.campaign_import import add_import, import_vast
from seoro.cli.campaign_interruption import Interruption
from seoro.cli.campaign_listing import add_listing, emit_runs, list_runs
from seoro.cli.campaign_places import add_places, place_texts, places_of
from seoro.cli.campaign_progress import Progress, print_files, print_status, seeds_text
from seoro.cli.campaign_request import add_kept_files, asked_of
from seoro.cli.campaign_stopping import add_stopping, status_of_test
from seoro.cli.campaign_strategies import add_strategies
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.cli.notifying import add_notify_argument, notifying, use_notify
from seoro.cli.run_arguments import add_run_arguments, settings_of
from seoro.concurrency.background import background
from seoro.embed import load
from seoro.lang.projects import settings_around

EXAMPLES = """examples:
  seoro campaign run noise.osc --sim mujoco --rate max -o out/
  seoro campaign run noise.osc --strategy random --runs 2000 -o out/
  seoro campaign run noise.osc --strategy random --until 'rate >= 0.95 vs 0.90' --budget 1h -o out/
  seoro campaign status out/
  seoro campaign resume out/ --runs 5000
  seoro campaign report out/
  seoro campaign compare out-main/ out-branch/
  seoro campaign replay out/ 123
  seoro campaign shrink out/ 123
  seoro campaign neighbours out/ 123

A campaign varies each parameter with a constraint `in`, such as `keep(noise in [0.0, 0.1, 0.2])` or
`keep(noise in [0.0..0.2])`, that is not set with `--set` or `--params`.

exit status: 0 all passed, 1 some failed, 2 the command line or the scenario is invalid, 3 some ended without a
verdict, 130 by Ctrl-C, after which `resume` continues; with --until 'rate >= GOOD ...': 0 good, 1 bad,
3 undecided or some ended without a verdict"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    commands = parser.add_subparsers(title="subcommands", dest="what", metavar="SUBCOMMAND", required=True)
    run_it = add_command(commands, "run", "start a campaign")
    run_it.add_argument("file", metavar="FILE", help="scenario file (.osc), or campaign file (.yaml)")
    add_run_arguments(run_it)
    add_option(
        run_it, "-o --output-dir DIR", "folder of the campaign (default: campaign)", default=Path("campaign")
    )
    add_option(run_it, "--overwrite", "replace another campaign in the folder")
    add_option(
        run_it,
        "--vary EXPRESSION",
        "vary a parameter over values: 'pace in [1mps, 2mps]', or within bounds: 'pace in [1mps..2mps]'",
        repeatable=True,
    )
    add_strategies(run_it)
    add_option(run_it, "--runs N", "number of runs (default: all of the strategy)")
    add_stopping(run_it)
    add_option(run_it, "--repeat N", "runs of the same values, with the seeds SEED, SEED + 1, ...", default=1)
    add_option(
        run_it,
        "--keep",
        "runs that keep their trace and files (default: failed, which is all that did not pass)",
        choices=("failed", "all", "none"),
        default="failed",
    )
    add_option(
        run_it,
        "--isolation",
        "what runs share: a warm worker, a warm simulator but no process, or nothing (default: run for scenarios "
        "with Python of their own, else worker)",
        choices=("worker", "run", "process"),
    )
    add_kept_files(run_it)
    add_listing(run_it)
    resume = add_command(commands, "resume", "continue a campaign that was interrupted, or extend it")
    resume.add_argument("folder", metavar="FOLDER", type=Path, help="folder of the campaign")
    add_option(resume, "--runs N", "new number of runs")
    for each in (run_it, resume):
        add_places(each)
        add_notify_argument(each)
    status = add_command(commands, "status", "show how far a campaign is")
    status.add_argument("folder", metavar="FOLDER", type=Path, help="folder of the campaign")
    add_option(status, "--json", "print one JSON object")
    report = add_command(commands, "report", "write the results again: report.html, runs.csv, test.xml")
    report.add_argument("folder", metavar="FOLDER", type=Path, help="folder of the campaign")
    add_coverage(commands)
    add_compare(commands)
    add_after(commands)
    add_import(commands)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.what == "status":
        print_status(options.folder, as_json=options.json)
        return Exit.PASSED
    if options.what == "coverage":
        return print_coverage(options)
    if options.what == "compare":
        return run_compare(options)
    if options.what == "import":
        return import_vast(options)
    if options.what in AFTER:
        return AFTER[options.what](options)
    if options.what == "report":
        with write_errors(options.folder):
            print_files(read(options.folder).write())
        return Exit.PASSED
    if options.what == "run" and is_campaign_file(options.file):
        use_campaign_file(options)
    use_notify(
        options, settings_around(Path(options.file) if options.what == "run" else options.folder / CAMPAIGN)
    )
    return anyio.run(_run if options.what == "run" else _resume, options)


async def _run(options: argparse.Namespace) -> int:
    scenario = load(options.file)
    asked = asked_of(options, scenario)
    options.constrain += options.vary
    settings = settings_of(options)
    places, space = checked_places(places_of(options), settings), space_of(scenario, settings, options.vary)
    if options.list:
        list_runs(space, asked)
        return Exit.PASSED
    if options.emit is not None:
        emit_runs(scenario, settings, space, asked, options.emit)
        return Exit.PASSED
    with write_errors(options.output_dir):
        folder = new_campaign(scenario, settings, space, asked, options.output_dir, overwrite=options.overwrite)
    if settings.simulator is not None and options.rate is None:
        _print_note("simulators keep to real time: `--rate max` runs them as fast as possible")
    return await _carry_out(Campaign(folder, space, is_new=True), places, options)


async def _resume(options: argparse.Namespace) -> int:
    return await _carry_out(*reopened(options.folder, options.runs, places_of(options)), options)


async def _carry_out(campaign: Campaign, places: Places, options: argparse.Namespace) -> int:
    """Carry out a campaign, write its results, and notify, also when it is interrupted."""
    end = CampaignEnd(campaign)
    with notifying(options, "campaign", end.content):
        end.status = await _work(campaign, places, options)
    return end.status


async def _work(campaign: Campaign, places: Places, options: argparse.Namespace) -> Exit:
    file, varying = campaign.campaign, count(len(campaign.space.axes), "parameter")
    print(f"{file.manifest.shown}: {file.strategy.name} over {varying}, {seeds_text(file)}", flush=True)
    progress, interrupted = Progress(campaign.state), Interruption(campaign)
    files: list[Path] = []
    try:
        with progress.showing() as show:
            async with campaign.running(places, show, _print_note), background() as group:
                group.start_soon(interrupted.listen, group.cancel_scope)
                await campaign.wait()
    finally:
        if not campaign.is_discarded:
            files = campaign.write()
    print(f"\n{progress.text(is_over=not interrupted.has_come)}")
    if campaign.stopped is not None:
        print(f"  stopped: {campaign.stopped.reason}")
    print_files(files)
    if interrupted.has_come:
        more = shlex.join(place_texts(options))
        print(f"  continue with `seoro campaign resume {campaign.folder}{more and ' ' + more}`")
        return Exit.INTERRUPTED
    decided = status_of_test(campaign.state.watch, campaign.tally)
    return _status(campaign.tally) if decided is None else decided


def _print_note(text: str) -> None:
    print(f"note: {text}", file=sys.stderr, flush=True)


def _status(tally: Tally) -> Exit:
    if set(tally.ends) <= {End.PASSED}:
        return Exit.PASSED
    return Exit.FAILED if set(tally.ends) <= {End.PASSED, End.FAILED} else Exit.ERROR
