"""Differences between the settings of two campaigns."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from seoro.campaign.store.folder import CampaignFile
from seoro.lang.frozen import Value

_NONE: Final = "none"


class Difference(Value):
    """Setting that differs.

    Args:
        name: Its name.
        before: Value of the first campaign.
        after: Value of the second one.
    """

    name: str
    before: str
    after: str


def differences(before: CampaignFile, after: CampaignFile) -> tuple[Difference, ...]:
    """Return the settings that differ between two campaigns.

    Args:
        before, after: Content of their `campaign.json`.
    """
    first, second = dict(_settings(before)), dict(_settings(after))
    found = [
        Difference(name, first.get(name, _NONE), second.get(name, _NONE))
        for name in dict.fromkeys([*first, *second])
        if first.get(name) != second.get(name)
    ]
    return (*found, *_files(before, after))


def _settings(campaign: CampaignFile) -> Iterator[tuple[str, str]]:
    strategy = ", ".join(f"{name} {value}" for name, value in campaign.strategy.options.items())
    yield "strategy", f"{campaign.strategy.name} ({strategy})" if strategy else campaign.strategy.name
    yield "seed", str(campaign.seed)
    yield "repeats", str(campaign.repeat)
    yield "stopping rules", ", ".join(campaign.until) or _NONE
    yield "seoro", campaign.version
    options = campaign.manifest.options.model_dump(mode="json", exclude={"seed", "simulator", "film"})
    for name, value in options.items():
        if value not in (None, [], {}, ()):
            yield name.replace("_", " "), _text(value)
    simulator = campaign.manifest.options.simulator
    yield "simulator", campaign.simulator or _NONE
    if simulator is not None:
        yield "world", simulator.world_file or simulator.world or "that of the simulator"
        yield "world parameters", simulator.world_parameters or _NONE
        yield "snapshot", simulator.snapshot or _NONE


def _text(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name}={_text(each)}" for name, each in value.items())
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def _files(before: CampaignFile, after: CampaignFile) -> Iterator[Difference]:
    first, second = ({file.path: file.hash[:8] for file in each.manifest.files} for each in (before, after))
    for path in sorted({*first, *second}):
        if first.get(path) != second.get(path):
            yield Difference(path, first.get(path, "missing"), second.get(path, "missing"))
