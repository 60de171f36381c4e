"""Start and continuation of campaigns: their folder, strategy, planner and engine."""

from __future__ import annotations

import hashlib
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final

from seoro import __version__
from seoro.bindings.own_python import own_python
from seoro.bundle.pack import pack
from seoro.campaign.coordinator import Coordinator
from seoro.campaign.coverage.drawing import InputSpace
from seoro.campaign.coverage.items import covered_items
from seoro.campaign.identity import digest_of
from seoro.campaign.places import Places, open_engines
from seoro.campaign.planner import Planner
from seoro.campaign.runs import Row
from seoro.campaign.space.defaults import find_defaults
from seoro.campaign.space.feasible import Feasibility
from seoro.campaign.space.finding import check_varied, find_axes
from seoro.campaign.space.space import Space
from seoro.campaign.space.world_axes import check_world_axes, world_axis
from seoro.campaign.stopping.grammar import parse_rule
from seoro.campaign.stopping.rules import CoverageGoal
from seoro.campaign.store.folder import (
    CampaignFile,
    CampaignFolder,
    Isolation,
    Keep,
    create_folder,
    read_campaign,
    write_campaign,
)
from seoro.campaign.strategies.choice import text_of
from seoro.campaign.strategies.contract import Sampling, Strategy
from seoro.embed.directives import requirements_of
from seoro.embed.option_checks import check_options
from seoro.embed.options import Options
from seoro.embed.parameter_files import read_parameters
from seoro.embed.scenarios import Scenario, load
from seoro.embed.time_limit import PROGRAM_LIMIT, WallLimit
from seoro.embed.video import VideoOptions
from seoro.embed.world_settings import constraints_of_scenario, split_world
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.lab.selectors import split_selectors
from seoro.lang.frontend import lower
from seoro.lang.frozen import Value

_BLOCK: Final = 1 << 20  # [bytes]


class Asked(Value):
    """Request for a campaign.

    Args:
        strategy: Chooses the values.
        seed: Seed of the strategy and of the first repeat of each point.
        runs: Number of runs; None for all of the strategy.
        repeat: Runs of each point.
        keep: Runs that keep their trace and files.
        isolation: Isolation of runs from each other; None for `run` if the scenario has Python of its own, else
            `worker`.
        limit: Limit of the wall time of a run.
        until: Stopping rules, see `seoro.campaign.stopping.grammar`.
        budget: Wall time of a session, after which no run begins [s].
        seeds: Seeds of the repeats of each point, which all points share; empty for consecutive ones.
        film: Video of each run; it is kept with the run.
        parquet: Whether to write trajectories of kept runs as Parquet, too.
    """

    strategy: Strategy
    seed: int
    runs: int | None = None
    repeat: int = 1
    keep: Keep = "failed"
    isolation: Isolation | None = None
    limit: WallLimit = PROGRAM_LIMIT
    until: tuple[str, ...] = ()
    budget: float | None = None
    seeds: tuple[int, ...] = ()
    film: VideoOptions | None = None
    parquet: bool = False


def listed_seeds(strategy: Strategy, repeat: int, seeds: Sequence[int]) -> tuple[int, ...]:
    """Return the seeds of each point that a scenario file lists.

    Args:
        strategy: Strategy of the campaign.
        repeat: Runs of each point that the user wants.
        seeds: Seeds in the file.

    Returns:
        The seeds; empty for fewer than two, for other repeats, and if the strategy gives each point a seed.
    """
    is_used = len(seeds) > 1 and repeat == 1 and strategy.sampling is Sampling.NONE
    return tuple(seeds) if is_used else ()


def space_of(scenario: Scenario, options: Options, varied: Sequence[str] = ()) -> Space:
    """Find what varies in a scenario, apart from parameters that the options set.

    Args:
        scenario: Result of `load`.
        options: Options that all runs share.
        varied: Constraints among them that must make a parameter vary.

    Raises:
        InvalidScenario, UsageError: The scenario is unknown, or an option is invalid.
    """
    check_options(options)
    check_varied(varied)
    entry = scenario.entry(options.name).name
    given, of_world = split_world(split_selectors(options.overrides)[0])  # robots do not vary
    if options.parameters is not None:
        given = {**read_parameters(options.parameters, entry), **given}
    constraints = constraints_of_scenario(options.constraints)
    worlds = [world_axis(text) for text in options.constraints if text not in constraints]
    worlds = [axis for axis in worlds if axis.path not in of_world]
    if worlds and (options.simulator is None or options.simulator.world is None):
        raise UsageError(
            f"`{worlds[0].path}` needs the name or the file of a world", help="add `--sim mujoco --world office`"
        )
    plan = lower(scenario.checked, options.name, given, constraints)
    axes = (*find_axes(plan, given, constraints_of_scenario(varied)), *worlds)
    feasibility = Feasibility(scenario, options.name, given, constraints)
    inputs = InputSpace(scenario, options.name, given, constraints, axes, plan)
    return Space(axes, find_defaults(plan, axes), feasibility, inputs, covered_items(plan))


def new_campaign(
    scenario: Scenario, options: Options, space: Space, asked: Asked, folder: Path, *, overwrite: bool = False
) -> CampaignFolder:
    """Create the folder of a campaign.

    Args:
        scenario: Result of `load`.
        options: Options that all runs share.
        space: Result of `space_of`.
        asked: The request.
        folder: Its folder.
        overwrite: Whether to replace another campaign there.

    Raises:
        InvalidScenario, UsageError: The scenario or the options are invalid, or the folder is taken.
        OSError: The folder cannot be written.
    """
    if asked.runs is None and asked.repeat == 1 and not space.axes:
        raise UsageError(
            f"no parameter varies in `{scenario.entry(options.name).name}`",
            help="list values in the scenario, `keep(noise in [0.0, 0.1])`, or repeat it with `--repeat 10`",
        )
    if asked.strategy.is_endless and asked.runs is None and not asked.until and asked.budget is None:
        raise UsageError(
            f"the strategy `{asked.strategy.name}` has no last run",
            help="add `--runs 200`, `--until 'first failure'` or `--budget 1h`",
        )
    asked.strategy.batches(space, asked.seed)  # refuses axes that it cannot use
    is_sample = not space.axes or (asked.strategy.sampling is Sampling.INDEPENDENT and asked.repeat == 1)
    _check_rules(asked, space, is_sample)
    check_world_axes(space.axes, options)
    manifest = pack(scenario, options, asked.limit, film=asked.film).manifest
    simulator = manifest.options.simulator
    named = "" if simulator is None else simulator.name or simulator.endpoint or ""
    campaign = CampaignFile(
        manifest=manifest,
        strategy=text_of(asked.strategy),
        runs=asked.runs,
        repeat=asked.repeat,
        seed=asked.seed,
        keep=asked.keep,
        isolation=asked.isolation or _isolation_for(scenario),
        digest=digest_of(manifest, named, __version__),
        simulator=named,
        version=__version__,
        until=asked.until,
        budget=asked.budget,
        requirements=requirements_of(scenario, options.name),
        seeds=asked.seeds,
        parquet=asked.parquet,
        items=space.items,
        is_sample=is_sample,
    )
    return create_folder(folder, campaign, overwrite=overwrite)


def _isolation_for(scenario: Scenario) -> Isolation:
    """Return the weakest isolation with which runs cannot affect each other."""
    return "run" if any(own_python(scenario.checked.sources)) else "worker"


def _check_rules(asked: Asked, space: Space, is_sample: bool) -> None:
    for text in asked.until:
        rule = parse_rule(text)
        if isinstance(rule, CoverageGoal) and not any(item.buckets for item in space.items):
            raise UsageError(
                f"the stopping rule `{text}` needs a `cover` item with a limited number of buckets",
                help="add `cover(pace, unit: mps, range: [0..5], every: 1)` to the scenario",
            )
        if rule.needs_samples and not is_sample:
            reason = f"repeats with `--repeat {asked.repeat}` share values"
            if asked.strategy.sampling is not Sampling.INDEPENDENT:
                reason = f"the strategy `{asked.strategy.name}` does not draw its values independently"
            raise UsageError(
                f"the stopping rule `{text}` needs runs that are independent of each other: {reason}",
                help="use `--strategy random` without `--repeat`",
            )


def reopen(folder: Path, runs: int | None = None) -> tuple[CampaignFolder, Scenario]:
    """Open the folder of a campaign to continue it.

    Args:
        folder: Its folder.
        runs: New number of runs; None to keep it.

    Returns:
        The folder, and the loaded scenario.

    Raises:
        UsageError: The folder is not that of a campaign, or files of the scenario have changed.
    """
    campaign = read_campaign(folder)
    check_unchanged(campaign, f"{folder} cannot be continued", "start another campaign in another folder")
    opened = CampaignFolder(folder, campaign)
    if runs is not None:
        opened.campaign = campaign.model_copy(update={"runs": runs, "is_extended": True})
        write_campaign(folder, opened.campaign)
    return opened, load(Path(campaign.manifest.root or ".") / campaign.manifest.entry)


def check_unchanged(campaign: CampaignFile, refusal: str, instead: str) -> None:
    """Check that a campaign can have more runs, or the same ones again.

    Args:
        campaign: Content of its `campaign.json`.
        refusal: Beginning of the error, such as `out/ cannot be continued`.
        instead: Another way for the user, such as `start another campaign`.

    Raises:
        UsageError: Files of the scenario have changed, or this is another version of seoro.
    """
    root = Path(campaign.manifest.root or ".")
    changed = [file.path for file in campaign.manifest.files if _hash(root / file.path) != file.hash]
    if changed:
        raise UsageError(
            f"{refusal}: {', '.join(changed)} changed since it began", help=f"restore the file, or {instead}"
        )
    if campaign.version != __version__:
        raise UsageError(
            f"{refusal}: it began with seoro {campaign.version}, this is {__version__}",
            help=f"go on with seoro {campaign.version}, or {instead}",
        )


@asynccontextmanager
async def open_campaign(
    folder: CampaignFolder,
    planner: Planner,
    places: Places,
    on_row: Callable[[Row], object],
    is_enough: Callable[[], bool] = lambda: False,
    note: Callable[[str], object] = lambda text: None,
) -> AsyncIterator[Coordinator]:
    """Open the engines of a campaign while the block lasts.

    Args:
        folder: Its folder.
        planner: Plans its runs.
        places: Places of its runs.
        on_row: Called with each row.
        is_enough: Called after each row; returns whether no more runs shall begin.
        note: Called with news about the places, for people.

    Raises:
        UsageError: A place cannot carry out the campaign.
        BackendError: No process can be started.
    """
    async with open_engines(folder, places, note) as engine:
        yield Coordinator(folder, planner, engine, on_row, is_enough)


def _hash(path: Path) -> str:
    try:
        with open_input(path, Kind.BUNDLED) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
