"""Documentation of libraries as text of a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from textwrap import fill
from typing import Final

from seoro.cli.documentation.items import Item, Library, Parameter
from seoro.cli.tables import table
from seoro.cli.terminal import paint

KINDS: Final = {
    "action": "actions",
    "scenario": "scenarios",
    "modifier": "modifiers",
    "actor": "actors",
    "struct": "structs",
    "enum": "enumerations",
    "type": "physical types",
    "global": "global parameters",
}
"""Kinds of declarations with their titles, in the order of a page."""
DECLARED_ONLY: Final = "Declared only: invoking it is an error before the run."
_INDENT: Final = "  "
_TITLE, _NAME = "1", "36"  # styles of Select Graphic Rendition


class Page:
    """Formats documentation.

    Args:
        columns: Columns of the terminal.
        colour: Whether to use colours.
    """

    def __init__(self, columns: int, *, colour: bool) -> None:
        self._columns, self._colour = columns, colour

    def libraries(self, found: Sequence[tuple[str, str]]) -> str:
        """Return a line for each library: its name and its purpose."""
        width = max((len(name) for name, _ in found), default=0)
        return "\n".join(
            fill(
                first_sentence(meaning) or "-",
                self._columns,
                initial_indent=f"{name:{width}}  ",
                subsequent_indent=" " * (width + 2),
            )
            for name, meaning in found
        )

    def library(self, library: Library) -> str:
        """Return a library with the first sentence about each declaration."""
        parts = [self._title(library.name), self._paragraph(library.meaning)]
        for kind, items in in_order(library.items):
            parts.append("\n".join([self._heading(KINDS[kind]), *self._listed(items)]))
        return "\n\n".join(filter(None, parts))

    def item(self, item: Item, related: Sequence[Item] = ()) -> str:
        """Return all about a declaration.

        Args:
            item: The declaration.
            related: Actions and modifiers of an actor.
        """
        base = f", inherits {item.inherits}" if item.inherits else ""
        parts = [
            f"{self._title(item.name)}  ({item.kind} of {item.library}{base})",
            self._paragraph(item.meaning),
            "" if item.is_implemented else self._paragraph(DECLARED_ONLY),
            self._rows("parameters" if item.kind not in ("struct", "actor") else "fields", item.parameters),
            self._values(item),
        ]
        for title, items in (("methods and events", item.members), ("actions and modifiers", related)):
            if items:
                parts.append("\n".join([self._heading(title), *self._listed(items)]))
        if item.library.startswith("osc."):
            parts.append(f"{self._heading('use')}\n{_INDENT}import {item.library}")
        return "\n\n".join(filter(None, parts))

    def listed(self, items: Iterable[Item]) -> str:
        """Return declarations with the first sentence about each."""
        return "\n".join(self._listed(items))

    def _title(self, text: str) -> str:
        return paint(_TITLE, text, on=self._colour)

    def _heading(self, text: str) -> str:
        return paint(_TITLE, f"{text}:", on=self._colour)

    def _paragraph(self, text: str, indent: str = "") -> str:
        return fill(text, self._columns, initial_indent=indent, subsequent_indent=indent) if text else ""

    def _listed(self, items: Iterable[Item]) -> Iterator[str]:
        for item in items:
            values = f": {', '.join(item.values)}" if item.values else ""
            shown = fill(
                f"{item.signature}{values}",
                self._columns,
                initial_indent=_INDENT,
                subsequent_indent=_INDENT * 3,
                break_long_words=False,
            )
            first, *rest = shown.split(item.name, 1)
            yield first + paint(_NAME, item.name, on=self._colour) + "".join(rest)
            meaning = item.meaning if item.is_implemented else f"{item.meaning} {DECLARED_ONLY}".strip()
            if text := self._paragraph(first_sentence(meaning), _INDENT * 3):
                yield text

    def _rows(self, title: str, parameters: Sequence[Parameter]) -> str:
        if not parameters:
            return ""
        rows = [(each.name, _typed(each), _default(each), _meaning(each)) for each in parameters]
        return f"{self._heading(title)}\n{table(rows, _INDENT)}"

    def _values(self, item: Item) -> str:
        if not item.values:
            return ""
        title = f"units, in {item.result}" if item.kind == "type" else "members"
        return f"{self._heading(title)}\n" + "\n".join(f"{_INDENT}{each}" for each in item.values)


def in_order(items: Iterable[Item]) -> Iterator[tuple[str, list[Item]]]:
    """Yield the kinds of declarations in the order of a page, each with its declarations."""
    order = list(KINDS)
    ordered = sorted(items, key=lambda item: order.index(item.kind))
    for kind, found in groupby(ordered, key=lambda item: item.kind):
        yield kind, list(found)


def first_sentence(text: str) -> str:
    """Return the first sentence of a text."""
    head, stop, _ = text.partition(". ")
    return f"{head}." if stop else text


def _typed(parameter: Parameter) -> str:
    return f"{parameter.type} [{parameter.unit}]" if parameter.unit else parameter.type


def _default(parameter: Parameter) -> str:
    return f"= {parameter.default}" if parameter.default else ""


def _meaning(parameter: Parameter) -> str:
    of = f"of {parameter.of}" if parameter.of else ""
    return "; ".join(filter(None, (parameter.meaning, of)))
