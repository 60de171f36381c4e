"""Elements of a logical line: single tokens, and brackets with the items between their commas.

Comments move to places where a line can end. A comment after a comma or an operator moves before it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import accumulate, pairwise
from typing import TypeAlias

from seoro.lang.format.lines import Gap
from seoro.lang.format.roles import OPERATORS, SPLITTING, Role, is_spaced
from seoro.lang.frozen import Frozen, Value


class Atom(Value):
    """A token.

    Args:
        text: Source text.
        role: Its role.
        above: Comments on separate lines before it.
        behind: Comments after it on its line.
    """

    text: str
    role: Role
    above: tuple[str, ...] = ()
    behind: tuple[str, ...] = ()


class Group(Frozen):
    """A pair of brackets.

    Args:
        opening: The opening bracket.
        items: Elements between the commas.
        closing: The closing bracket.
        is_broken: Whether it stays on several lines, because of a comment in it or of one line per item in the
            source.
    """

    opening: Atom
    items: tuple[Elements, ...]
    closing: Atom
    is_broken: bool


MAX_BRACKETS = 100  # nested brackets, which are traversed recursively

Element: TypeAlias = Atom | Group
Elements: TypeAlias = tuple[Element, ...]


def deepest(roles: Iterable[Role]) -> int:
    """Return the depth of nested brackets."""
    steps = {Role.OPEN: 1, Role.CLOSE: -1}
    return max(accumulate(steps.get(role, 0) for role in roles))


def first_of(element: Element) -> Atom:
    """Return the first token of an element."""
    return element.opening if isinstance(element, Group) else element


def last_of(element: Element) -> Atom:
    """Return the last token of an element."""
    return element.closing if isinstance(element, Group) else element


def flat(elements: Elements) -> str:
    """Format elements on one line, without comments."""
    parts: list[str] = []
    for element, blank in zip(elements, blanks(elements), strict=True):
        match element:
            case Atom(text=text):
                parts += [blank, text]
            case Group(opening=opening, items=items, closing=closing):
                parts += [blank, opening.text, ", ".join(map(flat, items)), closing.text]
    return "".join(parts)


def blanks(elements: Elements) -> list[str]:
    """Return the blank, if any, before each element."""
    wide = _has_wide_ranges(elements)
    found = [""] * len(elements)
    for index, (before, after) in enumerate(pairwise(elements), start=1):
        roles = last_of(before).role, first_of(after).role
        if is_spaced(*roles) or (wide and Role.RANGE in roles):
            found[index] = " "
    return found


def _has_wide_ranges(elements: Elements) -> bool:
    """Return whether `..` needs blanks: beside operators, which bind more, and before `.5`."""
    if not any(isinstance(element, Atom) and element.role is Role.RANGE for element in elements):
        return False
    return any(
        isinstance(element, Atom) and (element.role in OPERATORS or element.text.startswith(".5"))
        for element in elements
    )


def read_elements(texts: Sequence[str], roles: Sequence[Role], gaps: Sequence[Gap]) -> Elements:
    """Group the tokens of a logical line, without the comments after it.

    Args:
        texts: Source texts of the tokens.
        roles: Roles of the tokens.
        gaps: Gap after each token.
    """
    atoms = _atoms(texts, roles, gaps)
    stack: list[_Open] = [_Open(Atom("", Role.OPEN), False)]
    for index, atom in enumerate(atoms):
        innermost = stack[-1]
        if atom.role is Role.OPEN:
            stack.append(_Open(atom, gaps[index].has_end))
        elif atom.role is Role.CLOSE:
            stack.pop()
            stack[-1].current.append(innermost.close(atom))
        elif atom.role is Role.COMMA and len(stack) > 1:
            innermost.items.append(tuple(innermost.current))
            innermost.current = []
            innermost.rows += gaps[index].has_end
        else:
            innermost.current.append(atom)
    return tuple(stack[0].current)


class _Open:
    """A bracket without its end so far."""

    def __init__(self, opening: Atom, starts_row: bool) -> None:
        self.opening = opening
        self.rows = int(starts_row)  # number of items that start a line
        self.items: list[Elements] = []
        self.current: list[Element] = []

    def close(self, closing: Atom) -> Group:
        """Create the group of the closing bracket."""
        items = (*self.items, tuple(self.current)) if self.current else tuple(self.items)
        has_comments = bool(closing.above) or any(_has_comments(element) for item in items for element in item)
        return Group(self.opening, items, closing, has_comments or 1 < len(items) == self.rows)


def _has_comments(element: Element) -> bool:
    first, last = first_of(element), last_of(element)
    if first.above or last.behind:
        return True
    return isinstance(element, Group) and (
        bool(element.closing.above) or any(_has_comments(inner) for item in element.items for inner in item)
    )


def _atoms(texts: Sequence[str], roles: Sequence[Role], gaps: Sequence[Gap]) -> list[Atom]:
    """Return the tokens with their comments, moved to places where a line can end, or above their item."""
    above: list[list[str]] = [[] for _ in texts]
    behind: list[list[str]] = [[] for _ in texts]
    splits = [role in OPERATORS and text in SPLITTING for text, role in zip(texts, roles, strict=True)]
    starts = [0]  # start of the current item of each open bracket
    for index, gap in enumerate(gaps[:-1]):
        before, after = roles[index], roles[index + 1]
        if before is Role.OPEN:
            starts.append(index + 1)
        elif before is Role.CLOSE:
            starts.pop()
        elif before is Role.COMMA:
            starts[-1] = index + 1
        start = starts[-1]
        for comment in gap.comments:
            if not comment.is_alone and before is Role.COMMA:
                behind[index - 1].append(comment.text)
            elif index < start:
                above[start].append(comment.text)
            elif after is Role.COMMA or (not comment.is_alone and (after is Role.CLOSE or splits[index + 1])):
                behind[index].append(comment.text)
            elif after is Role.CLOSE or splits[index + 1]:
                above[index + 1].append(comment.text)
            elif splits[index]:
                (above[index] if comment.is_alone else behind[index - 1]).append(comment.text)
            else:
                above[start].append(comment.text)
    return [
        Atom(text, role, tuple(over), tuple(after_it))
        for text, role, over, after_it in zip(texts, roles, above, behind, strict=True)
    ]
