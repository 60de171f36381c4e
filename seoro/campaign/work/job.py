"""Shared data of all runs of a campaign, loaded once per process: the scenario and the options."""

from __future__ import annotations

from pathlib import Path

from seoro.bundle.unpack import limit_of, read_options
from seoro.campaign.store.folder import CampaignFile
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario, check_file
from seoro.embed.time_limit import WallLimit
from seoro.lang.frozen import Value


class Job(Value):
    """Shared data of all runs of a campaign.

    Args:
        campaign: Content of `campaign.json`.
        folder: Folder of the campaign.
        scenario: The loaded scenario.
        options: Options of its runs; each has its own seed and overrides.
        limit: Limit of the wall time of a run.
    """

    campaign: CampaignFile
    folder: Path
    scenario: Scenario
    options: Options
    limit: WallLimit


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
    return Job(campaign, folder, scenario, read_options(manifest, root), limit_of(manifest.options))
