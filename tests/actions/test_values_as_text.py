"""Text of values in `log`, and comparison of values of any type in `compare`."""

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

LOGGED = r"""
import osc.helpers
enum color: [red, green]
struct point:
    x: length = 1m
    name: string = "a\"b"
    tags: list of color = [color!red]
scenario main:
    p: point
    c: color = color!green
    v: speed = 3.6kph
    r: range of time = [1s..3s]
    w: int = 2
    f: float = w
    none: list of int
    var n: uint = 7
    do serial:
"""

TEXTS = (
    ("true", "true"),
    ('"plain text"', "plain text"),
    ("[1, 2]", "[1, 2]"),
    ("[3..1]", "[1..3]"),
    ('["a", "b"]', '["a", "b"]'),
    ("c", "color!green"),
    ("p", r'point(x: 1.0m, name: "a\"b", tags: [color!red])'),
    ("r", "[1.0s..3.0s]"),
    ("2.5mps", "2.5mps"),
    ("2.5m * 2.0m", "5.0 m^2"),
    ("[1m, -2m]", "[1.0m, -2.0m]"),
    ("f", "2.0"),
    ("0.0000001", "1.0e-07"),
    ("n", "7"),
    ("-1", "-1"),
    ("none", "[]"),
)


async def test_values_are_logged_as_the_language_writes_them(run_text: RunText) -> None:
    ran = await run_text(LOGGED + "".join(f"        log({expression})\n" for expression, _ in TEXTS))
    assert [message for _, message in ran.logs] == [text for _, text in TEXTS]


COMPARED = """
import osc.helpers
enum color: [red, green]
scenario main:
    do compare({})
"""


@pytest.mark.parametrize(
    "arguments",
    [
        '2 - 3, "==", -1',
        '-1, "==", 2 - 3',
        '2 - 3, "<", 0 - 0 + -1 + 1',
        '[2 - 3], "==", [-1]',
        '[1..2], "==", [1.0..2.0]',
        '1, "==", 1.0',
        '1s, "<", 2s',
        'color!red, "!=", color!green',
    ],
)
async def test_values_are_compared_as_operators_do(run_text: RunText, arguments: str) -> None:
    assert (await run_text(COMPARED.format(arguments))).verdict.status is RunStatus.PASSED


@pytest.mark.parametrize(
    "arguments, reason",
    [
        ('2 - 1, "==", -1', "`1 == -1` is false"),
        ('3s, "==", 3.0', "cannot compare `3.0s` and `3.0` by `==`"),
        ('true, "==", 1', "cannot compare `true` and `1` by `==`"),
        ('1, "=", 1', "unknown operator `=`; expected one of ==, !=, <, <=, >, >="),
    ],
)
async def test_failed_comparisons_show_values_of_the_language(
    run_text: RunText, arguments: str, reason: str
) -> None:
    verdict = (await run_text(COMPARED.format(arguments))).verdict
    assert verdict.status is RunStatus.FAILED
    assert reason in verdict.reason
