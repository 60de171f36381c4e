"""Strategies, budgets and templates of searches in RoboVAST files."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Any, Final

from seoro.campaign.strategies.choice import STRATEGIES
from seoro.campaign.vast.notes import Note
from seoro.campaign.vast.schema import FloatDimension, IntDimension, Objective, Search

BUILT_IN: Final = "failure_rate"  # objective of which each run has a sample: its verdict
_MARK: Final = re.compile(r"\$(?:\{(\w+)\}|(\w+))")


def without_template(search: Search) -> list[str]:
    """Return the dimensions that are parameters of the scenario, since no template refers to them."""
    named = set(_marks([search.variations, search.parameters]))
    return [name for name in search.search_space if name not in named]


def _marks(node: Any) -> Iterator[str]:
    if isinstance(node, dict | list):
        for each in node.values() if isinstance(node, dict) else node:
            yield from _marks(each)
    elif isinstance(node, str) and (found := _MARK.fullmatch(node)):
        yield found[1] or found[2]


def missing_parameters(search: Search, names: Collection[str], stem: str, notes: list[Note]) -> list[str]:
    """Return parameters that templates compute, and note them."""
    found = sorted(names)
    for index, entry in enumerate(search.variations):
        kind = entry if isinstance(entry, str) else next(iter(entry))
        used = sorted(set(_marks(entry)))
        formula = " and ".join(f"`keep({name} == ...)`" for name in found) or "its values"
        notes.append(
            Note(
                ("search", "variations", index),
                str(kind),
                f"it computes parameters from {', '.join(f'`{name}`' for name in used) or 'nothing'} with Python",
                f"write {formula} in {stem}.osc",
            )
        )
    return found


def search_strategy(search: Search, repeat: int, notes: list[Note]) -> dict[str, Any]:
    """Return the strategy of a search with its options."""
    sampler = str(search.strategy_parameters.get("sampler", "tpe"))
    wanted = {"random": "random", "optuna": sampler, "qd": "map-elites"}.get(search.strategy, "search")
    name = wanted if wanted in STRATEGIES else "search"
    if name != wanted or search.strategy not in ("random", "optuna", "qd"):
        why = f"campaigns have no strategy `{search.strategy}`"
        notes.append(
            Note(("search", "strategy"), search.strategy, why, f"choose another than `{name}` in the file")
        )
    batches = next((each.batches for each in search.budget if each.batches is not None), None)
    runs = None if batches is None else batches * search.per_batch * repeat
    keys: dict[str, Any] = {name: runs}
    if name != "random" and search.objectives[0].name != BUILT_IN:
        keys[search.objectives[0].direction] = f"record.{search.objectives[0].name}"
    return keys if repeat == 1 else keys | {"repeat": repeat}


def search_notes(search: Search) -> Iterator[Note]:
    """Yield notes about parts of a search."""
    for name, dimension in search.search_space.items():
        if isinstance(dimension, FloatDimension | IntDimension) and dimension.log:
            why = "ranges vary on a linear scale"
            advice = "vary the exponent, and compute the parameter from it in the scenario"
            yield Note(("search", "search_space", name, "log"), f"log of `{name}`", why, advice)
    if search.extract.plugin not in ("", BUILT_IN):
        why, advice = "Python does not read results", "record what the search needs in the scenario, `record(...)`"
        yield Note(("search", "extract"), f"extract `{search.extract.plugin}`", why, advice)
    for index, objective in enumerate(search.objectives):
        yield from _objective_notes(search, objective, index)
    for index, entry in enumerate(search.stopping):
        kind = next(iter(entry), "")
        advice = {
            "target_objective": "end at failures: `until: 10 failures`",
            "metric": "declare buckets with `cover` in the scenario, and write `until: coverage 30%`",
        }.get(kind, "limit the runs or the time")
        yield Note(
            ("search", "stopping", index), f"stopping.{kind}", "campaigns have other stopping rules", advice
        )
    for name in search.strategy_parameters:
        if name != "sampler":
            why = "it configures an optimiser of RoboVAST"
            advice = "declare buckets with `cover` in the scenario" if name == "archive" else "leave it out"
            yield Note(("search", "strategy_parameters", name), f"strategy_parameters.{name}", why, advice)


def _objective_notes(search: Search, objective: Objective, index: int) -> Iterator[Note]:
    place = ("search", "objectives", index)
    if index > 0:
        yield Note(
            place, f"objective `{objective.name}`", "a campaign has one objective", "combine them in one `record`"
        )
    elif objective.name != BUILT_IN:
        why = "Python does not extract it from results"
        advice = f"record it in the scenario: `record({objective.name}, expression: ...)`"
        yield Note(place, f"objective `{objective.name}`", why, advice)
    elif search.strategy != "random":
        why = "a verdict has no distance to a failure"
        advice = "compare or record a distance to the limit in the scenario, and write `minimize: record.NAME`"
        yield Note(place, "objective `failure_rate`", why, advice)
