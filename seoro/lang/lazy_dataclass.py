"""Dataclasses that are set up when their first instance is created.

`@dataclass` compiles methods, which takes a third of a millisecond per class. A short scenario loads dozens of
such classes, and creates instances of half of them.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Final, TypeVar, dataclass_transform

_Class = TypeVar("_Class", bound=type)
_PENDING: Final = "__pending_dataclass__"


@dataclass_transform(eq_default=False, field_specifiers=(dataclasses.field,))
def lazy_dataclass(cls: _Class) -> _Class:
    """Make a class a mutable dataclass, whose instances are equal only to themselves.

    Args:
        cls: The class, without slots. Its bases may be such classes, too.
    """

    def set_up(self: Any, *values: Any, **named: Any) -> None:
        _set_up(cls)
        cls.__init__(self, *values, **named)  # type: ignore[misc]  # just created

    setattr(cls, "__init__", set_up)  # noqa: B010 - to the type checker it is that of a dataclass
    setattr(cls, _PENDING, True)
    return cls


def _set_up(cls: type) -> None:
    """Turn a class into a dataclass, after its bases."""
    for each in reversed(cls.__mro__):
        if vars(each).get(_PENDING):
            delattr(each, _PENDING)
            delattr(each, "__init__")
            dataclasses.dataclass(eq=False)(each)
