"""Errors of interfaces, values and payloads.

UsageError
|-- UnknownInterface    no package defines the name
|-- InvalidDefinition   a .msg, .srv or .action file is invalid, or refers to an unknown structure
`-- InvalidValue        a value does not fit its interface; has the path of the member
BackendError
`-- InvalidPayload      a received payload is not a valid message of its type
"""

from __future__ import annotations

from collections.abc import Iterable

from seoro.errors import BackendError, UsageError


class UnknownInterface(UsageError):
    """No package defines an interface of that name."""


class InvalidDefinition(UsageError):
    """A definition is invalid, or refers to an unknown structure."""


class InvalidValue(UsageError):
    """A value does not fit its interface.

    Args:
        interface: Full name of the interface.
        path: Path of the invalid member, such as `poses[2].position.x`; empty for the whole value.
        problem: Expected and given value.
        help: Valid values.
    """

    def __init__(self, interface: str, path: str, problem: str, help: str = "") -> None:  # noqa: A002
        super().__init__(f"{interface}{f', `{path}`' if path else ''}: {problem}", help=help)
        self.interface = interface
        self.path = path


class InvalidPayload(BackendError):
    """A payload is not a valid message of its type."""


def near(name: str, candidates: Iterable[str], likeness: float = 0.6) -> str:
    """Return a help text with similar names; empty if none has the required likeness (1 for equal names)."""
    from difflib import get_close_matches  # noqa: PLC0415 - slow to load, and only needed for errors

    known = sorted(set(candidates))
    bare = name.rpartition("/")[2].lower()
    same = [candidate for candidate in known if candidate.rpartition("/")[2].lower() == bare]
    found = (same or get_close_matches(name, known, n=3, cutoff=likeness))[:3]
    return f"did you mean {' or '.join(f'`{candidate}`' for candidate in found)}?" if found else ""
