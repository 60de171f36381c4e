"""Comparison of what two checkouts wrote in a run, without what differs between any two runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Final

STAMP: Final = re.compile(r'"wall": "[-0-9T:.+]+"')
# Parts that differ between two runs of one checkout, each with the reason.
VOLATILE: Final = tuple(
    (re.compile(pattern), replacement)
    for pattern, replacement in (
        # Time of a record by the clock of the machine.
        (STAMP.pattern, '"wall": "*"'),
        # Checkouts may be of different versions; other records may well have a field of that name.
        (r'("kind": "run\.start".*"version": )"[^"]*"', r'\1"*"'),
        # Duration of a clean-up by the clock of the machine.
        (r'"clean_up": [0-9.]+', '"clean_up": "*"'),
        (r"(the clean-up of .* took )[0-9.]+ s\b", r"\1* s"),
        # Duration of a run by the clock of the machine, in the line with the verdict.
        (r"[0-9.]+ s real\b", "* s real"),
        # Ports are chosen by the system.
        (r"(tcp|tls)/(127\.0\.0\.1|localhost):[0-9]+", r"\1/*"),
        # Addresses of objects in the texts of exceptions.
        (r"0x[0-9a-f]{6,}", "0x*"),
    )
)
# Lines that come by the processor time that a run takes, or not at all.
TIMELY: Final = re.compile(r"behaviors have started without time passing")


def first_difference(there: Path, here: Path, places: dict[str, str]) -> tuple[int, str | None, str | None] | None:
    """Number and text of the first line that differs in two files; None if all are the same.

    Args:
        there, here: The files; one that does not exist has no lines.
        places: Names of folders, by their paths.
    """
    pairs = zip_longest(_lines_of(there), _lines_of(here))
    for number, (one, other) in enumerate(pairs, start=1):
        if one == other or _unstamped(one) == _unstamped(other):
            continue
        if (one := _stable(one, places)) != (other := _stable(other, places)):
            return number, one, other
    return None


def _lines_of(path: Path) -> Iterator[str]:
    """Yield the lines of a file without timely ones; nothing if the file is missing."""
    if not path.exists():
        return
    with path.open(encoding="utf-8", errors="backslashreplace", newline="") as file:
        for line in file:
            if not TIMELY.search(line):
                yield line


def _unstamped(line: str | None) -> str | None:
    """Return a line without its stamp, the only difference of most lines."""
    return line and STAMP.sub("", line, count=1)


def _stable(line: str | None, places: dict[str, str]) -> str | None:
    """Return a line without volatile parts."""
    if line is None:
        return None
    for place, name in places.items():
        line = line.replace(place, name)
    for pattern, replacement in VOLATILE:
        line = pattern.sub(replacement, line)
    return line.rstrip("\n")
