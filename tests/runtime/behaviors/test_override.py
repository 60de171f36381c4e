"""`override`: a behavior ends when another one starts."""

from tests.runtime.conftest import RunText


def scenario(rules: str, first: str = "1s", second: str = "2s") -> str:
    """Return a scenario with two labelled behaviors of 2 s in separate tasks."""
    tasks = "".join(
        f"""
        serial:
            wait elapsed({start})
            {label}: serial:
                log("{label}")
                wait elapsed(2s)
                log("{label} ends")
            log("after {label}")"""
        for label, start in (("a", first), ("b", second))
    )
    lines = "".join(f"\n        {rule}" for rule in rules.splitlines())
    return f"scenario main:\n    do parallel:{tasks}\n    with:{lines}\n"


async def test_an_overridden_behavior_ends_and_outer_behaviors_continue(run_text: RunText) -> None:
    ran = await run_text(scenario("override(a, b)"))
    assert ran.logs == [(1.0, "a"), (2.0, "b"), (2.0, "after a"), (4.0, "b ends"), (4.0, "after b")]
    assert ran.verdict.passed
    assert ran.ends["a"] == "cancelled"


async def test_an_override_does_not_affect_a_later_start(run_text: RunText) -> None:
    ran = await run_text(scenario("override(b, a)"))
    assert (2.0, "b") in ran.logs
    assert ran.verdict.passed


async def test_when_active_prevents_a_start(run_text: RunText) -> None:
    ran = await run_text(scenario("override(b, a, when_active)"))
    skipped = "`b` does not start: overridden by `a`"
    assert ran.logs == [(1.0, "a"), (2.0, skipped), (2.0, "after b"), (3.0, "a ends"), (3.0, "after a")]


async def test_when_active_permits_a_start_after_the_end_of_the_other(run_text: RunText) -> None:
    ran = await run_text(scenario("override(b, a, when_active)", second="3.5s"))
    assert (3.5, "b") in ran.logs


async def test_the_first_of_two_simultaneously_started_overrides_continues(run_text: RunText) -> None:
    for mode in ("", ", when_active"):
        ran = await run_text(scenario(f"override(a, b{mode})\noverride(b, a{mode})", "1s", "1s"))
        assert (3.0, "a ends") in ran.logs
        assert (3.0, "b ends") not in ran.logs


async def test_an_override_in_the_block_of_the_overriding_behavior_holds(run_text: RunText) -> None:
    ran = await run_text("""
scenario inner:
    do wait elapsed(1s)

scenario main:
    do parallel:
        x: serial:
            wait elapsed(5s)
            log("never")
        serial:
            wait elapsed(1s)
            y: inner() with:
                override(x, y)
""")
    assert (ran.verdict.passed, ran.verdict.duration, ran.logs) == (True, 2.0, [])


async def test_an_override_accepts_labels_of_invocations_and_scenario_members(run_text: RunText) -> None:
    ran = await run_text("""
scenario inner:
    do part: serial:
        wait elapsed(5s)
        log("never")

scenario main:
    override(x.part, y)
    do parallel:
        serial:
            x: inner()
            log("after x")
        serial:
            wait elapsed(1s)
            y: wait elapsed(1s)
""")
    assert (ran.verdict.passed, ran.verdict.duration, ran.logs) == (True, 2.0, [(1.0, "after x")])


async def test_an_override_holds_from_the_next_delta_cycle(run_text: RunText) -> None:
    rule = """
        serial:
            wait elapsed(1s)
            serial:
                wait elapsed(1s)
            with:
                override(b, a, when_active)"""
    other = """
        serial:
            wait elapsed(1s)
            b: log("b")"""
    for first, second in ((rule, other), (other, rule)):
        ran = await run_text(f"scenario main:\n    do a: parallel:{first}{second}\n")
        assert ran.logs == [(1.0, "b")]


async def test_an_overridden_invoked_member_of_one_of_decides(run_text: RunText) -> None:
    ran = await run_text("""
scenario work:
    do wait elapsed(5s)
scenario main:
    do parallel:
        serial:
            one_of:
                x: work()
                y: work()
                wait elapsed(6s)
            log("chosen")
        serial:
            wait elapsed(1s)
            z: wait elapsed(1s)
    with:
        override(x, z)
        override(y, z)
""")
    assert (ran.verdict.passed, ran.verdict.duration, ran.logs) == (True, 2.0, [(1.0, "chosen")])
    assert len({"x", "y"} & ran.ends.keys()) == 1


async def test_a_member_of_one_of_prevented_from_starting_leaves_the_others(run_text: RunText) -> None:
    text = """
scenario fails:
    do emit fail
scenario main:
    do a: one_of:
        {members}
    with:
        override(x, a, when_active)
"""
    for seed in range(4):
        drawn = await run_text(
            text.format(members='x: wait elapsed(2s)\n        fails()\n        log("other")'), seed=seed
        )
        assert (drawn.verdict.passed, drawn.logs[-1]) == (True, (0.0, "other"))
    guarded = await run_text(text.format(members='x: log("never")\n        wait elapsed(2s)'))
    assert (guarded.verdict.passed, guarded.verdict.duration) == (True, 2.0)
    assert "never" not in [message for _, message in guarded.logs]
