"""Options of runs as words of the command line of `seoro exec`."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path

from seoro.bundle.unpack import read_options
from seoro.campaign.runs import Planned
from seoro.campaign.store.folder import CampaignFile
from seoro.embed.options import ROS_SIMULATOR, Options, Simulator
from seoro.embed.world_settings import constraints_of_scenario


def words_of_run(campaign: CampaignFile, planned: Planned) -> list[str]:
    """Return the scenario file and all options of a run of a campaign.

    Args:
        campaign: Content of its `campaign.json`.
        planned: The run.

    Raises:
        UsageError: The options of the campaign contradict each other.
    """
    manifest = campaign.manifest
    options = read_options(manifest, Path(manifest.root or "."))
    words = [manifest.shown, *words_beyond_directives(options)]
    simulator = options.simulator
    if simulator is not None and simulator.name not in (None, ROS_SIMULATOR):
        words += ["--sim", str(simulator.name)]
    if simulator is not None and simulator.world is not None and simulator.name != ROS_SIMULATOR:
        words += ["--world", simulator.world]
    if options.parameters is not None:
        words += ["--params", os.fspath(options.parameters)]
    for path, value in {**options.overrides, **planned.values}.items():
        words += ["--set", f"{path}={value}"]
    for constraint in constraints_of_scenario(options.constraints):
        words += ["--constrain", constraint]
    if manifest.options.timeout is not None and not manifest.options.timeout_of_file:
        words += ["--timeout", f"{manifest.options.timeout:g}"]
    return [*words, "--seed", str(planned.seed)]


def words_beyond_directives(options: Options) -> list[str]:
    """Return the options that directives of a scenario file do not have.

    Args:
        options: Options that all runs share.
    """
    words = [] if options.name is None else ["--scenario", options.name]
    words += [] if options.clock is None else ["--clock", options.clock]
    words += [] if options.poses is None else ["--poses", f"{options.poses:g}"]
    words += ["--scans", f"{options.scans:g}"] if options.scans else []
    words += [] if options.lab is None else [*_lab_words(options)]
    if options.ros is not None:
        dialect = "" if options.ros.dialect is None else f"&dialect={options.ros.dialect}"
        words += ["--ros", f"{options.ros.endpoint}?domain={options.ros.domain}{dialect}"]
        for folder in options.ros.interfaces:
            words += ["--ros-interfaces", os.fspath(folder)]
        words += [] if options.ros.state else ["--no-ros-state"]
    return words if options.simulator is None else [*words, *_simulator_words(options.simulator)]


def _lab_words(options: Options) -> Iterator[str]:
    assert options.lab is not None, "checked by the caller"
    yield from ("--lab", os.fspath(options.lab.file))
    yield from _rate_words(options.lab.rate)
    for folder in options.lab.model_path:
        yield from ("--model-path", os.fspath(folder))


def _simulator_words(simulator: Simulator) -> Iterator[str]:
    if simulator.endpoint is not None:
        yield from ("--connect", simulator.endpoint)
    if simulator.name == ROS_SIMULATOR:
        yield from ("--sim", ROS_SIMULATOR, *([] if simulator.world is None else ["--world", simulator.world]))
    if simulator.snapshot is not None:
        yield from ("--from-snapshot", os.fspath(simulator.snapshot))
    for folder in simulator.model_path:
        yield from ("--model-path", os.fspath(folder))
    yield from _rate_words(simulator.rate)


def _rate_words(rate: float | None) -> Iterator[str]:
    if rate not in (None, 1.0):
        yield from ("--rate", "max" if rate == math.inf else f"{rate!r}")
