"""Margins: how far checks were from their limits."""

import pytest

from tests.runtime.conftest import RunText

SCENARIO = """
scenario pause:
    length: time
    do wait elapsed(length)

scenario main:
    do serial:
        pause(2s) with:
            timeout(8s)
        {checks}
"""
SPARED = " with:\n            failure_is_success()\n"


@pytest.mark.parametrize(
    ("checks", "margins"),
    [
        ("compare(1.5mps, '<=', 2mps)", [0.25]),
        ("compare(3s, '>', 2s)", [0.5]),
        ("compare(-1.0, '<', -2.0)" + SPARED, [-0.5]),
        ("compare(0.25, '>=', 0)", [0.25]),
        ("compare(2, '<', 2)" + SPARED, [0.0]),
        ("compare(2, '==', 2)", []),
        ("compare(5, '==', 4)" + SPARED, [-0.25]),
        ("compare(3, '!=', 2)", [0.5]),
        ("compare(2, '!=', 2)" + SPARED, [0.0]),
        ("compare('a', '!=', 'b')", []),
        ("compare('a', '<', 'b')", []),
        ("pause(9s)" + SPARED + "            timeout(4s)\n", [0.0]),
    ],
)
async def test_checks_have_margins(run_text: RunText, checks: str, margins: list[float]) -> None:
    ran = await run_text(SCENARIO.format(checks=checks))
    found = [record["value"] for record in ran.records if record["kind"] == "margin"]
    assert found == [0.75, *margins]
    assert ran.verdict.margin == ran.records[-1]["margin"] == min(found)


@pytest.mark.parametrize(
    ("checks", "margins"),
    [
        ("serial(duration: [0s..8s]):\n            wait elapsed(2s)", [0.75]),
        ("serial(duration: 4s):\n            wait elapsed(1s)", [0.75]),
        ("pause(1s) with:\n            keep(it.duration <= 4s)", [0.75]),
        ("serial(duration: [3s..8s]):\n            wait elapsed(9s)\n       " + SPARED, [0.0]),
        ("serial(duration: 4s):\n            pause(1s) with:\n                success_is_running()", []),
        ("wait elapsed(2s)", []),
    ],
)
async def test_bounds_of_lengths_have_margins(run_text: RunText, checks: str, margins: list[float]) -> None:
    ran = await run_text(SCENARIO.format(checks=checks))
    assert ran.verdict.passed
    found = [(record["check"], record["value"]) for record in ran.records if record["kind"] == "margin"]
    assert found == [("timeout", 0.75), *(("duration", margin) for margin in margins)]


async def test_a_run_without_limits_has_no_margin(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do log('x')\n")
    assert ran.verdict.margin is None
    assert "margin" not in ran.records[-1]


async def test_a_margin_has_its_place(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do compare(1m, '<', 4m)\n")
    (record,) = (record for record in ran.records if record["kind"] == "margin")
    fields = {key: record[key] for key in ("check", "value", "distance", "limit", "source")}
    assert fields.pop("source").endswith("test.osc:5:8")
    assert fields == {"check": "compare", "value": 0.75, "distance": 3.0, "limit": 4.0}
