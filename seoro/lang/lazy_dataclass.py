"""Dataclasses that are set up when their first instance is created, in any thread.

`@dataclass` compiles methods, which takes a third of a millisecond per class. A short scenario loads dozens of
such classes, and creates instances of half of them.
"""

from __future__ import annotations

import dataclasses
from threading import RLock
from typing import Any, Final, TypeVar, dataclass_transform

_Class = TypeVar("_Class", bound=type)
_PENDING: Final = "__pending_dataclass__"
_OF_THE_CLASS: Final = frozenset({"__dict__", "__weakref__", "__init__"})  # those of a copy are its own
_LOCK: Final = RLock()  # reentrant: a default may be an instance of such a class


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
    with _LOCK:
        for each in reversed(cls.__mro__):
            if vars(each).get(_PENDING):
                _make_dataclass(each)
                delattr(each, _PENDING)


def _make_dataclass(cls: Any) -> None:
    """Give a class what `dataclasses.dataclass` gives a copy of it, `__init__` last.

    `dataclass` replaces no `__init__`, and other threads must not find the class without one.
    """
    own = {name: value for name, value in vars(cls).items() if name not in _OF_THE_CLASS}
    copied = type(cls)(cls.__name__, cls.__bases__, dict(own))
    made = vars(dataclasses.dataclass(eq=False)(copied))
    for name, value in made.items():
        if name not in _OF_THE_CLASS and own.get(name, _PENDING) is not value:
            setattr(cls, name, value)
    for name in own.keys() - made.keys():  # fields with a factory
        delattr(cls, name)
    cls.__init__ = made["__init__"]
