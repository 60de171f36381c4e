"""What entities and named poses are chosen by: names, categories, tags and places."""

from __future__ import annotations

from enum import IntEnum

from seoro.bridges.wire.geometry import Vector3
from seoro.bridges.wire.message import Message


class Category(IntEnum):
    """Categories of entities, by the numbers of `simulation_interfaces`."""

    OBJECT = 0
    ROBOT = 1
    HUMAN = 2
    DYNAMIC_OBJECT = 4
    STATIC_OBJECT = 5


class Bounds(Message):
    """A box along the axes of a frame, by two of its corners [m]."""

    lower: Vector3
    upper: Vector3


class FilterMode(IntEnum):
    """How many of the tags something has to have, by the numbers of `simulation_interfaces`."""

    ANY = 0
    ALL = 1


class TagsFilter(Message):
    """What has any or all of some tags; everything, if there are none."""

    tags: tuple[str, ...] = ()
    filter_mode: int = FilterMode.ANY


class EntityFilter(Message):
    """Which entities: those that all of this holds for.

    Args:
        filter: A regular expression that their whole names match; all names do, if it is empty.
        categories: They are of one of these; of any, if there are none.
        bounds: Their origins are in it, in the frame `map`.
        tags: They have these.
    """

    filter: str = ""
    categories: tuple[int, ...] = ()
    bounds: Bounds | None = None
    tags: TagsFilter = TagsFilter()
