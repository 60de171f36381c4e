"""What the runtime cannot carry out yet is refused before anything runs, all of it at once."""

from __future__ import annotations

import pytest

from seoro.embed import Options
from seoro.errors import InvalidUse
from tests.runtime.conftest import Prepare

TEXT = """
scenario unused:
    event go(n: int)
    on @go as g if rise(g.n == 1):
        emit end

scenario main:
    event go(n: int)
    var m: int = 0
    on @go as g if fall(g.n == m):
        emit end
    do serial:
        log("never") with:
            until @go as g if rise(g.n + m > 3)
        wait @go as g if every(g.n * 1s)
"""


async def test_a_plan_is_refused_with_all_that_cannot_be_carried_out(prepare_text: Prepare) -> None:
    with pytest.raises(InvalidUse) as caught:
        async with prepare_text(TEXT, Options(name="main", clock="virtual")):
            raise AssertionError("it must not start")
    named = ["an occurrence in `rise` or `fall`", "an occurrence in `every`"]
    assert str(caught.value).endswith(": " + ", ".join(named))
    places = [(span.line, text.removesuffix(" is not carried out yet")) for span, text in caught.value.places]
    assert places == [(13, named[0]), (17, named[0]), (18, named[1])], "what is not reached does not matter"


async def test_items_that_nothing_would_sample_are_refused(prepare_text: Prepare) -> None:
    text = """
actor robot:
    event bumped
    cover(bumps, expression: 3, event: bumped)

modifier gently:
    record(gentle, expression: true)

scenario main:
    r: robot
    do log("x") with:
        gently()
"""
    with pytest.raises(InvalidUse) as caught:
        async with prepare_text(text):
            raise AssertionError("it must not start")
    found = {(span.line, text.removesuffix(" is not carried out yet")) for span, text in caught.value.places}
    assert (10, "`cover` or `record` in a modifier") in found


async def test_constraints_on_compositions_and_durations_are_refused(prepare_text: Prepare) -> None:
    text = """
scenario nap:
    duration: int = 3

scenario main:
    do serial:
        log("x") with:
            keep(it.duration < 3s)
        nap() with:
            keep(it.duration < 4)
    with:
        keep(it.duration < 3s)
"""
    with pytest.raises(InvalidUse) as caught:
        async with prepare_text(text, Options(name="main", clock="virtual")):
            raise AssertionError("it must not start")
    assert [span.line for span, _ in caught.value.places] == [15, 11]
    assert str(caught.value).endswith(": a constraint on a composition, a constraint on `duration`")
