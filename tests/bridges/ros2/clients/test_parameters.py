"""Values of parameters of nodes, as texts."""

from typing import Any

import pytest

from seoro.bridges.ros2.clients.parameters import (
    BOOL,
    BOOL_ARRAY,
    BYTE_ARRAY,
    DOUBLE,
    DOUBLE_ARRAY,
    INTEGER,
    INTEGER_ARRAY,
    NOT_SET,
    STRING,
    STRING_ARRAY,
    read_parameter,
)
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.errors import UsageError


@pytest.mark.parametrize(
    ("text", "known", "kind", "member", "value"),
    [
        ("true", NOT_SET, BOOL, "bool_value", True),
        ("7", NOT_SET, INTEGER, "integer_value", 7),
        ("7", DOUBLE, DOUBLE, "double_value", 7.0),
        ("1e-05", DOUBLE, DOUBLE, "double_value", 1e-05),
        ("1e5", STRING, STRING, "string_value", "1e5"),
        ("0.5", NOT_SET, DOUBLE, "double_value", 0.5),
        ("0.5", INTEGER, DOUBLE, "double_value", 0.5),
        ("hello", NOT_SET, STRING, "string_value", "hello"),
        ("'7'", NOT_SET, STRING, "string_value", "7"),
        ("7", STRING, STRING, "string_value", "7"),
        ("[1", NOT_SET, STRING, "string_value", "[1"),
        ("", NOT_SET, STRING, "string_value", ""),
        ("[true, false]", NOT_SET, BOOL_ARRAY, "bool_array_value", [True, False]),
        ("[1, 2]", NOT_SET, INTEGER_ARRAY, "integer_array_value", [1, 2]),
        ("[1, 2]", DOUBLE_ARRAY, DOUBLE_ARRAY, "double_array_value", [1.0, 2.0]),
        ("[1, 2.5]", NOT_SET, DOUBLE_ARRAY, "double_array_value", [1.0, 2.5]),
        ("[a, b]", NOT_SET, STRING_ARRAY, "string_array_value", ["a", "b"]),
        ("[1, 2]", BYTE_ARRAY, BYTE_ARRAY, "byte_array_value", [1, 2]),
        ("[]", DOUBLE_ARRAY, DOUBLE_ARRAY, "double_array_value", []),
    ],
)
def test_parameter_texts_have_the_known_or_apparent_type(
    text: str, known: int, kind: int, member: str, value: Any
) -> None:
    found = read_parameter(text, known)
    assert found == {"type": kind, member: value}
    TypeStore.bundled().encode("rcl_interfaces/msg/ParameterValue", found)


@pytest.mark.parametrize("text", ["{a: 1}", "[1, a]", "[[1]]", "2026-01-01"])
def test_invalid_parameter_values_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="is an invalid parameter value"):
        read_parameter(text)
