"""`call`: methods with and without results, in no time."""

from __future__ import annotations

from pathlib import Path

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

PYTHON = """
from seoro import MethodContext

noted = []

def note(text: str, times: int = 1) -> None:
    noted.append((text, times))

def seeded(run: MethodContext) -> None:
    noted.append(("seed", run.seed))

def notes() -> str:
    return str(noted)

def fail() -> None:
    raise ValueError("broken")
"""

TEXT = """
struct book:
    def note(text: string, times: int = 2) is external notes.note()
    def plain(n: int) -> int is expression n + 1

scenario main:
    b: book
    def seeded() is external notes.seeded()
    def notes() -> string is external notes.notes()
    def fail() is external notes.fail()
    do serial:
"""


async def test_a_call_reaches_its_method_and_takes_no_time(run_text: RunText, tmp_path: Path) -> None:
    (tmp_path / "notes.py").write_text(PYTHON)
    steps = """
        wait elapsed(1s)
        first: call b.note("one")
        call b.note(times: 3, text: "two")
        call seeded()
        call b.plain(1)
        log(notes())
"""
    ran = await run_text(TEXT + steps, seed=7)
    assert ran.logs == [(1.0, "[('one', 2), ('two', 3), ('seed', 7)]")]
    started = [record["name"] for record in ran.records if record.get("type") == "call"]
    assert started == ["first", "call", "call", "call"]
    assert ran.ends["first"] == "succeeded"


async def test_a_failing_method_ends_the_run_as_an_error_with_its_position(
    run_text: RunText, tmp_path: Path
) -> None:
    (tmp_path / "notes.py").write_text(PYTHON)
    verdict = (await run_text(TEXT + "        call fail()\n")).verdict
    assert verdict.status is RunStatus.ERROR
    assert "ValueError: broken" in verdict.reason
    assert verdict.span is not None
    assert verdict.span.text == "fail()"


async def test_an_undefined_method_is_an_error(run_text: RunText) -> None:
    text = "scenario main:\n    def note(n: int) is undefined\n    do call note(3)\n"
    verdict = (await run_text(text)).verdict
    assert verdict.status is RunStatus.ERROR
    assert "`note` is undefined" in verdict.reason
