"""What the runtime cannot carry out yet is refused before anything runs, all of it at once."""

from __future__ import annotations

import pytest

from seoro.embed import Options
from seoro.errors import InvalidUse
from tests.runtime.conftest import Prepare

TEXT = """
scenario unused:
    on elapsed(1s):
        emit end

scenario main:
    event late is elapsed(3s)
    on elapsed(1s):
        emit end
    do serial:
        log("never") with:
            until elapsed(2s)
        wait every(1s)
"""


async def test_a_plan_is_refused_with_all_that_cannot_be_carried_out(prepare_text: Prepare) -> None:
    with pytest.raises(InvalidUse) as caught:
        async with prepare_text(TEXT, Options(name="main", clock="virtual")):
            raise AssertionError("it must not start")
    places = [
        "`is` in the declaration of an event",
        ":10:11",
        "`on`",
        ":11:5",
        "`until`",
        ":15:13",
        "`every`",
        ":16:14",
    ]
    text = str(caught.value)
    assert [part for part in places if part not in text] == []
    assert "test.osc:6" not in text, "what is not reached does not matter"
