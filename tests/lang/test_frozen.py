"""Frozen dataclasses that are cheap to define."""

from __future__ import annotations

import copy
import dataclasses
from dataclasses import field, fields, is_dataclass, replace
from typing import Any, ClassVar

import pytest

from seoro.lang import ast
from seoro.lang.frozen import Frozen, Value, replaced


class Point(Value):
    x: float
    y: float = 0.0
    tags: list[str] = field(default_factory=list, repr=False)
    origin: ClassVar[str] = "map"


class Named(Point):
    name: str = "a"


class Node(Frozen):
    value: int
    span: str


def nodes() -> list[type[Frozen]]:
    """Return the classes of the syntax tree."""
    return [found for found in vars(ast).values() if isinstance(found, type) and issubclass(found, ast.Node)]


def made(cls: type[Frozen]) -> Any:
    """Return an instance with arbitrary values."""
    return cls(*range(len(fields(cls))))


def test_nodes_are_frozen_dataclasses() -> None:
    assert nodes()
    for cls in nodes():
        node = made(cls)
        assert is_dataclass(cls)
        assert cls.__dataclass_params__.frozen
        for number, each in enumerate(fields(cls)):
            assert getattr(node, each.name) == number
            with pytest.raises(dataclasses.FrozenInstanceError, match=each.name):
                setattr(node, each.name, None)
            with pytest.raises(dataclasses.FrozenInstanceError, match=each.name):
                delattr(node, each.name)
        assert dataclasses.astuple(replace(node)) == dataclasses.astuple(node)


def test_fields_are_given_by_position_or_by_name_or_have_defaults() -> None:
    assert (Point(1.0, 2.0).x, Point(1.0, 2.0).y) == (1.0, 2.0)
    assert Point(y=2.0, x=1.0) == Point(1.0, 2.0)
    assert Point(1.0).y == 0.0
    assert Point(1.0).tags == []
    assert Point(1.0).tags is not Point(1.0).tags
    assert Point.origin == "map"


@pytest.mark.parametrize(
    ("values", "named", "fault"),
    [
        ((), {}, "Point: missing field 'x'"),
        ((1, 2, [], 4), {}, "Point has 3 fields, but got 4 values"),
        ((1,), {"x": 2}, "Point: duplicate field 'x'"),
        ((1,), {"z": 2}, "Point: unknown field 'z'"),
    ],
)
def test_invalid_arguments_raise(values: tuple[Any, ...], named: dict[str, Any], fault: str) -> None:
    with pytest.raises(TypeError, match=fault):
        Point(*values, **named)


def test_fields_are_inherited_in_order() -> None:
    assert [each.name for each in fields(Named)] == ["x", "y", "tags", "name"]
    assert Named(1.0, name="b").name == "b"
    assert fields(Named)[3].default == "a"
    assert fields(Named)[2].default_factory is list
    assert fields(Point)[0].type == "float"


def test_values_are_equal_by_their_fields_and_can_be_keys() -> None:
    assert Point(1.0, 2.0) == Point(1.0, 2.0)
    assert Point(1.0, 2.0) != Point(2.0, 2.0)
    assert Point(1.0) != Named(1.0)

    class Key(Value):
        name: str
        number: int

    assert {Key("a", 1): "found"}[Key("a", 1)] == "found"
    assert Point.__dataclass_params__.eq


def test_nodes_are_equal_to_themselves_only() -> None:
    node = Node(1, "here")
    assert node == node
    assert node != Node(1, "here")
    assert len({node, Node(1, "here")}) == 2
    assert not Node.__dataclass_params__.eq


def test_frozen_classes_match_by_position_and_are_copied() -> None:
    match Node(7, "here"):
        case Node(value, span):
            assert (value, span) == (7, "here")
    assert repr(Node(7, "here")) == "Node(value=7)"
    assert repr(Point(1.0)) == "Point(x=1.0, y=0.0)"
    assert replace(Point(1.0), y=3.0) == Point(1.0, 3.0)
    assert copy.copy(Point(1.0, 2.0)) == copy.deepcopy(Point(1.0, 2.0)) == Point(1.0, 2.0)
    assert dataclasses.asdict(Node(7, "here")) == {"value": 7, "span": "here"}


def test_instances_have_slots_only() -> None:
    assert not hasattr(Named(1.0), "__dict__")


def test_unsupported_field_options_are_refused() -> None:
    class Odd(Value):
        x: int = field(default=1, compare=False)

    with pytest.raises(TypeError, match=r"Odd\.x"):
        fields(Odd)


def test_replaced_changes_the_given_fields_only() -> None:
    node = Node(1, "a")
    assert replaced(node, value=2).value == 2
    assert replaced(node, value=2).span == "a"
    with pytest.raises(TypeError):
        replaced(node, unknown=2)
