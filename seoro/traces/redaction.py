"""Removal of names, hosts, paths and chosen fields from traces, before they are shared.

The same text gets the same replacement everywhere, so that records still refer to one another. Numbers and the
order of records stay.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final

Record = dict[str, Any]

REDACTED: Final = "[redacted]"
# Fields that are needed to read a record.
KEPT: Final = frozenset({"seq", "t", "kind"})
# Folders of files on common systems; other texts that begin with `/` may be names of topics.
_ROOTS: Final = "home|root|Users|tmp|var|opt|mnt|media|srv|usr|etc|data|run|work|workspace|private|nix"
_PART: Final = r"[^\s/:;,\"'`()<>\[\]{}]+"
_HOME: Final = re.compile(rf"(?:file://)?/(?:home|Users)/({_PART})")
_PATH: Final = re.compile(rf"(?:file://)?(?<![\w.-])/(?:{_ROOTS})/(?:{_PART}/)*(?:{_PART})?")
_ADDRESS: Final = re.compile(r"\b[A-Za-z0-9][\w.+-]*@[A-Za-z0-9][\w.-]*\b")
_ENDPOINT: Final = re.compile(r"\b(tcp|udp|tls|quic|ws|wss|http|https)(/|://)(\[[0-9A-Fa-f:.%\w]+\]|[\w.-]+)")
_IPV4: Final = re.compile(r"\b(?:\d{1,3}\.){3}\d{1,3}\b")
_LOCAL: Final = frozenset({"localhost", "127.0.0.1", "0.0.0.0", "[::1]", "[::]"})  # noqa: S104 - compared only


class Redactor:
    """Redacts the records of one trace.

    Args:
        names: Further words to replace, such as names of robots or people.
        dropped: Fields to remove: `FIELD` of all records, `KIND:FIELD` or `KIND:FIELD.FIELD` of one kind.

    Attributes:
        counts: Number of replacements by kind of text.

    Raises:
        ValueError: A field cannot be removed.
    """

    def __init__(self, names: Sequence[str] = (), dropped: Sequence[str] = ()) -> None:
        self._dropped = [_field(text) for text in dropped]
        self._replacements: dict[tuple[str, str], str] = {}
        self._users: set[str] = set()
        words = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True) if name)
        self._names = re.compile(rf"(?<!\w)(?:{words})(?!\w)") if words else None
        self.counts: Counter[str] = Counter()

    def redact(self, record: Record) -> Record:
        """Return a record without texts that identify people, machines and places, and without chosen fields."""
        redacted: Record = {name: value if name in KEPT else self._value(value) for name, value in record.items()}
        for source in redacted.get("sources") or ():
            if isinstance(source, dict) and isinstance(source.get("text"), str):
                source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()
        for kind, (*outer, field) in self._dropped:
            if kind in ("", record["kind"]):
                self._drop(redacted, outer, field)
        return redacted

    def _drop(self, record: Record, outer: Sequence[str], field: str) -> None:
        """Replace a text, or remove another value; `outer` leads to it, through all items of lists."""
        holders: list[Any] = [record]
        for name in outer:
            inside = [each.get(name) for each in holders if isinstance(each, dict)]
            holders = [part for each in inside for part in (each if isinstance(each, list) else [each])]
        for holder in holders:
            if isinstance(holder, dict) and field in holder:
                self.counts["fields"] += 1
                if isinstance(holder[field], str):
                    holder[field] = REDACTED
                else:
                    del holder[field]

    def _value(self, value: Any) -> Any:
        match value:
            case str():
                return self._text(value)
            case list():
                return [self._value(part) for part in value]
            case dict():
                return {self._text(name): self._value(part) for name, part in value.items()}
            case _:
                return value

    def _text(self, text: str) -> str:
        for user in _HOME.findall(text) if "/" in text else ():
            self._users.add(user)
        if "@" in text:
            text = _ADDRESS.sub(partial(self._replaced, "addresses", "address", lambda found: found[0]), text)
        if "/" in text:
            text = _ENDPOINT.sub(self._endpoint, text)
            text = _PATH.sub(self._path, text)
        text = _IPV4.sub(partial(self._replaced, "hosts", "host", lambda found: found[0]), text)
        if self._names is not None:
            text = self._names.sub(partial(self._replaced, "names", "name", lambda found: found[0]), text)
        for user in self._users:
            whole = rf"(?<!\w){re.escape(user)}(?!\w)"
            text = re.sub(whole, partial(self._replaced, "users", "user", lambda found: found[0]), text)
        return text

    def _path(self, found: re.Match[str]) -> str:
        self.counts["paths"] += 1
        return found[0].rstrip("/").rpartition("/")[2]

    def _endpoint(self, found: re.Match[str]) -> str:
        if found[3] in _LOCAL:
            return found[0]
        return f"{found[1]}{found[2]}{self._name('hosts', 'host', found[3])}"

    def _replaced(self, kind: str, word: str, read: Callable[[re.Match[str]], str], found: re.Match[str]) -> str:
        text = read(found)
        return text if text in _LOCAL else self._name(kind, word, text)

    def _name(self, kind: str, word: str, text: str) -> str:
        """Return the replacement of a text, the same each time."""
        self.counts[kind] += 1
        number = sum(key[0] == word for key in self._replacements) + 1
        return self._replacements.setdefault((word, text), f"{word}-{number}")


def _field(text: str) -> tuple[str, tuple[str, ...]]:
    """Parse a field to remove; return the kind of its records, and the names that lead to it.

    Raises:
        ValueError: The field is invalid.
    """
    kind, colon, path = text.rpartition(":")
    names = tuple(path.split("."))
    if not all(names) or (colon and not kind) or names[0] in KEPT:
        needed = ", ".join(f"`{name}`" for name in sorted(KEPT))
        raise ValueError(f"invalid field '{text}'; expected FIELD or KIND:FIELD.FIELD, and none of {needed}")
    return kind, names


def count_text(counts: Mapping[str, int]) -> str:
    """Describe the numbers of replacements, such as `3 paths, 1 hosts`."""
    return ", ".join(f"{number} {kind}" for kind, number in sorted(counts.items())) or "nothing"
