"""Options of `seoro campaign run` that list its runs instead of running them."""

from __future__ import annotations

from itertools import islice
from math import ceil
from typing import Final

from seoro.campaign.listing import possible_points
from seoro.campaign.opening import Asked
from seoro.campaign.runs import title_of
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.cli.arguments import Container, add_option

LISTED: Final = 100  # variants, without `--runs`


def add_listing(parser: Container) -> None:
    """Declare the options."""
    add_option(parser, "--list", f"list the first {LISTED} variants, or as many as `--runs`, without running them")


def list_variants(space: Space, asked: Asked) -> None:
    """Print what varies, and the values of the first variants.

    Raises:
        UsageError: The strategy cannot be used with these axes, or no run is possible.
    """
    most = ceil(asked.runs / asked.repeat) if asked.runs is not None else LISTED
    points = possible_points(space, asked.strategy, asked.seed)
    listed = list(islice(points, most))
    for axis in space.axes:
        print(f"  {axis.path} in {_values(axis)}")
    print()
    width = len(str(len(listed)))
    for number, point in enumerate(listed, start=1):
        print(f"{number:>{width}}  {title_of(point.values)}")
    if asked.runs is None and next(points, None) is not None:
        print(f"{'':>{width}}  and more; `--runs N` lists the first N")


def _values(axis: Axis) -> str:
    if isinstance(axis, Choices):
        return f"[{', '.join(axis.texts)}]"
    return f"[{axis.text(axis.low)}..{axis.text(axis.high)}]"
