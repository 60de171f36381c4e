"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Collection, Sequence


def table(rows: Sequence[Sequence[str]], indent: str = "", right: Collection[int] = ()) -> str:
    """Format rows with aligned columns; columns in `right` are aligned to the right."""
    columns = list(zip(*rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    signs = [">" if index in right else "<" for index in range(len(columns))]
    form = "  ".join(f"{{:{sign}{width}}}" for sign, width in zip(signs, widths, strict=True))
    return "\n".join((indent + form.format(*row)).rstrip() for row in rows)
