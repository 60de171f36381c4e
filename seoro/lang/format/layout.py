"""Breaking of logical lines that are too long, or that contain comments.

Items in brackets move to separate lines, indented by four blanks; by eight before a block, which differs then
(PEP 8). Expressions break before the operators that bind least. Outside of brackets, a backslash joins lines
(9.2.2.5).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import lru_cache

from seoro.lang.format.elements import Atom, Elements, Group, blanks, first_of, flat, last_of
from seoro.lang.format.roles import ARITHMETIC, LOGICAL, OPERATORS, Level, Role
from seoro.lang.frozen import Value

LINE_LENGTH = 100  # characters; the guide has no limit
INDENT = 4  # blanks per block (9.2.2.1)

_JOINED = " \\"


class Place(Value):
    """Position and surroundings of elements.

    Args:
        column: Column of the first element, from 0.
        hang: Indentation of items in broken brackets [characters].
        continued: Indentation of lines that continue an expression [characters].
        in_brackets: Whether a line may end without a backslash.
        suffix: Text after the last element, before its comment.
        reserve: Number of further characters after the suffix.
    """

    column: int
    hang: int = INDENT
    continued: int = 0
    in_brackets: bool = True
    suffix: str = ""
    reserve: int = 0

    def holds(self, line: str, *, is_last: bool = True) -> bool:
        """Return whether a line with its indentation fits."""
        behind = len(self.suffix) + self.reserve if is_last else 0
        return max(map(len, line.split("\n"))) + behind <= LINE_LENGTH


def lay_out(elements: Elements, place: Place) -> list[str]:
    """Format elements as lines, with the comments above and after them.

    Args:
        elements: The elements.
        place: Their position.
    """
    line = " " * place.column + flat(elements)
    has_comments = any(element.behind for element in map(last_of, elements[:-1])) or any(
        element.above for element in map(first_of, elements[1:])
    )
    if has_comments and (chunks := _split(elements, (*LOGICAL, *ARITHMETIC))):
        return _join(chunks, place)
    if not place.holds(line) and (chunks := _split(elements, LOGICAL)) and _is_worth_it(chunks[0], place):
        return _join(chunks, place)
    lines, is_short = _break_groups(elements, place)
    if not is_short and (chunks := _split(elements, (*LOGICAL, *ARITHMETIC)) or _split_at_commas(elements)):
        return _join(chunks, place)
    above, behind = first_of(elements[0]).above, last_of(elements[-1]).behind
    lines[-1] += place.suffix + "".join(f"  {comment}" for comment in behind[-1:])  # the others move above
    return [*(" " * place.column + comment for comment in (*above, *behind[:-1])), *lines]


def _is_worth_it(first: Elements, place: Place) -> bool:
    """Return whether a line can end after these elements without breaking brackets in them."""
    return place.in_brackets or place.holds(" " * place.column + flat(first) + _JOINED, is_last=False)


def _split(elements: Elements, levels: Iterable[Level]) -> list[Elements]:
    """Split elements before the operators of the first level that occurs; empty without operators."""
    for level in levels:
        starts = [
            index
            for index, element in enumerate(elements)
            if index > 0 and isinstance(element, Atom) and element.role in OPERATORS and element.text in level
        ]
        if starts:
            return _cut(elements, starts)
    return []


def _split_at_commas(elements: Elements) -> list[Elements]:
    """Split elements after commas outside of brackets; empty without such commas."""
    starts = [
        index
        for index, element in enumerate(elements)
        if index > 0 and isinstance(before := elements[index - 1], Atom) and before.role is Role.COMMA
    ]
    return _cut(elements, starts) if starts else []


def _cut(elements: Elements, starts: list[int]) -> list[Elements]:
    return [elements[start:end] for start, end in zip([0, *starts], [*starts, len(elements)], strict=True)]


def _join(chunks: list[Elements], place: Place) -> list[str]:
    """Format the parts of an expression, each on its own lines."""
    lines: list[str] = []
    for number, chunk in enumerate(chunks):
        there = replace(place, column=place.column + (place.continued if number else 0))
        if chunk is not chunks[-1]:
            there = replace(there, suffix="" if place.in_brackets else _JOINED, reserve=0)
        lines += lay_out(chunk, there)
    return lines


def _break_groups(elements: Elements, place: Place) -> tuple[list[str], bool]:
    """Format elements with only the longest brackets broken; return the lines and whether all of them fit."""
    groups = {index: element for index, element in enumerate(elements) if isinstance(element, Group)}
    broken = {index for index, group in groups.items() if _stays_broken(group)}
    lines, is_short = _lay_out_groups(elements, broken, place)
    whole = {index: len(flat((group,))) for index, group in groups.items() if group.items and index not in broken}
    if is_short or not whole or (len(whole) > 1 and _split(elements, ARITHMETIC)):
        return lines, is_short
    return _lay_out_groups(elements, {*broken, max(whole, key=lambda index: whole[index])}, place)


def _stays_broken(group: Group) -> bool:
    return group.is_broken or any(
        isinstance(element, Group) and _stays_broken(element) for item in group.items for element in item
    )


def _lay_out_groups(elements: Elements, broken: Collection[int], place: Place) -> tuple[list[str], bool]:
    """Format elements of which some are broken; return the lines and whether lines without items fit."""
    lines: list[str] = []
    line = " " * place.column
    is_short = True
    for index, (element, blank) in enumerate(zip(elements, blanks(elements), strict=True)):
        line += blank
        if not isinstance(element, Group) or index not in broken:
            line += flat((element,))
            continue
        opened, group, closed = _descend(element, LINE_LENGTH - len(line))
        line += opened
        is_short = is_short and place.holds(line, is_last=False)
        behind = len(place.suffix) + place.reserve if element is elements[-1] else 0
        lines.append(line)
        lines += _lay_out_items(group, place, behind + len(closed))
        line = lines.pop() + closed
    return [*lines, line], is_short and place.holds(line)


def _descend(group: Group, width: int) -> tuple[str, Group, str]:
    """Find the innermost brackets to break if brackets contain only a call, as in `f(g(...))`.

    Args:
        group: The outermost brackets.
        width: Limit of the text to the innermost opening bracket [characters].

    Returns:
        The text to the innermost opening bracket, the innermost brackets, and the brackets that close the others.
    """
    opened, closed = group.opening.text, ""
    while (item := _hugged(group)) is not None:
        *_, inner = item
        assert isinstance(inner, Group)
        longer = opened + flat(item[:-1]) + blanks(item)[-1] + inner.opening.text
        if len(longer) > width:
            break
        opened, closed, group = longer, group.closing.text + closed, inner
    return opened, group, closed


def _hugged(group: Group) -> Elements | None:
    """Return the only item of brackets if it ends in brackets and can stay on their line, else None."""
    if len(group.items) != 1 or group.closing.above:
        return None
    *before, last = group.items[0]
    is_plain = all(
        isinstance(element, Atom) and element.role not in OPERATORS and not element.above and not element.behind
        for element in before
    )
    fits = isinstance(last, Group) and bool(last.items) and not last.opening.above and not last.closing.behind
    return group.items[0] if is_plain and fits else None


@lru_cache(maxsize=1024)
def _lay_out_items(group: Group, place: Place, reserve: int) -> tuple[str, ...]:
    """Format the lines after an opening bracket, including the closing one.

    Results are cached: an expression is formatted with broken brackets before it is split at operators, which
    formats them again. Without the cache, each nested bracket doubles the time.

    Args:
        group: The brackets.
        place: Their position.
        reserve: Number of characters after the closing bracket.
    """
    lines: list[str] = []
    column = place.column + place.hang
    if _is_filled(group):
        lines += _fill([flat(item) for item in group.items], column, reserve + len(group.closing.text))
    else:
        inner = Place(column, continued=INDENT if len(group.items) > 1 else 0)
        for item in group.items[:-1]:
            lines += lay_out(item, replace(inner, suffix=","))
        for item in group.items[-1:]:
            lines += lay_out(item, replace(inner, reserve=reserve + len(group.closing.text)))
    ends_in_comment = bool(group.items and last_of(group.items[-1][-1]).behind)
    if group.closing.above or ends_in_comment:
        lines += [" " * column + comment for comment in group.closing.above]
        lines.append(" " * place.column + group.closing.text)
    else:
        lines[-1] += group.closing.text
    return tuple(lines)


def _is_filled(group: Group) -> bool:
    """Return whether items share lines: in unbroken lists of plain values."""
    return (
        group.opening.text == "["
        and not group.is_broken
        and all(isinstance(element, Atom) for item in group.items for element in item)
    )


def _fill(items: list[str], column: int, reserve: int) -> list[str]:
    """Fill lines with items."""
    lines: list[str] = []
    line = " " * column + items[0]
    for index, item in enumerate(items[1:], start=1):
        longer = f"{line}, {item}"
        behind = reserve if index == len(items) - 1 else 1
        if len(longer) + behind <= LINE_LENGTH:
            line = longer
        else:
            lines.append(line + ",")
            line = " " * column + item
    return [*lines, line]
