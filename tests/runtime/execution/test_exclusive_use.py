"""Parts of an actor that only one action may use at a time."""

import asyncio

import anyio
import pytest

from seoro import ActionContext, Actor, action
from seoro.embed.options import Options
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare, RunText

DECLARATIONS = """
actor cart
action cart.drive:
    seconds: time
action cart.honk:
    seconds: time
action record_screen
"""


@action("cart.drive", uses="base")
async def drive(ctx: ActionContext, cart: Actor, seconds: float) -> None:
    """Drive; stopping takes real time."""
    ctx.log(f"{cart.name} drives")
    try:
        await ctx.sleep(seconds)
    except asyncio.CancelledError:
        await asyncio.sleep(0.01)
        ctx.log(f"{cart.name} has stopped")
        raise


@action("cart.honk")
async def honk(ctx: ActionContext, cart: Actor, seconds: float) -> None:
    await ctx.sleep(seconds)


@action("record_screen", uses="screen")
async def record_screen(ctx: ActionContext) -> None:
    await ctx.sleep(1.0)


@action("cart.steer", uses=lambda fields: "front" if fields["in_front"] else "rear")
async def steer(ctx: ActionContext, cart: Actor, in_front: bool) -> None:
    await ctx.sleep(1.0)


ACTIONS = (drive, honk, record_screen)


def scenario(*members: str) -> str:
    """Return a scenario of two carts with members of `parallel`."""
    lines = "\n".join(f"        {line}" for member in members for line in member.split("\n"))
    return f"{DECLARATIONS}\nscenario main:\n    a: cart\n    b: cart\n    do parallel:\n{lines}\n"


@pytest.mark.parametrize(("in_front", "is_right"), [("false", True), ("true", False)])
async def test_used_parts_may_depend_on_parameters(in_front: str, is_right: bool, run_text: RunText) -> None:
    text = scenario("a.steer(true)", f"a.steer({in_front})") + "\naction cart.steer:\n    in_front: bool\n"
    ran = await run_text(text, actions=(*ACTIONS, steer))
    assert ran.verdict.passed is is_right
    assert is_right or "`a.steer` uses the `front` of `a`" in ran.verdict.reason


@pytest.mark.parametrize("clock", ["virtual", "real"])
async def test_simultaneous_uses_of_a_part_are_an_error_with_both_actions(
    clock: str, prepare_text: Prepare
) -> None:
    text = scenario("a.drive(9s)", "serial:\n    wait elapsed(0.01s)\n    a.drive(3s)")
    options = Options(clock="real" if clock == "real" else "virtual")
    async with prepare_text(text, options, ACTIONS) as run, run.running():
        logs = [record["message"] async for record in run.trace() if record["kind"] == "log"]
        verdict = await run.result()
    assert verdict.status is RunStatus.ERROR
    assert verdict.reason.startswith("`a.drive` uses the `base` of `a` while `a.drive` (")
    assert "test.osc:16:9) uses it; one action at a time may use it" in verdict.reason
    assert verdict.span is not None
    assert verdict.span.text.strip() == "a.drive(3s)"
    assert logs == ["a drives", "a has stopped"]


@pytest.mark.parametrize("first", [0, 1])
async def test_the_first_in_source_order_of_simultaneous_actions_has_the_part(
    first: int, run_text: RunText
) -> None:
    members = ["a.drive(9s)", "a.drive(3s)"]
    ran = await run_text(scenario(members[first], members[1 - first]), actions=ACTIONS)
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.span is not None
    assert ran.verdict.span.text.strip() == members[1 - first]


async def test_actions_of_other_actors_and_parts_do_not_conflict(run_text: RunText) -> None:
    ran = await run_text(scenario("a.drive(3s)", "b.drive(3s)", "a.honk(3s)", "a.honk(3s)"), actions=ACTIONS)
    assert ran.verdict.passed, ran.verdict.reason


async def test_an_action_without_an_actor_uses_parts_of_the_run(run_text: RunText) -> None:
    ran = await run_text(scenario("record_screen()", "record_screen()"), actions=ACTIONS)
    assert ran.verdict.reason.startswith("`record_screen` uses the `screen` while `record_screen` (")


@pytest.mark.parametrize("is_swapped", [False, True])
@pytest.mark.parametrize(
    "first", ["a.drive(3s)", "a.drive(9s) with:\n    failure_is_success()\n    timeout(3s)"], ids=["ends", "limit"]
)
async def test_an_action_that_ends_in_the_instant_frees_its_part(
    first: str, is_swapped: bool, run_text: RunText
) -> None:
    members = [first, "serial:\n    wait elapsed(3s)\n    a.drive(1s)"]
    ran = await run_text(scenario(*(members[::-1] if is_swapped else members)), actions=ACTIONS)
    assert ran.verdict.passed, ran.verdict.reason
    assert ran.verdict.duration == 4.0


@pytest.mark.parametrize("clock", ["virtual", "real"])
@pytest.mark.parametrize("is_swapped", [False, True])
async def test_an_action_cancelled_in_the_instant_cleans_up_first(
    clock: str, is_swapped: bool, prepare_text: Prepare
) -> None:
    members = [
        "a.drive(9s) with:\n    until elapsed(0.05s)",
        "serial:\n    wait elapsed(0.05s)\n    a.drive(0.01s)",
    ]
    text = scenario(*(members[::-1] if is_swapped else members))
    options = Options(clock="real" if clock == "real" else "virtual")
    with anyio.fail_after(30.0):
        async with prepare_text(text, options, ACTIONS) as run, run.running():
            logs = [record["message"] async for record in run.trace() if record["kind"] == "log"]
            verdict = await run.result()
    assert verdict.passed, verdict.reason
    assert logs == ["a drives", "a has stopped", "a drives"]


async def test_an_action_cancelled_while_waiting_for_its_part_does_not_start(run_text: RunText) -> None:
    text = scenario(
        "a.drive(9s) with:\n    until elapsed(1s)",
        "serial:\n    wait elapsed(1s)\n    emit end\n    a.drive(1s)",
        "serial:\n    wait elapsed(1s)\n    a.drive(1s)",
    )
    ran = await run_text(text, actions=ACTIONS)
    assert ran.verdict.passed, ran.verdict.reason
    assert [message for _, message in ran.logs] == ["a drives", "a has stopped"]
