"""Sampling of `cover` and `record`."""

from typing import Any

from seoro import ActionContext, ActionFailed, Struct, action
from seoro.runtime.verdict import ItemCoverage, RunStatus
from tests.runtime.conftest import Ran, RunText


def samples(ran: Ran) -> list[tuple[float, str, str, Any, str]]:
    """Return time, kind, item, value and unit of all samples."""
    fields = ("t", "kind", "item", "value", "unit")
    found = [record for record in ran.records if record["kind"] in ("cover", "record")]
    return [(r[fields[0]], r[fields[1]], r[fields[2]], r[fields[3]], r[fields[4]]) for r in found]


def result(ran: Ran, item: str) -> ItemCoverage:
    return next(found for found in ran.verdict.coverage if found.item == item)


async def test_values_are_sampled_at_their_events_and_in_their_units(run_text: RunText) -> None:
    text = """
scenario main:
    v: speed = 50kph
    warm: temperature = 20C
    event passed
    cover(v, unit: kph, event: start)
    record(warm, unit: C)
    cover(half, expression: v / 2, unit: kph, event: passed)
    do serial:
        wait elapsed(1s)
        emit passed
        wait elapsed(1s)
        emit passed
"""
    ran = await run_text(text)
    assert samples(ran) == [
        (0, "cover", "v", 50, "kph"),
        (1, "cover", "half", 25, "kph"),
        (2, "cover", "half", 25, "kph"),
        (2, "record", "warm", 20, "C"),
    ]
    events = {record["event"] for record in ran.records if record["kind"] == "cover"}
    assert events == {"main.start", "main.passed"}


async def test_failed_behaviors_are_not_sampled_at_their_end(run_text: RunText) -> None:
    members = "    n: int = 3\n    cover(n)\n    record(m, expression: n, event: fail)\n"
    text = f"scenario main:\n{members}    do emit fail\n"
    ran = await run_text(text)
    assert [item for _, _, item, _, _ in samples(ran)] == ["m"]


async def test_buckets_are_counted_over_all_instances(run_text: RunText) -> None:
    text = """
scenario leg:
    gap: length
    cover(gap, unit: cm, range: [0..100], every: 25, target: 2)
    do wait elapsed(1s)

scenario main:
    do serial:
        leg(gap: 10cm)
        leg(gap: 20cm)
        leg(gap: 99cm)
        leg(gap: 2m)
"""
    gap = result(await run_text(text), "leg.gap")
    assert gap.buckets == (("0..25", 2), ("75..100", 1))
    assert (gap.total, gap.reached, gap.grade, gap.outside) == (4, 1, 0.25, 1)


async def test_ignored_values_leave_no_sample_and_illegal_ones_are_marked(run_text: RunText) -> None:
    text = """
scenario main:
    a, b: int = 3
    cover(a, range: [1..4], ignore: a == 3)
    cover(b, range: [1..4], illegal: b in [3..9])
    cover(both, items: [a, b])
"""
    ran = await run_text(text)
    assert [(r["item"], r["illegal"]) for r in ran.records if r["kind"] == "cover"] == [("b", True)]
    assert (result(ran, "main.a").ignored, result(ran, "main.a").total) == (1, 3)
    assert (result(ran, "main.b").illegal, result(ran, "main.b").total) == (1, 2)
    assert result(ran, "main.both").buckets == ()
    assert ran.verdict.passed


async def test_a_cross_counts_combinations(run_text: RunText) -> None:
    text = """
enum light: [red, green]

scenario leg:
    ahead: light
    fast: bool = true
    cover(ahead)
    cover(fast)
    cover(both, items: [ahead, fast])

scenario main:
    do serial:
        leg(red)
        leg(green)
"""
    ran = await run_text(text)
    both = result(ran, "leg.both")
    assert both.buckets == (("light!red x true", 1), ("light!green x true", 1))
    assert both.grade == 0.5
    values = [value for _, _, item, value, _ in samples(ran) if item == "both"]
    assert values[0] == {"ahead": "light!red", "fast": True}


async def test_structs_of_a_scenario_are_sampled_once_at_its_end(run_text: RunText) -> None:
    text = """
struct crate:
    width: length = 10cm
    cover(width, unit: cm, range: [0..20], every: 10)

actor courier:
    box: crate
    record(seven, expression: 7)

scenario leg:
    crates: list of crate
    do wait elapsed(1s)

scenario main:
    who: courier
    own: crate
    do leg([own, crate(width: 15cm)])
"""
    ran = await run_text(text)
    assert sorted((item, value) for _, _, item, value, _ in samples(ran)) == [
        ("crates[1].width", 15),
        ("own.width", 10),
        ("who.box.width", 10),
        ("who.seven", 7),
    ]


async def test_items_are_inherited(run_text: RunText) -> None:
    text = """
scenario ride:
    n: int = 3
    cover(n, range: [1..4])

scenario main inherits ride:
    cover(twice, expression: 2 * n)
    cover(both, items: [n, twice])
"""
    ran = await run_text(text)
    assert [item for _, _, item, _, _ in samples(ran)] == ["n", "twice", "both"]
    assert result(ran, "ride.n").grade == 0.25


async def test_an_item_without_a_value_is_skipped_with_a_warning(run_text: RunText) -> None:
    text = """
scenario main:
    n: int = 0
    cover(bad, expression: 1 / n)
    record(not_a_number, expression: nan)
    cover(n, ignore: 1 / n > 3, range: [0..3])
    do log("done")
"""
    ran = await run_text(text)
    assert ran.verdict.status is RunStatus.PASSED
    assert samples(ran) == []
    assert [message.partition(": ")[0] for _, message in ran.logs] == [
        "done",
        "item `bad` has no value",
        "item `not_a_number` has no value",
        "item `n` has no value",
    ]


async def test_it_is_the_field_in_its_block(run_text: RunText) -> None:
    text = """
struct storm:
    wind: speed = 36kph

scenario main:
    now: storm with:
        keep(it.wind == 72kph)
        cover(wind, expression: it.wind, unit: kmph)
"""
    ran = await run_text(text)
    assert samples(ran) == [(0, "cover", "wind", 72, "kmph")]


async def test_records_have_no_grade(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    ok: bool = true\n    record(ok)\n")
    plain = result(ran, "main.ok").plain()
    assert (plain["buckets"], plain["total"], plain["grade"], plain["target"]) == ({"true": 1}, 2, None, None)


async def test_sampling_does_not_change_a_run(run_text: RunText) -> None:
    body = '    do parallel:\n        emit go\n        serial:\n            wait @go\n            log("x")\n'
    head = "scenario main:\n    event go\n    pause: time = 1s\n"
    cover = "    cover(pause, unit: s, event: go)\n    record(again, expression: pause, unit: ms)\n"

    def rest(ran: Ran) -> list[tuple[str, object]]:
        kept = [r for r in ran.records if r["kind"] not in ("cover", "record")]
        return [(r["kind"], r.get("path") or r.get("name") or r.get("message")) for r in kept]

    with_coverage, without = await run_text(head + cover + body), await run_text(head + body)
    assert rest(with_coverage) == rest(without)
    assert len(samples(with_coverage)) == 2


async def test_actions_are_sampled_at_their_start_end_and_failure(run_text: RunText) -> None:
    @action("lift")
    async def lift(ctx: ActionContext, box: Struct, height: float) -> None:
        await ctx.sleep(height)
        if height > 1:
            raise ActionFailed("too high")

    text = """
struct crate:
    weight: mass = 1kg
    cover(weight, unit: kg, range: [0..10], every: 5)

action lift:
    box: crate
    height: length
    record(height, unit: m, event: start)
    cover(done, expression: height, unit: cm)
    cover(dropped, expression: box.weight, unit: kg, event: fail)

scenario main:
    do serial:
        lift(height: 1m)
        lift(crate(weight: 2kg), 2m)
"""
    ran = await run_text(text, actions=[lift])
    assert not ran.verdict.passed
    assert samples(ran) == [
        (0, "record", "height", 1, "m"),
        (1, "cover", "done", 100, "cm"),
        (1, "cover", "box.weight", 1, "kg"),
        (1, "record", "height", 2, "m"),
        (3, "cover", "dropped", 2, "kg"),
    ]
    assert result(ran, "lift.done").grade is not None


async def test_an_action_with_a_do_is_sampled_as_scenarios_are(run_text: RunText) -> None:
    text = "action lift:\n    n: int\n    cover(n)\n    do wait elapsed(1s)\nscenario main:\n    do lift(3)\n"
    assert samples(await run_text(text)) == [(1, "cover", "n", 3, "")]


async def test_events_of_actions_without_items_leave_no_record(run_text: RunText) -> None:
    ran = await run_text("""
struct crate:
    weight: mass = 1kg
    cover(weight, unit: kg)

scenario main:
    do log("done")
""")
    assert [r["name"] for r in ran.records if r["kind"] == "event"] == ["main.start", "main.end"]


async def test_an_actor_is_sampled_at_an_event_of_its_own(run_text: RunText) -> None:
    ran = await run_text("""
actor bell:
    n: int = 3
    event due is elapsed(1s)
    cover(n, event: due)

scenario main:
    b: bell
    do wait elapsed(3s)
""")
    assert samples(ran) == [(1, "cover", "b.n", 3, "")]
