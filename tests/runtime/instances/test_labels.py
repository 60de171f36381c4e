"""Labels, which refer to the last instance of their invocation."""

from seoro import ActionContext, Struct, action
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

INNER = """
struct box:
    size: int = 7

scenario leaf:
    n: int
    do wait elapsed(1s)

scenario inner:
    n: int in [1..3]
    b: box
    def twice() -> int is expression 2 * n
    do deep: leaf(n + 10)
""".replace(" in [1..3]", "\n    keep(n in [1..3])")


async def test_a_label_has_the_fields_and_methods_of_its_last_invocation(run_text: RunText) -> None:
    text = f"""{INNER}
scenario main:
    do serial:
        first: inner(2)
        log(first.n)
        log(first.twice())
        log(first.deep.n)
        log(first.b.size)
"""
    ran = await run_text(text)
    assert ran.logs == [(1, "2"), (1, "4"), (1, "12"), (1, "7")]


async def test_invocations_are_constrained_by_earlier_ones(run_text: RunText) -> None:
    text = f"""{INNER}
scenario main:
    do serial:
        first: inner()
        second: inner() with:
            keep(it.n != first.n)
        third: inner() with:
            keep(it.n != first.n and it.n != second.n)
        log(first.n + second.n + third.n)
"""
    assert (await run_text(text, seed=3)).logs == [(3, "6")]


async def test_a_label_exists_for_others_from_the_next_delta_cycle(run_text: RunText) -> None:
    for members in (("first: inner(2)", "log(first.n)"), ("log(first.n)", "first: inner(2)")):
        text = f"{INNER}\nscenario main:\n    do parallel:\n" + "".join(f"        {each}\n" for each in members)
        ran = await run_text(text)
        assert ran.verdict.status is RunStatus.ERROR
        assert "the label `first` has not been invoked yet" in ran.verdict.reason


async def test_a_label_of_an_action_has_its_parameters(run_text: RunText) -> None:
    @action("lift")
    async def lift(ctx: ActionContext, load: Struct, height: float) -> None: ...

    text = f"""{INNER}
action lift:
    load: box
    height: length = 2m

scenario main:
    record(lifted, expression: up.height, unit: m)
    do serial:
        up: lift()
        log(up.load.size)
"""
    ran = await run_text(text, actions=[lift])
    assert ran.logs == [(0, "7")]
    assert [r["value"] for r in ran.records if r["kind"] == "record"] == [2]


async def test_a_condition_on_a_label_holds_after_its_invocation(run_text: RunText) -> None:
    text = f"""{INNER}
scenario main:
    do parallel:
        serial:
            wait first.n == 2
            log("two")
        serial:
            wait rise(first.twice() > 3)
            log("four")
        serial:
            wait elapsed(1s)
            first: inner(2)
"""
    ran = await run_text(text)
    assert sorted(ran.logs) == [(1, "four"), (1, "two")]
    assert ran.verdict.passed
