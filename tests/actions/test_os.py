"""The methods of the struct `os` in `osc.os`."""

from pathlib import Path

from tests.runtime.conftest import RunText


async def test_paths_are_split_and_made_absolute(run_text: RunText) -> None:
    ran = await run_text(
        """
import osc.os

scenario main:
    o: os
    do serial:
        log(o.basename("a/b.osc"))
        log(o.dirname("a/b.osc"))
        log(o.abspath("a"))
"""
    )
    assert [text for _, text in ran.logs] == ["b.osc", "a", str(Path.cwd() / "a")]
