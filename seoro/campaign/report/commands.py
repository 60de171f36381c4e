"""Commands that repeat runs of a campaign."""

from __future__ import annotations

import shlex

from seoro.campaign.runs import Planned
from seoro.campaign.store.folder import CampaignFile


def command_of(campaign: CampaignFile, planned: Planned) -> str:
    """Return the command that makes a run of a campaign again.

    Args:
        campaign: Content of its `campaign.json`.
        planned: The run, with values in the notation of the scenario.
    """
    options = campaign.manifest.options
    words = ["seoro", "exec", campaign.manifest.shown]
    if options.name is not None:
        words += ["--scenario", options.name]
    if options.parameters is not None:
        words += ["--params", options.parameters]
    for path, value in {**options.overrides, **planned.values}.items():
        words += ["--set", f"{path}={value}"]
    for constraint in options.constraints:
        words += ["--constrain", constraint]
    words += ["--seed", str(planned.seed)]
    if options.clock is not None:
        words += ["--clock", options.clock]
    if options.lab is not None:
        words += ["--lab", options.lab.file]
    if options.ros is not None:
        words += ["--ros", options.ros.endpoint]
    return shlex.join([*words, *_simulator_words(campaign)])


def _simulator_words(campaign: CampaignFile) -> list[str]:
    simulator = campaign.manifest.options.simulator
    if simulator is None:
        return []
    given = {
        "--sim": simulator.name,
        "--connect": simulator.endpoint,
        "--world": simulator.world_file or simulator.world,
        "--from-snapshot": simulator.snapshot,
    }
    words = [word for option, value in given.items() if value is not None for word in (option, value)]
    rate = "max" if simulator.rate == float("inf") else f"{simulator.rate:g}"
    return [*words, *([] if rate == "1" else ["--rate", rate])]
