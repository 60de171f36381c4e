"""Dataclasses whose methods are compiled for their first instance.

`dataclasses.dataclass` compiles up to six methods for each class. A process such as a simulator node loads
hundreds of classes at its start, and makes instances of a third of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping
from threading import RLock
from typing import TYPE_CHECKING, Any, Final

_LOCK: Final = RLock()
_CREATED: Final = ("__dataclass_fields__", "__dataclass_params__")  # class attributes that functions ask for
_NOT_COPIED: Final = frozenset({*_CREATED, "__dict__", "__weakref__", "__init__", "__signature__"})
_NOT_TAKEN: Final = frozenset({"__dict__", "__weakref__", "__init__", "__setattr__", "__delattr__"})  # from a copy

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass  # noqa: PLC0414 - re-exported
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True, kw_only=False):
        """Make a class a dataclass when its first instance is made, or its fields are needed.

        From then on it is that of `dataclasses.dataclass` with the same options. Mistakes such as a mutable
        default are found then, too. The class has no `__init__` of its own.
        """

        def defer(cls):
            defaults = {name: value for name, value in vars(cls).items() if _has_default(value)}
            complete = _Completion(cls, defaults, frozen=frozen, eq=eq, kw_only=kw_only)
            for name in (*_CREATED, *defaults):
                setattr(cls, name, _OnDemand(cls, name, complete))
            cls.__signature__ = _BeforeSignature(complete)
            cls.__init__ = _first_init(cls, complete)
            return cls

        return defer if cls is None else defer(cls)


def _has_default(value: object) -> bool:
    return isinstance(value, dataclasses.Field) and value.default is not dataclasses.MISSING


def _first_init(cls: Any, complete: Callable[[], None]) -> Callable[..., None]:
    """Return an `__init__` that completes its class, and then is that of the class."""

    def init(self: object, /, *values: object, **named: object) -> None:
        complete()
        cls.__init__(self, *values, **named)

    return init


class _Completion:
    """Makes a class a dataclass when it is first called, from any thread."""

    def __init__(self, cls: Any, defaults: Mapping[str, Any], *, frozen: bool, eq: bool, kw_only: bool) -> None:
        self._cls, self._options = cls, {"frozen": frozen, "eq": eq, "kw_only": kw_only}
        self._defaults = defaults  # fields with a default, which are class attributes afterwards
        self._has_begun = False  # `dataclass` asks for the signature of the class meanwhile

    def __call__(self) -> None:
        with _LOCK:
            if self._has_begun:
                return
            self._has_begun = True
            try:
                self._complete()
            except BaseException:
                self._has_begun = False
                raise

    def _complete(self) -> None:
        """Give the class what `dataclasses.dataclass` gives a copy of it, `__init__` last.

        `dataclass` replaces no `__init__`, and other threads must not find the class without one.
        """
        cls: Any = self._cls
        present = vars(cls)
        own = {**{name: present[name] for name in present.keys() - _NOT_COPIED}, **self._defaults}
        copied = type(cls)(cls.__name__, cls.__bases__, dict(own))
        made = vars(dataclasses.dataclass(**self._options)(copied))
        if self._options["frozen"]:
            cls.__setattr__, cls.__delattr__ = _refusals(cls, made["__dataclass_fields__"].keys())
        for name in made.keys() - _NOT_TAKEN:
            if present.get(name) is not made[name]:
                setattr(cls, name, made[name])
        for name in own.keys() - made.keys():  # fields with a factory
            delattr(cls, name)
        cls.__init__ = made["__init__"]


def _refusals(cls: Any, fields: Collection[str]) -> tuple[Callable[..., None], Callable[..., None]]:
    """Return `__setattr__` and `__delattr__` of a frozen class; those of a copy would refer to that copy."""

    def refuse_to_set(self: object, name: str, value: object) -> None:
        if type(self) is cls or name in fields:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def refuse_to_delete(self: object, name: str) -> None:
        if type(self) is cls or name in fields:
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    return refuse_to_set, refuse_to_delete


class _BeforeSignature:
    """Completes a class before `inspect.signature` reads its `__init__`, as checks of actions do.

    It stands for a missing `__signature__`, for which `inspect` asks first.
    """

    def __init__(self, complete: Callable[[], None]) -> None:
        self._complete = complete

    def __get__(self, instance: object, owner: type) -> Any:
        self._complete()
        raise AttributeError("__signature__")


class _OnDemand:
    """A class attribute that `dataclasses.dataclass` sets."""

    def __init__(self, cls: type, name: str, complete: Callable[[], None]) -> None:
        self._cls, self._name, self._complete = cls, name, complete

    def __get__(self, instance: object, owner: type) -> Any:
        self._complete()
        return self._cls.__dict__[self._name]
