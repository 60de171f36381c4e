"""Functions of programs: start a campaign, continue it, or carry it out in a new event loop."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Unpack

from seoro.bundle.unpack import read_options
from seoro.campaign.asking import CampaignFields, Request, request_from
from seoro.campaign.opening import new_campaign, reopen, space_of
from seoro.campaign.places import Places, checked_places
from seoro.campaign.session import Campaign
from seoro.embed.arguments import AnyPath, optional, to_path, to_text, to_texts
from seoro.embed.scenarios import Scenario
from seoro.errors import UsageError


@asynccontextmanager
async def start(scenario: AnyPath | Scenario, **arguments: Unpack[CampaignFields]) -> AsyncIterator[Campaign]:
    """Start a campaign in the running event loop. When the block ends, its runs are stopped.

    Args:
        scenario: Scenario file, or result of `seoro.load`.
        arguments: Those of a campaign, and the options of `seoro.start` that all runs share, such as `seed` and
            `simulator`. The former are options of `seoro campaign run`: `strategy` (default: `Grid()`), `vary`,
            `runs`, `repeat`, `until`, `budget` [s], `overwrite`, `keep`, `film`, `parquet`, `isolation`, `jobs`,
            `on`, `executor`, `dask`. `folder` is the folder of the campaign (default: `campaign`).

    Raises:
        InvalidScenario, UsageError: The scenario or an argument is invalid, or the folder is taken; nothing was
            started.
        BackendError: No process can be started.
        OSError: The folder cannot be written.
    """
    async with start_with(request_from(scenario, arguments)) as campaign:
        yield campaign


@asynccontextmanager
async def start_with(request: Request) -> AsyncIterator[Campaign]:
    """Start a campaign with checked arguments; see `start`."""
    options = request.options
    places = checked_places(request.places, options)
    space = space_of(request.scenario, options, request.varied)
    folder = new_campaign(
        request.scenario, options, space, request.asked, request.folder, overwrite=request.overwrite
    )
    campaign = Campaign(folder, space, is_new=True)
    async with campaign.running(places):
        yield campaign


@asynccontextmanager
async def resume(
    folder: AnyPath,
    *,
    runs: int | None = None,
    jobs: int | None = None,
    on: Sequence[str] = (),
    executor: str | None = None,
    dask: str | None = None,
) -> AsyncIterator[Campaign]:
    """Continue a campaign that was stopped, or extend it. When the block ends, its runs are stopped.

    Args:
        folder: Its folder.
        runs: New number of runs; None to keep it.
        jobs, on, executor, dask: Places of the runs, as for `start`.

    Raises:
        UsageError: The folder is not that of a campaign, or its scenario has changed.
        BackendError: No process can be started, or an executor does not answer.
    """
    places = Places(
        jobs, to_texts("on", on), optional(to_text, "executor", executor), optional(to_text, "dask", dask)
    )
    campaign, places = reopened(to_path("folder", folder), runs, places)
    async with campaign.running(places):
        yield campaign


def reopened(folder: Path, runs: int | None, places: Places) -> tuple[Campaign, Places]:
    """Open a campaign to continue it; see `resume`.

    Returns:
        The campaign, and its checked places.
    """
    opened, scenario = reopen(folder, runs)
    manifest = opened.campaign.manifest
    try:
        options = read_options(manifest, Path(manifest.root or "."))
        return Campaign(opened, space_of(scenario, options)), checked_places(places, options)
    except BaseException:
        opened.close()
        raise


def run(scenario: AnyPath | Scenario, **arguments: Unpack[CampaignFields]) -> Campaign:
    """Carry out a campaign to its end in a new event loop, for scripts.

    Ctrl-C stops the active runs, then raises `KeyboardInterrupt`; `resume` continues the campaign.

    Args:
        scenario, arguments: As of `start`.

    Raises:
        InvalidScenario, UsageError, BackendError, OSError: As `start`; `UsageError` also in an event loop.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return asyncio.run(_run(request_from(scenario, arguments)))
    raise UsageError(
        "`seoro.campaign.run` cannot be called from a running event loop",
        help="use `async with seoro.campaign.start(...) as campaign: await campaign.wait()`",
    )


async def _run(request: Request) -> Campaign:
    async with start_with(request) as campaign:
        await campaign.wait()
    return campaign
