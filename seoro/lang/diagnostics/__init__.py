"""Messages of the language front end, one file per phase; codes are stable.

Each message is a function: it fills the texts, and returns the `Diagnostic`. A bag calls it only if it takes the
message, as suggestions are slow to find. The folder imports `source`, `diagnostic` and the tables of `habits`.

The phases: `syntax` (E01), `imports` and `names` (E02), `types` and `methods` (E03), `behaviors`, `events` and
`modifiers` (E04), `coverage` (E05), `bindings` to Python (E06), `suspicious` (E07). Modules are
loaded on first use, as most scenarios cause no message.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from importlib import import_module
from types import ModuleType
from typing import Any, Final

_PHASES: Final = frozenset(
    {
        "syntax",
        "imports",
        "names",
        "types",
        "methods",
        "behaviors",
        "events",
        "modifiers",
        "coverage",
        "bindings",
        "suspicious",
    }
)
MAX_CANDIDATES = 500  # compared for a suggestion


def near(name: str, candidates: Iterable[str]) -> str:
    """Help that suggests the candidates nearest to `name`; empty without any."""
    from difflib import get_close_matches  # noqa: PLC0415 - slow to load, and seldom needed

    known = sorted(set(candidates))
    if len(known) > MAX_CANDIDATES:  # each is compared, letter by letter
        known = [candidate for candidate in known if candidate[:3] == name[:3]][:MAX_CANDIDATES]
    prefixed = [candidate for candidate in known if candidate.endswith(f"::{name}")]
    found = prefixed or get_close_matches(name, known, n=3, cutoff=0.6)
    return f"did you mean {listing(found, 'or')}?" if found else ""


def near_or_all(name: str, candidates: Collection[str], introduction: str) -> str:
    """Help that suggests the candidates nearest to `name`, else lists all; empty without any."""
    return near(name, candidates) or (f"{introduction} {listing(candidates)}" if candidates else "")


def with_article(name: str) -> str:
    """Put the article before a quoted type, as in `a length`; return other texts unchanged."""
    if not name.startswith("`"):
        return name
    bare = name.strip("`")
    return f"an {bare}" if bare[0] in "aeio" else f"a {bare}"


def listing(names: Iterable[str], conjunction: str = "and") -> str:
    """Quote and join names: `a`, `b` and `c`."""
    quoted = [f"`{name}`" for name in names]
    if len(quoted) < 2:
        return "".join(quoted)
    return f"{', '.join(quoted[:-1])} {conjunction} {quoted[-1]}"


class _Phase(ModuleType):
    """Proxy of a phase's module, which is loaded on first use."""

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self.__name__), name)


def __getattr__(name: str) -> ModuleType:
    if name in _PHASES:
        return _Phase(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
