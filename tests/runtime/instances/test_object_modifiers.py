"""Modifiers as members of structs and actors (7.3.12.4): they apply to each value while it is held."""

from __future__ import annotations

import pytest

from seoro import UsageError
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Prepare, Ran, RunText

WARNING = """
modifier vehicle.speed_warning:
    tolerance: int
    event too_fast(by: int)
    keep(actor.limit < 7)
    on actor.speed_now > actor.limit + tolerance:
        emit too_fast(actor.speed_now - actor.limit)
    record(tolerance)

actor vehicle:
    var speed_now: int = 0
    limit: int with:
        keep(it in [5..50])
    speed_warning(tolerance: 2)

scenario vehicle.speed_up:
    do serial:
        wait elapsed(1s)
        increment(actor.speed_now)
    with:
        repeat(10)

"""


def emitted(ran: Ran, name: str) -> list[tuple[float, str, dict[str, object]]]:
    """Return time, path and arguments of each occurrence of an event."""
    return [
        (r["t"], r["name"], r["arguments"])
        for r in ran.records
        if r["kind"] == "event" and r["name"].endswith(f".{name}")
    ]


@pytest.mark.parametrize("seed", range(3))
async def test_a_modifier_applies_to_each_actor(run_text: RunText, seed: int) -> None:
    """Constraints and reactions of the modifier apply to all actions invoked on the actor."""
    ran = await run_text(
        f"""{WARNING}
scenario main:
    v, w: vehicle
    keep(v.limit == 5)
    do serial:
        v.speed_up()
        wait elapsed(1s)
        w.speed_up()
        log(w.limit in [5..6] ? "constrained" : "free")
""",
        seed=seed,
    )
    assert [text for _, text in ran.logs] == ["constrained"]
    (first, second) = emitted(ran, "too_fast")
    assert first == (8.0, "main/v.speed_warning[0].too_fast", {"by": 3})
    assert second[1].startswith("main/w.speed_warning[")
    records = [(r["t"], r["item"], r["value"]) for r in ran.records if r["kind"] == "record"]
    assert records == [(21.0, "tolerance", 2)] * 2, "when what first held the actor ends"


async def test_an_actor_is_modified_by_its_first_scenario(run_text: RunText) -> None:
    ran = await run_text("""
modifier watch:
    event reported(what: string)
    on @start:
        emit reported("start")
    on @it.end:
        emit reported("end")

struct crate:
    watch()

scenario inner:
    given: crate
    own: crate
    do wait elapsed(1s)

scenario main:
    c: crate
    do serial:
        wait elapsed(1s)
        inner(given: c)
        wait elapsed(1s)
""")
    assert [(time, path.split("/")[-1].split("[")[0], arguments["what"]) for time, path, arguments in
            emitted(ran, "reported")] == [
        (0.0, "c.watch", "start"),
        (1.0, "own.watch", "start"),
        (2.0, "own.watch", "end"),
        (3.0, "c.watch", "end"),
    ]  # fmt: skip


async def test_a_modifier_of_an_actor_may_end_the_run(run_text: RunText) -> None:
    ran = await run_text("""
modifier robot.guard:
    on rise(actor.bumps > 1):
        emit fail

actor robot:
    var bumps: int = 0
    guard()

scenario robot.bump:
    do serial:
        wait elapsed(1s)
        increment(actor.bumps)

scenario main:
    r: robot
    do r.bump() with:
        repeat(5)
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 2.0)
    assert ran.verdict.reason == "`emit fail`"


async def test_a_modifier_of_a_library_limits_the_owner_of_the_value(run_text: RunText) -> None:
    ran = await run_text("""
struct battery:
    life: time
    timeout(life)

scenario drive:
    b: battery
    keep(b.life == 2s)
    do wait elapsed(5s)

scenario main:
    do drive() with:
        inverter()
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.PASSED, 2.0)


async def test_modifiers_of_bases_extensions_and_conditional_subtypes_apply(run_text: RunText) -> None:
    ran = await run_text("""
modifier named:
    name: string
    event reported(name: string)
    on @start:
        emit reported(name)

struct base:
    is_big: bool
    named("base")

struct small inherits base

struct big inherits base (is_big == true):
    named("big")

extend base:
    named("extension")

scenario main:
    s: small with:
        keep(it.is_big == false)
    b: base with:
        keep(it.is_big == true)
""")
    reported = [
        (path.split("/")[1].split(".")[0], arguments["name"]) for _, path, arguments in emitted(ran, "reported")
    ]
    assert sorted(reported) == [("b", "base"), ("b", "big"), ("b", "extension"), ("s", "base"), ("s", "extension")]


async def test_free_parameters_of_a_modifier_are_chosen_with_the_value(run_text: RunText) -> None:
    ran = await run_text("""
modifier robot.bounded:
    low: int
    keep(actor.level > low)
    keep(low > 8)

actor robot:
    level: int with:
        keep(it in [1..10])
    bounded()

scenario main:
    r: robot
    do log(r.level == 10 ? "ten" : "other")
""")
    assert [text for _, text in ran.logs] == ["ten"]


async def test_unsatisfiable_modifiers_are_reported_before_the_run(prepare_text: Prepare) -> None:
    text = """
modifier robot.never:
    keep(actor.level > 5)

actor robot:
    level: int = 3
    never()

scenario main:
    r: robot
"""
    with pytest.raises(UsageError) as caught:
        async with prepare_text(text):
            raise AssertionError("it must not start")
    assert caught.value.code == "E0442"
