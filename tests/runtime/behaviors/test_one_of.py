"""`one_of`: exactly one of the members."""

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


async def test_the_guard_that_ends_first_decides(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        one_of:
            serial:
                wait elapsed(2s)
                log("late")
            serial:
                wait elapsed(1s)
                log("early")
                wait elapsed(1s)
        log("after")
""")
    assert ran.logs == [(1.0, "early"), (2.0, "after")]


async def test_a_member_that_ends_before_any_guard_decides(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        one_of:
            serial:
                wait elapsed(3s)
                log("never")
            serial:
                log("working")
                wait elapsed(1s)
        log("after")
""")
    assert ran.logs == [(0.0, "working"), (1.0, "after")]


async def test_a_guard_cancels_the_invoked_member(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do one_of:
        serial:
            log("working")
            wait elapsed(3s)
            log("never")
        serial:
            wait elapsed(1s)
            log("interrupted")
""")
    assert ran.logs == [(0.0, "working"), (1.0, "interrupted")]


async def test_the_first_in_source_order_of_simultaneous_guards_wins(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        one_of:
            serial:
                wait @go
                log("first")
            serial:
                wait @go
                log("second")
        serial:
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(1.0, "first")]


async def test_guards_of_one_instant_have_no_order_in_time(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        one_of:
            serial:
                wait @go
                log("first")
            serial:
                wait elapsed(1s)
                log("second")
        serial:
            wait elapsed(1s)
            log("before")
            emit go
""")
    assert ran.logs == [(1.0, "before"), (1.0, "first")]


async def test_a_member_that_ends_in_the_instant_of_a_guard_has_ended_first(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        one_of:
            serial:
                wait elapsed(1s)
                log("guarded")
            serial:
                log("invoked")
                wait elapsed(1s)
                log("a step later")
                log("its end")
        log("after")
""")
    assert [message for _, message in ran.logs] == ["invoked", "a step later", "its end", "after"]


async def test_an_inner_choice_is_made_before_an_outer_one(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do one_of:
        serial:
            wait elapsed(1s)
            log("outer")
        serial:
            log("invoked")
            one_of:
                serial:
                    wait elapsed(1s)
                    log("inner")
                wait elapsed(2s)
""")
    assert ran.logs == [(0.0, "invoked"), (1.0, "inner")]


async def test_a_guarded_member_that_fails_in_the_instant_of_its_guard_leaves_the_others(
    run_text: RunText,
) -> None:
    ran = await run_text("""
scenario main:
    do one_of:
        serial:
            wait elapsed(1s)
            log("ended")
        with:
            inverter()
            until elapsed(1s)
        serial:
            wait elapsed(2s)
            log("left")
""")
    assert ran.logs == [(2.0, "left")]


async def test_a_choice_precedes_a_limit_of_the_same_time(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do one_of(duration: 1s):
        serial:
            wait elapsed(1s)
            log("chosen")
        serial:
            wait elapsed(2s)
""")
    assert ran.verdict.passed
    assert ran.logs == [(1.0, "chosen")]


async def test_without_guards_one_member_is_drawn_from_the_seed(run_text: RunText) -> None:
    text = """
scenario main:
    do one_of:
        log("a")
        log("b")
        log("c")
"""
    drawn = [(await run_text(text, seed=seed)).logs for seed in range(12)]
    assert all(len(logs) == 1 for logs in drawn)
    assert {logs[0][1] for logs in drawn} == {"a", "b", "c"}
    assert [(await run_text(text, seed=seed)).logs for seed in range(12)] == drawn


async def test_when_the_invoked_member_fails_another_is_drawn(run_text: RunText) -> None:
    text = """
scenario broken:
    do emit fail

scenario main:
    do one_of:
        broken()
        log("working")
"""
    for seed in range(4):
        ran = await run_text(text, seed=seed)
        assert ran.logs == [(0.0, "working")]
        assert ran.verdict.passed


async def test_one_of_fails_when_every_member_has_failed(run_text: RunText) -> None:
    ran = await run_text("""
scenario broken:
    do emit fail

scenario main:
    do one_of:
        broken()
        broken()
""")
    assert ran.verdict.status is RunStatus.FAILED
    assert "every member has failed" in ran.verdict.reason


async def test_a_failing_member_leaves_the_guards_armed(run_text: RunText) -> None:
    ran = await run_text("""
scenario broken:
    do emit fail

scenario main:
    do one_of:
        broken()
        serial:
            wait elapsed(2s)
            log("guarded")
""")
    assert ran.logs == [(2.0, "guarded")]
    assert ran.verdict.passed


async def test_a_draw_does_not_depend_on_earlier_behaviors(run_text: RunText) -> None:
    chosen = []
    for number in range(8):
        logs = "\n".join(["            log(0)"] * number)
        ran = await run_text(f"""
scenario main:
    do parallel:
        serial:
            wait elapsed(0s)
{logs}
        serial:
            wait elapsed(1s)
            one_of:
                log("a")
                log("b")
                log("c")
                log("d")
""")
        chosen.append(ran.logs[-1])
    assert len(set(chosen)) == 1
