"""Shared data of all runs of a campaign, loaded once per process: the scenario and the options."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from seoro.bridges.executor.messages import BundledFilm
from seoro.bundle.unpack import limit_of, read_options
from seoro.campaign.store.folder import CampaignFile, Keep
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario, check_file
from seoro.embed.time_limit import WallLimit
from seoro.embed.world_settings import constraints_of_scenario
from seoro.lang.frozen import Value


class Job(Value):
    """Shared data of all runs of a campaign.

    Args:
        digest: Digest of the campaign.
        version: Version of seoro.
        keep: Runs that keep their trace and files.
        folder: Folder for them.
        scenario: The loaded scenario.
        options: Options of its runs; each has its own seed and overrides.
        limit: Limit of the wall time of a run.
        film: Video of each run; None without one.
        parquet: Whether trajectories of kept runs are also written as Parquet.
    """

    digest: str
    version: str
    keep: Keep
    folder: Path
    scenario: Scenario
    options: Options
    limit: WallLimit
    film: BundledFilm | None = None
    parquet: bool = False


def load_job(campaign: CampaignFile, folder: Path) -> Job:
    """Load the scenario of a campaign where it is, with its files.

    Args:
        campaign: Content of `campaign.json`.
        folder: Folder of the campaign.

    Raises:
        InvalidScenario, UsageError: The scenario cannot be loaded, or the options contradict each other.
    """
    manifest = campaign.manifest
    root = Path(manifest.root or ".")
    scenario = check_file(root / manifest.entry, name=manifest.shown).without_errors()
    options = read_options(manifest, root)
    return Job(
        digest=campaign.digest,
        version=campaign.version,
        keep=campaign.keep,
        folder=folder,
        scenario=scenario,
        options=replace(options, constraints=constraints_of_scenario(options.constraints)),
        limit=limit_of(manifest.options),
        film=manifest.options.film,
        parquet=campaign.parquet,
    )
