"""Conversion of plain Python values of applications."""

from __future__ import annotations

from typing import Any

import pytest

from seoro.lang.plan import (
    ActorType,
    EnumType,
    EnumValue,
    ListType,
    PhysicalType,
    PrimitiveType,
    RangeType,
    Structures,
    ValueType,
)
from seoro.runtime.values.given import InvalidValue, given_value
from seoro.runtime.values.values import Actor, Range, plain

LENGTH = PhysicalType("length", "m", "m")
COLOR = EnumType("color", (("red", 0), ("green", 1)))
ROBOT = ActorType("robot", ("machine",), ())
ACTORS = {"r2": Actor(ROBOT, "r2"), "hal": Actor(ActorType("computer", (), ()), "hal")}


def given(value: object, type_: ValueType) -> Any:
    return given_value(value, type_, Structures(), ACTORS)


@pytest.mark.parametrize(
    ("value", "type_", "found"),
    [
        (True, PrimitiveType("bool"), True),
        ("x", PrimitiveType("string"), "x"),
        (-(2**63), PrimitiveType("int"), -(2**63)),
        (2**64 - 1, PrimitiveType("uint"), 2**64 - 1),
        (2, PrimitiveType("float"), 2.0),
        (2, LENGTH, 2.0),
        ("red", COLOR, EnumValue("color", "red", 0)),
        ("color!green", COLOR, EnumValue("color", "green", 1)),
        ([1, 2.5], ListType(LENGTH), (1.0, 2.5)),
        ({"low": 1, "high": 2}, RangeType(LENGTH), Range(1.0, 2.0)),
        ("r2", ROBOT, ACTORS["r2"]),
        ("r2", ActorType("machine", (), ()), ACTORS["r2"]),
    ],
)
def test_a_fitting_value_is_converted(value: object, type_: ValueType, found: object) -> None:
    converted = given(value, type_)
    assert (type(converted), converted) == (type(found), found)
    assert given(plain(converted), type_) == converted


@pytest.mark.parametrize(
    ("value", "type_", "expected"),
    [
        (1, PrimitiveType("bool"), "`True` or `False`, found 1"),
        (1, PrimitiveType("string"), "a string, found 1"),
        (1.0, PrimitiveType("int"), r"an integer \(`int`\), found 1.0"),
        (True, PrimitiveType("int"), "found True"),
        (2**63, PrimitiveType("int"), "found 9223372036854775808"),
        (-1, PrimitiveType("uint"), "found -1"),
        ("1m", LENGTH, r"a number in m \(`length`\), found '1m'"),
        (float("inf"), LENGTH, "that is finite, found inf"),
        (0, COLOR, "a member of `color`: red, green, found 0"),
        ("size!red", COLOR, "found 'size!red'"),
        ("abc", ListType(PrimitiveType("string")), "a list with elements of: a string, found 'abc'"),
        ([1, "2"], ListType(LENGTH), "a number in m"),
        ([1, 2], RangeType(LENGTH), "a mapping of `low` and `high`"),
        ("hal", ROBOT, r"the name of an actor `robot` \(actors: r2\), found 'hal'"),
        (None, ROBOT, "found None"),
    ],
)
def test_an_unfitting_value_is_refused(value: object, type_: ValueType, expected: str) -> None:
    with pytest.raises(InvalidValue, match=f"expected .*{expected}"):
        given(value, type_)
