"""Frozen dataclasses that are cheap to define, for trees, messages and plans.

To type checkers and the functions of `dataclasses` (`fields`, `replace`, `is_dataclass`), subclasses of `Frozen`
and `Value` are frozen dataclasses with slots. The decorator `@dataclass` takes most of a millisecond per class, as
it compiles methods; for two hundred classes, that is longer than a short scenario takes. Here a class is only a
tuple of names, and the rest is created on demand.

Supported are defaults, `field(default_factory=...)`, `field(repr=False)` and inheritance. Annotations must be
strings, so modules with such classes need `from __future__ import annotations`.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from functools import cache
from itertools import repeat
from typing import TYPE_CHECKING, Any, ClassVar, Final, NoReturn, TypeAlias, TypeVar, dataclass_transform

_Init: TypeAlias = Callable[..., None]
_Setter: TypeAlias = Callable[[Any, Any], None]
_Made = TypeVar("_Made", bound="Frozen")


def _init_for_the_first_time(self: Any, *values: Any, **named: Any) -> None:
    """Give the class its own `__init__`, which sets slots without a loop, and call it.

    A file has tens of thousands of nodes and spans, and the loop took most of the time.
    """
    cls: Any = type(self)
    setters = [getattr(cls, name).__set__ for name in cls.__match_args__]
    make: Callable[..., _Init] = _INITS.get(len(setters), _init_of_many)
    init = make(cls, *setters)
    setattr(cls, "__init__", init)  # noqa: B010 - to the type checker it is that of a dataclass
    init(self, *values, **named)


def _init_of_one(cls: Any, a: _Setter) -> _Init:
    def init(self: Any, *values: Any, **named: Any) -> None:
        if named or len(values) != 1:
            values = _arguments(cls, values, named)
        a(self, values[0])

    return init


def _init_of_two(cls: Any, a: _Setter, b: _Setter) -> _Init:
    def init(self: Any, *values: Any, **named: Any) -> None:
        if named or len(values) != 2:
            values = _arguments(cls, values, named)
        one, two = values
        a(self, one)
        b(self, two)

    return init


def _init_of_three(cls: Any, a: _Setter, b: _Setter, c: _Setter) -> _Init:
    def init(self: Any, *values: Any, **named: Any) -> None:
        if named or len(values) != 3:
            values = _arguments(cls, values, named)
        one, two, three = values
        a(self, one)
        b(self, two)
        c(self, three)

    return init


def _init_of_four(cls: Any, a: _Setter, b: _Setter, c: _Setter, d: _Setter) -> _Init:
    def init(self: Any, *values: Any, **named: Any) -> None:
        if named or len(values) != 4:
            values = _arguments(cls, values, named)
        one, two, three, four = values
        a(self, one)
        b(self, two)
        c(self, three)
        d(self, four)

    return init


def _init_of_many(cls: Any, *setters: _Setter) -> _Init:
    count = len(setters)

    def init(self: Any, *values: Any, **named: Any) -> None:
        if named or len(values) != count:
            values = _arguments(cls, values, named)
        for setter, value in zip(setters, values):  # noqa: B905 - their lengths were compared
            setter(self, value)

    return init


_INITS: Final[dict[int, Callable[..., _Init]]] = {
    1: _init_of_one,
    2: _init_of_two,
    3: _init_of_three,
    4: _init_of_four,
}


class _Frozen(type):
    """Turns the annotations of a class into slots, and their values into defaults."""

    def __new__(mcs, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> _Frozen:
        inherited: dict[str, None] = {}
        defaults: dict[str, Any] = {}
        for base in reversed(bases):
            inherited |= dict.fromkeys(getattr(base, "__match_args__", ()))
            defaults |= getattr(base, "__field_defaults__", {})
        own = [
            field
            for field, annotation in namespace.get("__annotations__", {}).items()
            if not annotation.startswith("ClassVar")
        ]
        defaults |= {field: namespace.pop(field) for field in own if field in namespace}
        namespace["__slots__"] = tuple(field for field in own if field not in inherited)
        namespace["__match_args__"] = (*inherited, *namespace["__slots__"])
        namespace["__field_defaults__"] = defaults
        namespace.setdefault("__init__", _init_for_the_first_time)
        return super().__new__(mcs, name, bases, namespace)


class _OnDemand:
    """A class attribute that `@dataclass` would set, created on demand."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: object, owner: type) -> Any:
        return getattr(_decorated(owner), self._name)


@cache
def _decorated(cls: type[Frozen]) -> type:
    """Create a real dataclass with the fields of a class.

    Raises:
        TypeError: A field has an unsupported option.
        ValueError: A default is mutable.
    """
    annotations: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        annotations |= inspect.get_annotations(base)
    specifications: list[tuple[str, str] | tuple[str, str, Any]] = []
    for name in cls.__match_args__:
        if name not in cls.__field_defaults__:
            specifications.append((name, annotations[name]))
            continue
        default = cls.__field_defaults__[name]
        if isinstance(default, dataclasses.Field):
            if not default.init or not default.compare or default.hash is not None or default.kw_only is True:
                raise TypeError(
                    f"{cls.__name__}.{name}: `field` supports only default, default_factory and repr here"
                )
            default = dataclasses.field(  # a copy, since a field belongs to one class
                default=default.default, default_factory=default.default_factory, repr=default.repr
            )
        specifications.append((name, annotations[name], default))
    return dataclasses.make_dataclass(cls.__name__, specifications, frozen=True, eq=issubclass(cls, Value))


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(dataclasses.field,))
class Frozen(metaclass=_Frozen):
    """A frozen dataclass whose instances are equal only to themselves."""

    __match_args__: ClassVar[tuple[str, ...]]
    __field_defaults__: ClassVar[dict[str, Any]]
    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]] = _OnDemand()  # type: ignore[assignment]
    __dataclass_params__: ClassVar[Any] = _OnDemand()

    if TYPE_CHECKING:

        def __init__(self, *values: Any, **named: Any) -> None: ...

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r} of {type(self).__name__}")

    def __delattr__(self, name: str) -> NoReturn:
        raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r} of {type(self).__name__}")

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        """Support `copy`, which would assign to fields."""
        return type(self), _values(self)

    def __repr__(self) -> str:
        """Return the fields, without spans, which are long and uninformative."""
        shown = (field.name for field in dataclasses.fields(self) if field.repr and field.name != "span")
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in shown)})"


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
class Value(Frozen):
    """A frozen dataclass whose instances are equal if their fields are, and hashed by them."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return _values(self) == _values(other)

    def __hash__(self) -> int:
        return hash(_values(self))


def replaced(value: _Made, /, **fields: Any) -> _Made:
    """Copy a value with other fields, as `dataclasses.replace` without setting up a dataclass first.

    Raises:
        TypeError: A field is unknown.
    """
    kept = {name: getattr(value, name) for name in value.__match_args__}
    return type(value)(**kept | fields)


def _values(made: Any) -> tuple[Any, ...]:
    """Return the fields of an instance, in order."""
    return tuple(map(getattr, repeat(made), made.__match_args__))


def _arguments(cls: type[Frozen], values: tuple[Any, ...], named: dict[str, Any]) -> tuple[Any, ...]:
    """Return the values of all fields, from positional and named arguments and defaults.

    Raises:
        TypeError: A field is missing, duplicate or unknown.
    """
    names, defaults = cls.__match_args__, cls.__field_defaults__
    found, used = list(values), 0
    for name in names[len(values) :]:
        if name in named:
            found.append(named[name])
            used += 1
        elif name in defaults:
            found.append(_default(defaults[name]))
        else:
            raise TypeError(f"{cls.__name__}: missing field {name!r}")
    if used < len(named):
        wrong = next(name for name in named if name not in names[len(values) :])
        raise TypeError(f"{cls.__name__}: {'duplicate' if wrong in names else 'unknown'} field {wrong!r}")
    if len(found) > len(names):
        raise TypeError(f"{cls.__name__} has {len(names)} fields, but got {len(values)} values")
    return tuple(found)


def _default(default: Any) -> Any:
    """Return the default of a field."""
    if not isinstance(default, dataclasses.Field):
        return default
    return default.default if default.default_factory is dataclasses.MISSING else default.default_factory()
