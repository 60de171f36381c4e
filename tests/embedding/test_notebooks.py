"""Objects of seoro in notebooks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from IPython.core.formatters import DisplayFormatter

import seoro
from seoro.bridges.executor.messages import RunInfo, State
from seoro.client.runs import RemoteRun
from seoro.text.notebook import MOST, card
from tests.report.traces import HOSTILE, REVERSED

TEXT = """\
import osc.types
import osc.helpers

scenario patrol:
    rounds: int = 3
    var done: bool = false
    do wait elapsed(2s)

scenario stuck:
    event go
    do serial:
        wait @go
    with:
        timeout(5s)
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> seoro.Scenario:
    file = tmp_path_factory.mktemp("notebook") / "patrol.osc"
    file.write_text(TEXT)
    return seoro.load(file)


def html(found: object) -> str:
    """Format as a notebook does."""
    formats, _ = DisplayFormatter().format(found)  # type: ignore[no-untyped-call]
    return str(formats["text/html"])


def test_a_scenario_shows_its_parameters(scenario: seoro.Scenario) -> None:
    found = html(scenario)
    assert "patrol.osc" in found
    assert ">patrol</td>" in found
    assert ">rounds</td>" in found
    assert "done" not in found
    assert len(repr(scenario)) < 200


def test_a_verdict_shows_reason_and_waits(scenario: seoro.Scenario) -> None:
    verdict = seoro.run(scenario, name="stuck", clock="virtual", seed=7)
    found = html(verdict)
    assert "<b>\N{BALLOT X} failed</b>" in found
    assert "timeout" in found
    assert "waits since 0.000 s: wait @go (" in found
    hostile = html(replace(verdict, reason=HOSTILE + REVERSED, scenario=HOSTILE))
    assert "<img" not in hostile
    assert "<script" not in hostile
    assert "\u202e" not in hostile


async def test_a_run_shows_its_state_and_values(scenario: seoro.Scenario) -> None:
    async with seoro.start(scenario, name="patrol", clock="virtual") as run:
        assert "running" in html(run)
        await run.result()
    found = html(run)
    assert "<b>\N{CHECK MARK} passed</b>" in found
    assert ">rounds</th>" in found


def test_a_run_on_an_executor_shows_what_it_waits_for() -> None:
    info = RunInfo(run="0" * 32, file=HOSTILE, by="ann", state=State.QUEUED, submitted=0.0, waits="tb1", place=2)
    run = RemoteRun(None, info)  # type: ignore[arg-type]  # nothing is asked
    found = html(run)
    assert "queued" in found
    assert ">tb1</td>" in found
    assert "<img" not in found
    assert repr(run) == f"<RemoteRun {'0' * 32} of {HOSTILE}: queued>"


def test_long_texts_are_cut() -> None:
    assert len(card("x" * 10_000, "", {"y" * 10_000: "z" * 10_000})) < 5 * MOST
    assert Path(__file__).name not in card("", "", {"a": None, "b": ""})
