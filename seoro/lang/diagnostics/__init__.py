"""Every message of the language front end, one file a phase; codes are stable.

A message is a frozen dataclass that turns itself into a `Diagnostic`.

The phases: `syntax` (E01), `imports` and `names` (E02), `types` and `methods` (E03), `behaviors`, `events`,
`modifiers` and `times` (E04), `coverage` (E05), `bindings` to Python (E06).
"""

from __future__ import annotations

from collections.abc import Iterable

MAX_CANDIDATES = 500  # for what may have been meant


def near(name: str, candidates: Iterable[str]) -> str:
    """A help text that names what may have been meant; empty if nothing comes near."""
    from difflib import get_close_matches  # noqa: PLC0415 - slow to load, and seldom needed

    known = sorted(set(candidates))
    if len(known) > MAX_CANDIDATES:  # each is compared, letter by letter
        known = [candidate for candidate in known if candidate[:3] == name[:3]][:MAX_CANDIDATES]
    prefixed = [candidate for candidate in known if candidate.endswith(f"::{name}")]
    found = prefixed or get_close_matches(name, known, n=3, cutoff=0.6)
    return f"did you mean {listing(found, 'or')}?" if found else ""


def a(name: str) -> str:
    """A type with its article: `a length` of the quoted name; what is no quoted name stays as it is."""
    if not name.startswith("`"):
        return name
    bare = name.strip("`")
    return f"an {bare}" if bare[0] in "aeio" else f"a {bare}"


def listing(names: Iterable[str], conjunction: str = "and") -> str:
    """`a`, `b` and `c`."""
    quoted = [f"`{name}`" for name in names]
    if len(quoted) < 2:
        return "".join(quoted)
    return f"{', '.join(quoted[:-1])} {conjunction} {quoted[-1]}"
