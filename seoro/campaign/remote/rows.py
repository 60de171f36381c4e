"""Rows from other machines: checked before they are stored."""

from __future__ import annotations

from collections.abc import Mapping
from types import UnionType
from typing import Final, get_args, get_origin, get_type_hints

from seoro.campaign.identity import run_id
from seoro.campaign.runs import Planned, Row
from seoro.campaign.store.folder import KEPT
from seoro.lang.frozen import Value


class InvalidRow(Exception):
    """A line is not the row of a run that was given."""


class Checker(Value):
    """Checks rows of a campaign.

    Args:
        digest: Digest of the campaign.
        version: Version of seoro.
    """

    digest: str
    version: str

    def read(self, line: bytes, given: Mapping[int, Planned]) -> Row:
        """Decode a row.

        Args:
            line: A line as of `Row.to_line`.
            given: Runs without a row so far, by number.

        Raises:
            InvalidRow: The line is not the row of one of them.
        """
        try:
            row = Row.from_line(line)
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise InvalidRow(f"invalid row: {error}") from error
        for name, kinds in _KINDS.items():
            value = getattr(row, name)
            if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
                raise InvalidRow(f"invalid row: `{name}` is a {type(value).__name__}")
        if not all(isinstance(item, Mapping) for item in row.coverage):
            raise InvalidRow("invalid row: `coverage` is not a list of objects")
        planned = given.get(row.run)
        if planned is None or row.id != run_id(self.digest, planned.values, planned.seed):
            raise InvalidRow(f"invalid row: the run {row.run} was not given, or differs")
        if row.folder not in ("", kept_folder(row.run)):
            raise InvalidRow(f"invalid row: unexpected folder `{row.folder}`")
        return row


def kept_folder(run: int) -> str:
    """Return the folder of a kept run, relative to that of the campaign."""
    return f"{KEPT}/{run:06}"


def _kinds(hint: object) -> tuple[type, ...]:
    """Return the classes of valid values; integers are valid floats."""
    kinds = tuple(
        get_origin(each) or each for each in (get_args(hint) if isinstance(hint, UnionType) else (hint,))
    )
    return (*kinds, int) if float in kinds else kinds


_HINTS: Final = get_type_hints(Row)
_KINDS: Final = {name: _kinds(_HINTS[name]) for name in Row.__match_args__}
