"""Filters of entities and named poses in requests."""

from __future__ import annotations

import re
from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.wire import Category, FilterMode, Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite
from sim_nodes.entities import Entities
from sim_nodes.physics import BodyState
from sim_nodes.worlds.schema import MAX_TAGS, TAG


def filter_entities(entities: Entities, request: wire.EntityFilter) -> dict[str, BodyState]:
    """Return the states of the entities that pass a filter, by name, sorted.

    Raises:
        RequestRefused: The filter is invalid.
    """
    check_categories(request.categories)
    check_tags_filter(request.tags)
    if request.bounds is not None:
        low, high = request.bounds.lower, request.bounds.upper
        check_finite("bounds", low.x, low.y, low.z, high.x, high.y, high.z)
    return {
        name: state
        for name in entities.matching(request.filter)
        for info, state in [(entities.info(name), entities.state(name))]
        if not request.categories or info.category in request.categories
        if has_tags(info.tags, request.tags)
        if request.bounds is None or _is_in(request.bounds, state)
    }


def has_tags(tags: Sequence[str], wanted: wire.TagsFilter) -> bool:
    """Whether an object with some tags passes a filter."""
    if not wanted.tags:
        return True
    found = (tag in tags for tag in wanted.tags)
    return all(found) if wanted.filter_mode == FilterMode.ALL else any(found)


def _is_in(bounds: wire.Bounds, state: BodyState) -> bool:
    low, high = bounds.lower, bounds.upper
    x, y, z = state.position
    return low.x <= x <= high.x and low.y <= y <= high.y and low.z <= z <= high.z


def check_categories(categories: Sequence[int]) -> None:
    """Refuse unknown categories."""
    unknown = [number for number in categories if number not in list(Category)]
    if unknown:
        known = ", ".join(f"{each.value} ({each.name.lower()})" for each in Category)
        raise RequestRefused(Result.OPERATION_FAILED, f"unknown category {unknown[0]}; categories: {known}")


def check_tags(tags: Sequence[str]) -> None:
    """Refuse invalid tags."""
    if len(tags) > MAX_TAGS:
        raise RequestRefused(Result.OPERATION_FAILED, f"found {len(tags)} tags; expected at most {MAX_TAGS}")
    wrong = [tag for tag in tags if not re.fullmatch(TAG, tag)]
    if wrong:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid tag {wrong[0]!r}; expected 1 to 64 characters without spaces and commas",
        )


def check_tags_filter(wanted: wire.TagsFilter) -> None:
    """Refuse filters with an invalid tag or an unknown mode."""
    check_tags(wanted.tags)
    if wanted.filter_mode not in list(FilterMode):
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"unknown filter mode {wanted.filter_mode}; expected 0 (any of the tags) or 1 (all of them)",
        )
