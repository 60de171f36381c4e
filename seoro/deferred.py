"""Dataclasses whose methods are compiled for their first instance.

`dataclasses.dataclass` compiles up to six methods for each class. A process such as a simulator node loads
hundreds of classes at its start, and makes instances of a third of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from threading import RLock
from typing import TYPE_CHECKING, Any, Final

_LOCK: Final = RLock()
_CREATED: Final = ("__dataclass_fields__", "__dataclass_params__")  # class attributes that functions ask for

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
        self._cls, self._frozen, self._eq, self._kw_only = cls, frozen, eq, kw_only
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
        cls, frozen = self._cls, self._frozen
        for name, value in self._defaults.items():
            setattr(cls, name, value)
        dataclasses.dataclass(init=False, frozen=frozen, eq=self._eq, kw_only=self._kw_only)(cls)
        # `dataclass` replaces no methods, and other threads must not find the class without `__init__`.
        heir = type(cls)(cls.__name__, (cls,), {"__module__": cls.__module__})
        cls.__init__ = dataclasses.dataclass(frozen=frozen, repr=False, eq=False)(heir).__init__


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
