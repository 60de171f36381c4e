"""Conversion between values of the language and Python values, by their types.

| declared                 | annotation of a parameter                                                      |
|--------------------------|--------------------------------------------------------------------------------|
| `bool`, `string`         | `bool`, `str`                                                                  |
| `int`, `uint`            | `int`, or `float`                                                              |
| `float`, physical types  | `float`; physical values in the SI base unit                                   |
| enumerations             | `EnumValue`, or an `Enum` whose members have the same names                    |
| structs                  | `Struct`, or a dataclass or pydantic model with matching fields                |
| actors                   | `Actor`                                                                        |
| `list of T`              | `list`, `tuple[..., ...]`, `Sequence` and similar, with a match for T          |
| `range of T`             | `Range`                                                                        |
| a variable itself        | `Variable[float]` for a numeric one, otherwise `Variable[object]`              |
| any type                 | `object`, `Any`; `X | None` and other unions with a matching part              |

Results of functions are converted by the same table, from right to left.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from numbers import Integral, Real
from typing import Annotated, Any, TypeAlias, TypeVar, Union, assert_never, get_args, get_origin, get_type_hints

from seoro.lang import plan
from seoro.runtime.values.values import INTEGER_LIMITS, Actor, Range, Struct, Value, Variable

Converter: TypeAlias = Callable[[Value], Any]
Shapes: TypeAlias = Callable[[str], Mapping[str, plan.ValueType]]
"""Returns the types of a struct's fields for its name in the plan."""

_PRIMITIVES: Mapping[str, type[Any]] = {"bool": bool, "int": int, "uint": int, "float": float, "string": str}
_LISTS = (list, tuple, Sequence, Collection, Iterable)


class Fitting:
    """Matches declared types with annotations, for the structs of one scenario.

    Args:
        shapes: Returns the types of a struct's fields.
    """

    def __init__(self, shapes: Shapes) -> None:
        self._shapes = shapes
        self._records: dict[tuple[str, type[Any]], _Record | None] = {}

    # ------------------------------------------------------------ to Python

    def converter(self, declared: plan.ValueType, hint: Any) -> Converter | None:
        """Return the converter from a declared type to an annotation; None if they do not match."""
        hint = _bare(hint)
        if _takes_anything(hint) or (get_origin(hint) or hint) is Variable:
            return _same
        if get_origin(hint) in (Union, types.UnionType):
            parts = (self.converter(declared, part) for part in get_args(hint))
            return next((part for part in parts if part is not None), None)
        match declared:
            case plan.PrimitiveType("int" | "uint") if hint is float:
                return _to_float
            case plan.PrimitiveType(name):
                return _same if _is_class_of(_PRIMITIVES[name], hint) else None
            case plan.PhysicalType():
                return _same if _is_class_of(float, hint) else None
            case plan.EnumType():
                return _enum_converter(declared, hint)
            case plan.ActorType():
                return _same if hint is Actor else None
            case plan.RangeType():
                return _same if hint is Range else None
            case plan.StructType():
                return _same if hint is Struct else self._record(declared, hint)
            case plan.ListType(element):
                return self._list_converter(element, hint)
            case _:
                assert_never(declared)

    def _list_converter(self, element: plan.ValueType, hint: Any) -> Converter | None:
        kind = get_origin(hint) or hint
        if kind not in _LISTS:
            return None
        item = self.converter(element, _element_of(hint))
        if item is None:
            return None
        make = tuple if kind is tuple else list
        return lambda value: make(item(part) for part in value)  # type: ignore[union-attr] # a list

    def _record(self, declared: plan.StructType, hint: Any) -> _Record | None:
        """Return the converter to a class for a struct; structs may contain themselves in lists."""
        members = members_of(hint)
        key = (declared.name, hint)
        if members is None or members.keys() != set(declared.fields):
            return None
        if key in self._records:
            return self._records[key]
        record = self._records[key] = _Record(hint)
        shape = self._shapes(declared.name)
        for name, member in members.items():
            converter = self.converter(shape[name], member)
            if converter is None:
                self._records[key] = None
                return None
            record.converters[name] = converter
        return record

    # ------------------------------------------------------------ from Python

    def gives(self, hint: Any, declared: plan.ValueType) -> bool:
        """Whether values of an annotated type can be values of the declared type."""
        hint = _bare(hint)
        if _takes_anything(hint):
            return True
        if get_origin(hint) in (Union, types.UnionType):
            return any(self.gives(part, declared) for part in get_args(hint) if part is not type(None))
        match declared:
            case plan.PrimitiveType("bool" | "string" as name):
                return _is_subclass(hint, _PRIMITIVES[name])
            case plan.PrimitiveType("float") | plan.PhysicalType():
                return _is_subclass(hint, Real) and hint is not bool
            case plan.PrimitiveType():
                return _is_subclass(hint, Integral) and hint is not bool
            case plan.EnumType():
                return _enum_converter(declared, hint) is not None
            case plan.ActorType():
                return hint is Actor
            case plan.RangeType():
                return hint is Range
            case plan.StructType():
                return hint is Struct or self._record_gives(hint, declared)
            case plan.ListType(element):
                kind = get_origin(hint) or hint
                return kind in (list, tuple, Sequence) and self.gives(_element_of(hint), element)
            case _:
                assert_never(declared)

    def _record_gives(self, hint: Any, declared: plan.StructType) -> bool:
        members = members_of(hint)
        if members is None or not members.keys() >= set(declared.fields):
            return False
        shape = self._shapes(declared.name)
        plain = (
            name for name in declared.fields if not isinstance(shape[name], plan.ListType)
        )  # ends the recursion
        return all(self.gives(members[name], shape[name]) for name in plain)

    def value(self, result: object, declared: plan.ValueType) -> Value | None:
        """Convert the result of a Python function to the declared type; None if the types differ."""
        match declared:
            case plan.PrimitiveType() | plan.PhysicalType():
                return scalar(result, declared)
            case plan.EnumType():
                return _enum_value(result, declared)
            case plan.ListType(element):
                return self._list(result, element)
            case plan.RangeType(element):
                return self._range(result, element)
            case plan.ActorType(name):
                return result if isinstance(result, Actor) and name in result.types else None
            case plan.StructType():
                return self._struct(result, declared)
            case _:
                assert_never(declared)

    def _list(self, result: object, element: plan.ValueType) -> Value | None:
        if not isinstance(result, list | tuple):
            return None
        items = [self.value(item, element) for item in result]
        return None if any(item is None for item in items) else tuple(item for item in items if item is not None)

    def _range(self, result: object, element: plan.ValueType) -> Value | None:
        if not isinstance(result, Range):
            return None
        bounds = (self.value(result.low, element), self.value(result.high, element))
        return None if None in bounds else result

    def _struct(self, result: object, declared: plan.StructType) -> Value | None:
        if isinstance(result, Struct):
            return result if declared.name in result.types else None
        if members_of(type(result)) is None:
            return None
        made = Struct(declared)
        for name, type_ in self._shapes(declared.name).items():
            value = self.value(getattr(result, name, None), type_)
            if value is None:
                return None
            made.fields[name] = value
        return made


def scalar(result: object, declared: plan.PrimitiveType | plan.PhysicalType) -> bool | str | float | None:
    """Convert a Python value to a boolean, a string or a number; None if the types differ."""
    match declared:
        case plan.PrimitiveType("bool"):
            return result if isinstance(result, bool) else None
        case plan.PrimitiveType("string"):
            return str(result) if isinstance(result, str) else None
        case plan.PrimitiveType("float") | plan.PhysicalType():
            return float(result) if isinstance(result, Real) and not isinstance(result, bool) else None
        case plan.PrimitiveType(name):
            low, high = INTEGER_LIMITS[name]
            is_integer = isinstance(result, Integral) and not isinstance(result, bool)
            return int(result) if is_integer and low <= result <= high else None  # type: ignore[operator,call-overload]


class _Record:
    """Converter from a struct to an instance of a class.

    Args:
        kind: A dataclass or a pydantic model.
    """

    def __init__(self, kind: type[Any]) -> None:
        self.kind = kind
        self.converters: dict[str, Converter] = {}

    def __call__(self, value: Value) -> Any:
        assert isinstance(value, Struct)
        return self.kind(**{name: convert(value.fields[name]) for name, convert in self.converters.items()})


def members_of(kind: Any) -> Mapping[str, Any] | None:
    """The fields of a dataclass or a pydantic model, with their annotations; None for anything else.

    Raises:
        NameError: An annotation cannot be evaluated.
    """
    if not isinstance(kind, type):
        return None
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        return {field.name: hints[field.name] for field in fields(kind) if field.init}
    models = getattr(kind, "model_fields", None)
    return {name: model.annotation for name, model in models.items()} if isinstance(models, dict) else None


def annotation_for(declared: plan.ValueType) -> str:
    """Return the annotation for a declared type, for messages."""
    match declared:
        case plan.PrimitiveType(name):
            return _PRIMITIVES[name].__name__
        case plan.PhysicalType():
            return "float"
        case plan.EnumType():
            return "EnumValue"
        case plan.ActorType():
            return "Actor"
        case plan.RangeType():
            return "Range"
        case plan.StructType():
            return "Struct"
        case plan.ListType(element):
            return f"list[{annotation_for(element)}]"
        case _:
            assert_never(declared)


def _to_float(value: Value) -> Any:
    return float(value)  # type: ignore[arg-type] # an integer


def _same(value: Value) -> Any:
    return value


def _bare(hint: Any) -> Any:
    """Return the type within `Annotated`."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def _takes_anything(hint: Any) -> bool:
    return hint is object or hint is Any or isinstance(hint, TypeVar)


def _is_class_of(kind: type[Any], hint: Any) -> bool:
    """Whether instances of a class match an annotation; here `bool` is not a subclass of `int`."""
    return kind is hint if kind is bool else _is_subclass(kind, hint)


def _is_subclass(kind: Any, base: Any) -> bool:
    try:
        return issubclass(kind, base)
    except TypeError:  # not a class, or a protocol that is not runtime-checkable
        return False


def _element_of(hint: Any) -> Any:
    """Return the annotation of a list's elements; `tuple[T, ...]` is a list, `tuple[T, T]` is not."""
    arguments = get_args(hint)
    if get_origin(hint) is tuple and arguments[1:] != (...,):
        return None
    return arguments[0] if arguments else object


def _enum_converter(declared: plan.EnumType, hint: Any) -> Converter | None:
    if hint is plan.EnumValue:
        return _same
    if not _is_subclass(hint, Enum) or hint.__members__.keys() != {name for name, _ in declared.members}:
        return None
    return lambda value: hint[value.member]  # type: ignore[union-attr] # an enumeration member


def _enum_value(result: object, declared: plan.EnumType) -> Value | None:
    if isinstance(result, plan.EnumValue):
        return result if result.type_name == declared.name else None
    numbers = dict(declared.members)
    if not isinstance(result, Enum) or result.name not in numbers:
        return None
    return plan.EnumValue(declared.name, result.name, numbers[result.name])
