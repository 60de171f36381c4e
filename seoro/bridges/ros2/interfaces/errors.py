"""What can be wrong with an interface, a value or a payload.

InvalidUse
|-- UnknownInterface    a name that no package defines
|-- InvalidDefinition   a .msg, .srv or .action file, or how it refers to others
`-- InvalidValue        a value that does not fit its interface; has the path of the member
BackendError
`-- InvalidPayload      what came from a robot is no message of the type that it should be
"""

from __future__ import annotations

from collections.abc import Iterable

from seoro.errors import BackendError, InvalidUse


class UnknownInterface(InvalidUse):
    """No package defines an interface of that name."""


class InvalidDefinition(InvalidUse):
    """A definition cannot be read, or refers to what there is not."""


class InvalidValue(InvalidUse):
    """A value does not fit its interface.

    Args:
        interface: The full name of the interface.
        path: The member at fault from the top, such as `poses[2].position.x`; empty for the whole value.
        problem: What was expected, and what was given.
        help: What would work.
    """

    def __init__(self, interface: str, path: str, problem: str, help: str = "") -> None:  # noqa: A002
        super().__init__(f"{interface}{f', `{path}`' if path else ''}: {problem}", help=help)
        self.interface = interface
        self.path = path


class InvalidPayload(BackendError):
    """A payload is no message of the type that it should be."""


def near(name: str, candidates: Iterable[str], likeness: float = 0.6) -> str:
    """A help text with the names that may have been meant; empty if none is as like as that (1: the same)."""
    from difflib import get_close_matches  # noqa: PLC0415 - slow to load, and only needed for errors

    known = sorted(set(candidates))
    bare = name.rpartition("/")[2].lower()
    same = [candidate for candidate in known if candidate.rpartition("/")[2].lower() == bare]
    found = (same or get_close_matches(name, known, n=3, cutoff=likeness))[:3]
    return f"did you mean {' or '.join(f'`{candidate}`' for candidate in found)}?" if found else ""
