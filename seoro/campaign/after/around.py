"""Campaigns around one run of another campaign, in a folder below it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from seoro.bundle.unpack import read_options
from seoro.campaign.after.finding import FoundRun
from seoro.campaign.after.same_failure import SameFailure, values_of_run
from seoro.campaign.jobs import shared_place
from seoro.campaign.opening import check_unchanged, space_of
from seoro.campaign.space.space import Space
from seoro.campaign.store.folder import (
    CAMPAIGN,
    CampaignFile,
    CampaignFolder,
    StrategyText,
    create_folder,
    read_campaign,
    write_campaign,
)
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario, load
from seoro.lang.frozen import Value

ON_ROBOTS: Final = 3  # runs of the same values, where they may end differently


class Start(Value):
    """Failed run, with all that other runs around it need.

    Args:
        found: The run.
        scenario: The loaded scenario.
        options: Options that all runs share.
        space: Axes of the campaign.
        values: Values of the axes in the run, as far as known.
    """

    found: FoundRun
    scenario: Scenario
    options: Options
    space: Space
    values: dict[str, str]

    def failure(self, *, any_failure: bool) -> SameFailure:
        """Return the failure of the run, or any."""
        return SameFailure(self.found.row.reason_key, self.found.row.where, any_failure)


def start_at(found: FoundRun) -> Start:
    """Load what runs around a run need.

    Raises:
        InvalidScenario, UsageError: Files of the scenario, or the version of seoro, have changed.
    """
    check_unchanged(
        found.campaign, f"run {found.row.run} of {found.folder} cannot be repeated", "start another campaign"
    )
    manifest = found.campaign.manifest
    root = Path(manifest.root or ".")
    scenario, options = load(root / manifest.entry), read_options(manifest, root)
    space = space_of(scenario, options)
    return Start(found, scenario, options, space, values_of_run(found, space))


def repeats_for(options: Options, wanted: int | None) -> int:
    """Return the number of runs of the same values: one where runs repeat to the bit.

    Args:
        options: Options that all runs share.
        wanted: Number that the user gives, if any.
    """
    if wanted is not None:
        return wanted
    has_simulator = options.simulator is not None or (options.lab is not None and shared_place(options) is None)
    is_real = options.clock == "real" or (options.clock is None and not has_simulator)
    return ON_ROBOTS if is_real or options.ros is not None else 1


def open_around(start: Start, part: str, strategy: StrategyText, runs: int | None, repeat: int) -> CampaignFolder:
    """Open the folder of a campaign around a run; an earlier one with the same strategy is continued.

    Args:
        start: The run.
        part: Name of the folder below that of the campaign.
        strategy: Strategy, for `campaign.json`.
        runs: Maximum number of runs; None without a limit.
        repeat: Runs of the same values, all with the seed of the run.

    Raises:
        UsageError: Another process uses the folder.
        OSError: The folder cannot be written.
    """
    before, planned = start.found.campaign, start.found.planned
    options = before.manifest.options.model_copy(update={"film": None})
    campaign = before.model_copy(
        update={
            "manifest": before.manifest.model_copy(update={"options": options}),
            "strategy": strategy,
            "runs": runs,
            "repeat": repeat,
            "seed": planned.seed,
            "seeds": (planned.seed,) * repeat,
            "keep": "none",
            "until": (),
            "budget": None,
            "is_sample": False,
            "is_extended": False,
        }
    )
    folder = start.found.folder / part / f"{planned.number:06}"
    if not _is_same(folder, campaign):
        return create_folder(folder, campaign, overwrite=True)
    opened = CampaignFolder(folder, campaign)
    write_campaign(folder, campaign)  # the number of runs may be another
    return opened


def _is_same(folder: Path, campaign: CampaignFile) -> bool:
    if not (folder / CAMPAIGN).exists():
        return False
    return read_campaign(folder).model_copy(update={"runs": campaign.runs}) == campaign
