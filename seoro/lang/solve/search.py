"""Choice of values after propagation: by uniform draws if practical, else by a bounded search.

Cells that share constraints form a group; groups are independent. In a group, all cells are drawn from their
domains until the constraints hold, so that the result is uniform over the solutions. Equalities determine some
cells, which are computed. After too many draws, cells are chosen one after the other, each uniformly from the
values that earlier choices leave, with backtracking and restarts.

Each cell has its own random stream, so that unrelated cells do not affect each other. A stream is the sequence of
SHA-256 digests of seed, name and a counter: the same on every machine and in every version of Python, unlike the
methods of `random.Random`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from hashlib import sha256
from itertools import islice
from typing import Final, TypeVar, cast

from seoro.lang.solve.evaluation import holds
from seoro.lang.solve.orders import impossible_order
from seoro.lang.solve.problem import Unbounded
from seoro.lang.solve.propagate import Clash, Store
from seoro.lang.solve.sets import (
    Finite,
    Range,
    ValueSet,
    contains,
    is_bounded,
    is_narrow,
    is_whole,
    members,
    single,
)
from seoro.lang.solve.terms import OPAQUE_COST, Cell, Value

Item = TypeVar("Item")


class Stream:
    """An endless sequence of random numbers.

    Args:
        seed: Seed of the run.
        name: Name of the cell.
    """

    def __init__(self, seed: int, name: str) -> None:
        self._prefix = f"{seed}\0{name}\0".encode()
        self._count = 0

    def bits(self, count: int) -> int:
        """Return an integer of `count` random bits, at most 256."""
        digest = sha256(self._prefix + str(self._count).encode()).digest()
        self._count += 1
        return int.from_bytes(digest, "big") >> (256 - count)

    def below(self, limit: int) -> int:
        """Return an integer from 0 to `limit` - 1, uniformly."""
        size = (limit - 1).bit_length()
        while (found := self.bits(size)) >= limit:
            pass
        return found

    def real(self, low: float, high: float) -> float:
        """Return a real from `low` to `high`, uniformly."""
        share = self.bits(53) / 2**53
        return min(max(low * (1 - share) + high * share, low), high)

    def shuffled(self, items: tuple[Item, ...]) -> list[Item]:
        """Return items in random order (Fisher and Yates)."""
        rest, order = list(items), []
        while rest:
            order.append(rest.pop(self.below(len(rest))))
        return order


class Streams:
    """Random streams of cells, created on first use."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._streams: dict[str, Stream] = {}

    def of(self, cell: Cell) -> Stream:
        """Return the stream of a cell at its current position."""
        if cell.name not in self._streams:
            self._streams[cell.name] = Stream(self._seed, cell.name)
        return self._streams[cell.name]


# Limits of draws of a whole group, and of their effort [examined terms], before cells are chosen one by one.
TRIES: Final = 64
TRIES_EFFORT: Final = 30_000
# Dead ends of a search before a restart with other draws; only the effort limits the last one.
PATIENCE: Final = (10, 50, 200)
EFFORT: Final = 100_000
# Groups with at most this number of combinations are searched completely.
ALWAYS: Final = 20_000
_SOLVED: Final = (0, 0.0)  # size of a range that is only rounding


class Exhausted(Exception):
    """The constraints have no solution.

    Args:
        parts: Numbers of the contradicting parts.
        by_z3: Whether z3 found the contradiction.
    """

    def __init__(self, parts: frozenset[int], by_z3: bool = False) -> None:
        super().__init__(len(parts))
        self.parts = parts
        self.by_z3 = by_z3


class GivenUp(Exception):
    """The search exceeded its limits."""


def groups(store: Store) -> list[list[int]]:
    """Return the open cells in groups that share constraints, in the order of cells."""
    leader = list(range(len(store.cells)))

    def find(cell: int) -> int:
        while leader[cell] != cell:
            leader[cell] = leader[leader[cell]]
            cell = leader[cell]
        return cell

    for number, part in enumerate(store.parts):
        if number not in store.entailed:
            still_open = [cell for cell in part.cells if store.is_open(cell)]
            for cell in still_open[1:]:
                first, second = sorted((find(still_open[0]), find(cell)))
                leader[second] = first
    found: dict[int, list[int]] = {}
    for cell in range(len(store.cells)):
        if store.is_open(cell):
            found.setdefault(find(cell), []).append(cell)
    return list(found.values())


def choose(store: Store, group: list[int], streams: Streams) -> None:
    """Choose values for the cells of a group.

    Raises:
        Exhausted: The constraints have no solution.
        GivenUp: The search found none.
        Unbounded: A cell without bounds cannot be drawn.
    """
    mark, start = len(store.trail), store.effort
    drawn = _independent(store, group)
    for _ in range(TRIES):
        try:
            if _draw(store, drawn, streams):
                return _complete(store, group, streams, PATIENCE[0], start + TRIES_EFFORT)
        except (Clash, Exhausted, GivenUp):
            pass
        store.undo(mark)
        if store.effort > start + TRIES_EFFORT:
            break
    if circle := impossible_order(store):
        raise Exhausted(circle)
    for patience in PATIENCE:
        try:
            return _complete(store, group, streams, patience, start + EFFORT)
        except GivenUp:
            store.undo(mark)
    most = math.inf if _has_few_combinations(store, group) else start + EFFORT
    try:
        return _complete(store, group, streams, math.inf, most)
    except GivenUp:
        store.undo(mark)
        raise


def _has_few_combinations(store: Store, group: list[int]) -> bool:
    """Return whether all combinations of values of a group can be tried."""
    combinations = (
        max([OPAQUE_COST, *(store.parts[number].cost for number in store.parts_of(group))]) // OPAQUE_COST
    )
    for cell in group:
        listed = members(store.sets[cell])
        if listed is None:
            return False
        combinations *= len(listed)
        if combinations > ALWAYS:
            return False
    return True


def _independent(store: Store, group: list[int]) -> list[int]:
    """Return the cells to draw: all with bounds, except one cell per equality, which follows from the others."""
    follows: set[int] = set()
    for number in store.parts_of(group):
        candidates = [cell for cell in store.parts[number].solvable if store.is_open(cell) and cell not in follows]
        if candidates:
            follows.add(candidates[-1])
    return [cell for cell in group if cell not in follows and is_bounded(store.sets[cell])]


def _draw(store: Store, cells: list[int], streams: Streams) -> bool:
    """Draw all cells from their initial domains; return False if the values contradict each other."""
    beginning = [store.sets[cell] for cell in cells]
    for cell, values in zip(cells, beginning, strict=True):
        value = any_of(values, store, cell, streams)
        if not contains(store.sets[cell], value):
            return False
        if store.is_open(cell):
            store.assign(cell, single(value), exact=True)
    return True


def any_of(values: ValueSet, store: Store, cell: int, streams: Streams) -> Value:
    """Draw a value of a set, uniformly."""
    stream = streams.of(store.cells[cell])
    match values:
        case Finite(listed):
            return listed[stream.below(len(listed))]
        case Range(low, high) if is_whole(values):
            return cast(int, low) + stream.below(cast(int, high) - cast(int, low) + 1)
        case Range(low, high):
            return stream.real(low, high)
        case _:
            raise Unbounded(store.cells[cell])


def _complete(store: Store, group: list[int], streams: Streams, patience: float, effort: float) -> None:
    """Choose values for the open cells of a group one after the other, with backtracking.

    Raises:
        Exhausted: The constraints have no solution.
        GivenUp: The search had more than `patience` dead ends, or the effort of the store exceeds `effort`.
        Unbounded: A cell without bounds cannot be drawn.
    """
    stack: list[tuple[int, int, Iterator[tuple[ValueSet, bool]]]] = []
    concerned, blamed = set(store.parts_of(group)), set[int]()
    first = 0  # earlier cells of the group are known
    while True:
        while first < len(group) and not store.is_open(group[first]):
            first += 1
        cell = next_cell(store, group, first)
        if cell is None:
            return
        stack.append((len(store.trail), cell, _alternatives(store, cell, streams)))
        while stack:
            mark, cell, alternatives = stack[-1]
            if len(store.trail) > mark:
                store.undo(mark)
                first = 0
            following = next(alternatives, None)
            if following is None:
                stack.pop()
                continue
            try:
                store.assign(cell, following[0], exact=following[1])
                break
            except Clash as clash:
                if not blamed >= concerned:
                    blamed |= involved(store, clash.part)
                patience -= 1
                if patience < 0 or store.effort > effort:
                    raise GivenUp from None
        else:
            raise Exhausted(frozenset(blamed))


def involved(store: Store, part: int) -> set[int]:
    """Return the parts that led to a clash: the part, and all that narrowed cells of it, transitively."""
    parts, cells = {part}, set(store.parts[part].cells)
    for cell, _, _, by in reversed(store.trail):
        if by >= 0 and by not in parts and cell in cells:
            parts.add(by)
            cells.update(store.parts[by].cells)
    return parts


def next_cell(store: Store, group: list[int], first: int = 0) -> int | None:
    """Return the open cell to choose next: a solved one except for rounding, else one with the fewest values.

    Args:
        store: The domains of the cells.
        group: Numbers of the cells.
        first: Index in the group of the first open cell.

    Returns:
        The number of the cell, or None without open cells.
    """
    best, least = None, (4, 0.0)
    for cell in islice(group, first, None):
        if not store.is_open(cell):
            continue
        size = _size(store.sets[cell])
        if size == _SOLVED:
            return cell
        if size < least:
            best, least = cell, size
    if best is not None and not is_bounded(store.sets[best]):
        raise Unbounded(store.cells[best])
    return best


def _size(values: ValueSet) -> tuple[int, float]:
    """Return the sort key of the next cell: kind, then number of values."""
    match values:
        case Finite(listed):
            return (1, len(listed))
        case Range(low, high) if is_bounded(values):
            if is_narrow(values):
                return _SOLVED
            return (1, high - low + 1) if is_whole(values) else (2, 0.0)
        case _:
            return (3, 0.0)


def _alternatives(store: Store, cell: int, streams: Streams) -> Iterator[tuple[ValueSet, bool]]:
    """Yield sets to try, which cover the domain of a cell, each with whether it is a drawn value."""
    values = store.sets[cell]
    if is_narrow(values):
        yield single(solved_for(store, cell, cast(Range, values))), False
        return
    stream = streams.of(store.cells[cell])
    listed = members(values)
    if listed is not None:
        for value in stream.shuffled(listed):
            yield single(value), True
        return
    yield single(any_of(values, store, cell, streams)), True
    for half in stream.shuffled(halves(cast(Range, values))):
        yield half, False


def halves(values: Range) -> tuple[Range, Range]:
    """Return the lower and the upper half of a range."""
    low, high = values
    if is_whole(values):
        middle = (cast(int, low) + cast(int, high)) // 2
        return Range(low, middle), Range(middle + 1, high)
    centre = low / 2 + high / 2
    return Range(low, centre), Range(centre, high)


def solved_for(store: Store, cell: int, values: Range) -> float:
    """Return the real, of a range that is only rounding, that satisfies the most evaluable parts exactly."""
    low, high = values
    centre = low / 2 + high / 2
    candidates = [centre, float(f"{centre:.12g}"), low, high]
    parts = [store.parts[number] for number in store.watchers[cell] if number not in store.entailed]
    ready = [part for part in parts if not any(store.is_open(other) for other in part.cells if other != cell)]

    store.effort += len(candidates) * sum(part.cost for part in ready)

    def satisfied(value: float) -> int:
        return sum(holds(part.term, {**store.values(part.cells), store.cells[cell]: value}) for part in ready)

    return max((value for value in candidates if low <= value <= high), key=satisfied)
