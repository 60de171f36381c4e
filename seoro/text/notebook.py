"""HTML of objects in notebooks: cards and tables, readable on light and dark pages, with all texts escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Final

from seoro.text.printable import printable

MOST: Final = 300  # [characters] of a text
_QUIET: Final = "#7a8699"
_COLOURS: Final = {"passed": "#2c9a57", "failed": "#d64545", "error": "#c07a12"}  # of a line, never the only sign
_SIGNS: Final = {"passed": "\N{CHECK MARK}", "failed": "\N{BALLOT X}", "error": "!", "cancelled": "\N{EN DASH}"}
_CARD: Final = "border-left:4px solid {colour};padding:2px 0 2px 12px;margin:4px 0;line-height:1.45"
_CELL: Final = "text-align:left;vertical-align:top;padding:1px 16px 1px 0;background:none"


def text_html(text: object) -> str:
    """Escape a text, and shorten a long one."""
    found = printable(str(text))
    return escape(found if len(found) <= MOST else found[: MOST - 1] + "\N{HORIZONTAL ELLIPSIS}")


def card(title: str, status: str, facts: Mapping[str, object], lines: Sequence[str] = (), table: str = "") -> str:
    """Return a card.

    Args:
        title: Name of the object.
        status: Status in one word; empty for none.
        facts: Values by name; None and empty texts are left out.
        lines: Lines below.
        table: HTML below, as of `table`.
    """
    word = f" <b>{_SIGNS.get(status, '')} {text_html(status)}</b>" if status else ""
    rows = [(name, value) for name, value in facts.items() if value is not None and value != ""]
    listed = "".join(f"<div>{text_html(line)}</div>" for line in lines)
    style = _CARD.format(colour=_COLOURS.get(status, _QUIET))
    content = f"{table_html((), rows) if rows else ''}{listed}{table}"
    return f'<div style="{style}"><div><b>{text_html(title)}</b>{word}</div>{content}</div>'


def table_html(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table.

    Args:
        head: Titles of its columns; empty for none. Without titles, the first column has names.
        rows: Its cells; floats are rounded.
    """
    titles = f"<tr>{''.join(_cell(name, 'th') for name in head)}</tr>" if head else ""
    body = "".join(
        f"<tr>{''.join(_cell(value, 'td' if head or index else 'th') for index, value in enumerate(row))}</tr>"
        for row in rows
    )
    return f'<table style="margin:2px 0;border:none">{titles}{body}</table>'


def _cell(value: object, kind: str) -> str:
    weight = ";font-weight:normal;opacity:.75" if kind == "th" else ""
    shown = f"{value:.6g}" if isinstance(value, float) else value
    return f'<{kind} style="{_CELL}{weight}">{text_html(shown)}</{kind}>'
