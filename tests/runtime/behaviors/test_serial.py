"""`serial`: members run one after another."""

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


async def test_members_follow_each_other_in_the_same_instant(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        log("a")
        wait elapsed(1s)
        log("b")
        log("c")
""")
    assert ran.logs == [(0.0, "a"), (1.0, "b"), (1.0, "c")]
    assert ran.verdict.passed


async def test_a_serial_fails_with_its_first_failing_member(run_text: RunText) -> None:
    ran = await run_text("""
scenario broken:
    do emit fail

scenario main:
    do serial:
        broken()
        log("never")
""")
    assert ran.logs == []
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.reason == "`emit fail`"
    assert ran.verdict.span is not None
    assert ran.verdict.span.text == "emit fail"


async def test_many_members_of_serial_run_without_recursion(run_text: RunText) -> None:
    members = "\n".join(f'        log("{number}")' for number in range(2000))
    ran = await run_text(f"scenario main:\n    do serial:\n{members}\n")
    assert len(ran.logs) == 2000
