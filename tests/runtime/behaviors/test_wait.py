"""`wait elapsed`."""

from tests.runtime.conftest import RunText


async def test_waits_last_exactly_their_duration(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel:
        serial:
            wait elapsed(0.1s)
            wait elapsed(0.2s)
            log("sum")
        serial:
            wait elapsed(300ms)
            log("whole")
""")
    assert ran.logs == [(0.3, "sum"), (0.3, "whole")]


async def test_a_wait_draws_its_duration_from_the_seed(run_text: RunText) -> None:
    text = "scenario main:\n    do wait elapsed([1s..3s])\n"
    durations = [(await run_text(text, seed=seed)).verdict.duration for seed in range(5)]
    assert all(1.0 <= duration <= 3.0 for duration in durations)
    assert len(set(durations)) == 5
    assert (await run_text(text, seed=3)).verdict.duration == durations[3]


async def test_a_wait_may_have_a_computed_duration(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    pause: time = 1min
    do wait elapsed(2 * pause - 100s)
""")
    assert ran.verdict.duration == 20.0
