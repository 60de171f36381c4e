"""Arguments of programs that start a campaign, checked at the call."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, cast, get_args

from seoro.campaign.opening import Asked, listed_seeds
from seoro.campaign.places import Places
from seoro.campaign.store.folder import Isolation, Keep
from seoro.campaign.strategies.choice import STRATEGIES
from seoro.campaign.strategies.contract import Strategy
from seoro.campaign.strategies.grid import Grid
from seoro.embed import SEED_BITS
from seoro.embed.arguments import (
    AnyPath,
    instance_of,
    number_with,
    to_flag,
    to_limit,
    to_path,
    to_text,
    to_texts,
    to_whole,
    wrong_type,
)
from seoro.embed.file_settings import with_file_settings
from seoro.embed.options import OptionFields, Options, options_from
from seoro.embed.scenarios import Scenario, load, to_scenario
from seoro.embed.video import VideoOptions
from seoro.errors import UsageError
from seoro.lang.frozen import Value

FOLDER: Final = Path("campaign")
_OF_ONE_RUN: Final = (
    "observers", "output_directory", "keep_trace", "external", "replay", "vet", "load", "locate",
)  # fmt: skip # what runs in other processes cannot use


class CampaignFields(OptionFields, total=False):
    """Arguments of `seoro.campaign.start`: its own, and those of `seoro.start` that all runs share."""

    strategy: Strategy
    vary: Sequence[str]
    folder: AnyPath
    overwrite: bool
    runs: int | None
    repeat: int
    until: Sequence[str]
    budget: float | None
    keep: Keep
    film: VideoOptions | None
    parquet: bool
    isolation: Isolation | None
    jobs: int | None
    on: Sequence[str]
    executor: str | None
    dask: str | None


class Request(Value):
    """Checked arguments.

    Args:
        scenario: The loaded scenario.
        options: Options that all runs share.
        varied: Constraints among them that make a parameter vary.
        asked: Request for the campaign.
        folder: Its folder.
        overwrite: Whether to replace another campaign there.
        places: Places of the runs.
    """

    scenario: Scenario
    options: Options
    varied: tuple[str, ...]
    asked: Asked
    folder: Path
    overwrite: bool
    places: Places


def request_from(scenario: AnyPath | Scenario, fields: CampaignFields) -> Request:
    """Check the arguments of a program.

    Args:
        scenario: Result of `seoro.load`, or the path of a scenario file.
        fields: The arguments.

    Raises:
        InvalidScenario, UsageError: The scenario is invalid, or an argument is unknown or of a wrong type.
    """
    loaded = to_scenario("scenario", scenario) if isinstance(scenario, Scenario) else load(scenario)
    own: dict[str, Any] = {
        name: None if value is None and name in _OPTIONAL else _CONVERSIONS[name](name, value)
        for name, value in fields.items()
        if name in _CONVERSIONS
    }
    shared = {name: value for name, value in fields.items() if name not in _CONVERSIONS}
    for name in _OF_ONE_RUN:
        if name in shared:
            raise UsageError(
                f"a campaign has no option `{name}`, since its runs are in other processes",
                help="read the rows of its runs, or start a single run with `seoro.start`",
            )
    options, found = with_file_settings(loaded, options_from(cast(OptionFields, shared)), "timeout=SECONDS")
    folder, overwrite = own.pop("folder", FOLDER), own.pop("overwrite", False)
    places = Places(**{name: own.pop(name) for name in ("jobs", "on", "executor", "dask") if name in own})
    varied = own.pop("vary", ())
    options = replace(options, constraints=(*options.constraints, *varied))
    seed = options.seed if options.seed is not None else secrets.randbits(SEED_BITS)
    asked = Asked(**{"strategy": Grid(), **own, "seed": seed, "limit": found.limit})
    seeds = listed_seeds(asked.strategy, asked.repeat, found.seeds)
    asked = replace(asked, seeds=seeds, repeat=len(seeds) or asked.repeat)
    return Request(loaded, options, varied, asked, folder, overwrite, places)


def _to_strategy(name: str, value: object) -> Strategy:
    if type(value) not in STRATEGIES.values():
        names = ", ".join(kind.__name__ for kind in STRATEGIES.values())
        raise wrong_type(name, value, "a strategy, such as seoro.campaign.Sobol()", f"strategies: {names}")
    return cast(Strategy, value)


_at_least_one = number_with(lambda number: number >= 1.0, "at least 1")


def _to_count(name: str, value: object) -> int:
    return int(_at_least_one(name, to_whole(name, value)))


def _one_of(choices: Sequence[str]) -> Callable[[str, object], object]:
    def check(name: str, value: object) -> object:
        if value not in choices:
            raise wrong_type(name, value, " or ".join(f'"{each}"' for each in choices))
        return value

    return check


_OPTIONAL: Final = frozenset({"runs", "budget", "jobs", "film", "isolation", "executor", "dask"})
_CONVERSIONS: Final[Mapping[str, Callable[[str, object], Any]]] = {
    "strategy": _to_strategy,
    "vary": to_texts,
    "folder": to_path,
    "overwrite": to_flag,
    "runs": _to_count,
    "repeat": _to_count,
    "until": to_texts,
    "budget": to_limit,
    "keep": _one_of(get_args(Keep)),
    "film": instance_of(VideoOptions, "seoro.embed.video.VideoOptions()"),
    "parquet": to_flag,
    "isolation": _one_of(get_args(Isolation)),
    "jobs": _to_count,
    "on": to_texts,
    "executor": to_text,
    "dask": to_text,
}
