"""Breaks logical lines that are too long, or that hold comments.

What stands in brackets goes to lines of its own, four blanks further in, or eight where a block follows, so that
the two are told apart (PEP 8). Expressions are taken apart before the operators that bind least. Outside of
brackets, lines are joined by a backslash (9.2.2.5).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import lru_cache

from seoro.lang.format.elements import Atom, Elements, Group, blanks, first_of, flat, last_of
from seoro.lang.format.roles import ARITHMETIC, LOGICAL, OPERATORS, Level, Role
from seoro.lang.frozen import Value

LINE_LENGTH = 100  # characters; the guide has no number
INDENT = 4  # blanks a block (9.2.2.1)

_JOINED = " \\"


class Place(Value):
    """Where elements are to be put.

    Args:
        column: Of the first of them, from 0.
        hang: How much further in what is broken off in brackets goes.
        continued: How much further in lines behind an operator begin.
        in_brackets: Whether a line may end without a backslash.
        suffix: What comes behind the last of them, before its comment.
        reserve: How many more characters have to fit behind that.
    """

    column: int
    hang: int = INDENT
    continued: int = 0
    in_brackets: bool = True
    suffix: str = ""
    reserve: int = 0

    def holds(self, line: str, *, is_last: bool = True) -> bool:
        """Whether a line, with its indentation, is not too long."""
        behind = len(self.suffix) + self.reserve if is_last else 0
        return max(map(len, line.split("\n"))) + behind <= LINE_LENGTH


def lay_out(elements: Elements, place: Place) -> list[str]:
    """The lines of some elements, with the comments above and behind them.

    Args:
        elements: What stands there.
        place: Where.
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
    lines[-1] += place.suffix + "".join(f"  {comment}" for comment in behind[-1:])  # no more than one fits
    return [*(" " * place.column + comment for comment in (*above, *behind[:-1])), *lines]


def _is_worth_it(first: Elements, place: Place) -> bool:
    """Whether to end a line behind these elements: a backslash has to spare breaking the brackets before it."""
    return place.in_brackets or place.holds(" " * place.column + flat(first) + _JOINED, is_last=False)


def _split(elements: Elements, levels: Iterable[Level]) -> list[Elements]:
    """The elements before and from each operator of the first level that has any; none if there is no operator."""
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
    """The elements to each comma that is in no bracket."""
    starts = [
        index
        for index, element in enumerate(elements)
        if index > 0 and isinstance(before := elements[index - 1], Atom) and before.role is Role.COMMA
    ]
    return _cut(elements, starts) if starts else []


def _cut(elements: Elements, starts: list[int]) -> list[Elements]:
    return [elements[start:end] for start, end in zip([0, *starts], [*starts, len(elements)], strict=True)]


def _join(chunks: list[Elements], place: Place) -> list[str]:
    """The lines of parts of an expression, each on lines of its own."""
    lines: list[str] = []
    for number, chunk in enumerate(chunks):
        there = replace(place, column=place.column + (place.continued if number else 0))
        if chunk is not chunks[-1]:
            there = replace(there, suffix="" if place.in_brackets else _JOINED, reserve=0)
        lines += lay_out(chunk, there)
    return lines


def _break_groups(elements: Elements, place: Place) -> tuple[list[str], bool]:
    """The lines of elements with no brackets broken but the longest, and whether none of the lines is too long."""
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
    """The lines of elements of which some are broken; whether those that are not of items fit."""
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
    """The brackets that are to be broken where some hold nothing but what ends in others, as in `f(g(...))`.

    Args:
        group: The outermost brackets.
        width: How many characters there are for all the opening ones.

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
    """The only item of brackets if it ends in brackets and may stay on the line of these."""
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
    """The lines behind an opening bracket, to the closing one.

    They are kept for a while: an expression is tried with its brackets broken before it is taken apart at its
    operators, and then they are wanted again. Without that, each bracket in another doubles the time.

    Args:
        group: The brackets.
        place: Where they stand.
        reserve: How many characters have to fit behind the closing bracket.
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
    """Whether items share lines: those of lists of plain values, where nothing speaks against it."""
    return (
        group.opening.text == "["
        and not group.is_broken
        and all(isinstance(element, Atom) for item in group.items for element in item)
    )


def _fill(items: list[str], column: int, reserve: int) -> list[str]:
    """Items on as few lines as they need, each line as long as may be."""
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
