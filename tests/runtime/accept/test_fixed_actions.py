"""The effects of `log`, `increment`, `decrement` and `compare`, in edited traces."""

from collections.abc import Callable
from typing import TypeAlias

import pytest

from tests.runtime.accept.conftest import Traced, TraceText

SCENARIO = """
struct counter:
    var total: float = 0.5
enum color: [red, green]
scenario main:
    c: counter
    event tick(n: int, hue: color)
    var n: int = 0
    var low: uint = 0
    var seen: int = sample(x.n, @tick as x if x.n > 0, 0)
    do serial:
        log(2.5mps)
        increment(n)
        log("n was counted") with:
            repeat(2)
        decrement(low)
        increment(c.total) with:
            repeat(2)
        log(c)
        compare(2 - 3, "==", -1)
        compare(n, ">", 1) with:
            failure_is_success()
        emit tick(3, color!green)
        wait elapsed(1s)
        log(n)
"""

Edit: TypeAlias = Callable[[Traced], None]


def _drop(kind: str, number: int = 0, **fields: object) -> Edit:
    return lambda traced: traced.drop(traced.find(kind, number, **fields))


def _twice(kind: str, number: int = 0, **fields: object) -> Edit:
    def edit(traced: Traced) -> None:
        record = traced.find(kind, number, **fields)
        traced.insert(record, **{name: value for name, value in record.items() if name not in ("seq", "t")})

    return edit


def _put(kind: str, number: int, name: str, value: object, **fields: object) -> Edit:
    return lambda traced: traced.find(kind, number, **fields).update({name: value})


def _flip(name: str, status: str, number: int = 0) -> Edit:
    return lambda traced: traced.end(name, number).update(status=status)


def _late(message: str) -> Edit:
    return lambda traced: traced.move(traced.find("log", message=message), traced.find("log", message="1"))


EDITS: dict[str, tuple[str, Edit]] = {
    "log changed": ("action", _put("log", 0, "message", "2.5")),
    "log dropped": ("action", _drop("log", message="2.5mps")),
    "log doubled": ("action", _twice("log", message="2.5mps")),
    "repeated log dropped": ("action", _drop("log", 1, message="n was counted")),
    "log of a struct changed": ("action", _put("log", 0, "message", "x", message="counter(total: 2.5)")),
    "log of a variable changed": ("action", _put("log", 0, "message", "2", message="1")),
    "log later": ("action", _late("2.5mps")),
    "log failed": ("outcome", _flip("log", "failed")),
    "increment changed": ("action", lambda traced: traced.rewrite(2, field="n")),
    "increment dropped": ("action", _drop("variable", field="n")),
    "increment doubled": ("action", _twice("variable", field="n")),
    "increment failed": ("outcome", _flip("increment", "failed")),
    "increment of a float changed": ("action", lambda traced: traced.rewrite(1.0, field="total")),
    "increment of a float dropped": ("action", _drop("variable", 1, field="total")),
    "decrement changed": ("action", lambda traced: traced.rewrite(0, field="low")),
    "decrement dropped": ("action", _drop("variable", field="low")),
    "decrement failed": ("outcome", _flip("decrement", "failed")),
    "compare failed": ("outcome", _flip("compare", "failed")),
    "compare succeeded": ("outcome", _put("attempt.end", 0, "status", "succeeded", status="failed")),
    "value changed": ("structure", _put("variable", 0, "value", 7, field="n")),
    "exact changed": ("structure", _put("variable", 0, "exact", 7, field="n")),
    "value of another type": ("structure", _put("variable", 0, "value", True, field="n")),
    "argument changed": ("structure", _put("event", 0, "arguments", {"n": 3, "hue": "color!red"}, event="tick")),
    "argument left out": ("structure", _put("event", 0, "arguments", {"n": 3}, event="tick")),
}


@pytest.mark.parametrize("rule, edit", EDITS.values(), ids=EDITS)
async def test_edited_effects_are_rejected(trace_text: TraceText, rule: str, edit: Edit) -> None:
    traced = await trace_text(SCENARIO)
    assert traced.accept().violations == ()
    edit(traced)
    assert rule in traced.broken


async def test_an_action_cancelled_in_its_instant_may_have_an_effect(trace_text: TraceText) -> None:
    traced = await trace_text(
        """
scenario main:
    event go
    var n: int = 0
    do serial:
        parallel:
            emit go
            serial:
                emit go
                increment(n)
                log("reached")
        with:
            until @go
"""
    )
    assert traced.accept().violations == ()
