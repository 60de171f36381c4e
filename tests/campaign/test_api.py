"""Campaigns from Python."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
import seoro.campaign as sc
from seoro.campaign.asking import CampaignFields
from seoro.campaign.reader import RowReader
from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import RUNS
from seoro.embed.options import OptionFields
from seoro.errors import UsageError

TEXT = """import osc.types
import osc.helpers
scenario main:
    load: float
    keep(load in [0.0..1.0])
    pause: time
    keep(pause in [0s, 0s])
    do serial:
        wait elapsed(pause)
        compare(load, "<", 0.9)
"""
Arguments = dict[str, Any]


@pytest.fixture
def arguments(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Arguments:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    return {"strategy": sc.Uniform(), "seed": 1, "clock": "virtual", "jobs": 1, "folder": "out"}


@pytest.fixture
def is_started_anew() -> bool:
    """Start fork servers as users do: tests count the processes that are left."""
    return True


def children() -> set[str]:
    """Processes that this one has started."""
    listed = Path("/proc/self/task").glob("*/children")
    return {number for path in listed for number in path.read_text().split()}


async def test_rows_arrive_as_they_end_and_stay_readable(arguments: Arguments) -> None:
    async with sc.start("main.osc", runs=30, **arguments) as campaign:
        numbers = [row.run async for row in campaign.runs()]
        again = [row.run async for row in campaign.runs()]
    assert sorted(numbers) == sorted(again) == list(range(1, 31))
    rate = campaign.rate()
    assert rate.runs == 30 and rate.validity is sc.Validity.FIXED and campaign.tally.runs == 30
    read = sc.read("out")
    assert read.rate() == rate and [row.run for row in read.rows()] == list(range(1, 31))
    assert read.rows() == campaign.rows() and "30 passed" not in repr(read)
    assert next(path.name for path in read.write()) == "report.html"


async def test_leaving_the_block_stops_the_campaign_and_it_can_be_continued(arguments: Arguments) -> None:
    before = children()
    async with sc.start("main.osc", runs=400, **arguments) as campaign:
        async for _ in campaign.runs():
            break
    assert campaign.is_over and campaign.tally.runs < 400 and children() == before
    assert campaign.rate().validity is sc.Validity.ALWAYS
    ended = campaign.tally.runs
    async with sc.resume("out", runs=ended + 5, jobs=1) as resumed:
        assert len([row async for row in resumed.runs()]) == ended + 5, "also those of the session before"
    assert [row.run for row in resumed.rows()] == list(range(1, ended + 6))


async def test_a_cancelled_campaign_leaves_nothing_behind(arguments: Arguments) -> None:
    before = children()
    with anyio.CancelScope() as scope:
        async with sc.start("main.osc", runs=400, **arguments) as campaign:
            async for _ in campaign.runs():
                scope.cancel()
    assert scope.cancelled_caught and children() == before and len(campaign.rows()) > 0


async def test_a_campaign_that_is_cancelled_while_it_starts_leaves_nothing_behind(arguments: Arguments) -> None:
    before = children()
    task = asyncio.create_task(carry_out(arguments))
    while children() == before and not task.done():
        await asyncio.sleep(0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert children() == before


def test_an_event_loop_that_is_interrupted_leaves_nothing_behind(arguments: Arguments) -> None:
    before = children()

    async def main() -> None:
        async with sc.start("main.osc", runs=400, **arguments) as campaign:
            async for _ in campaign.runs():
                asyncio.get_running_loop().call_soon(interrupt)

    def interrupt() -> None:
        raise KeyboardInterrupt  # as by the second Ctrl-C, or a time limit of pytest

    with pytest.raises(KeyboardInterrupt):
        asyncio.run(main())
    assert children() == before


async def carry_out(arguments: Arguments) -> None:
    async with sc.start("main.osc", runs=400, **arguments) as campaign:
        await campaign.wait()


async def test_a_campaign_that_cannot_continue_raises_its_error(
    arguments: Arguments, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.campaign.planner.MOST_IMPOSSIBLE", 4)
    impossible = {**arguments, "overrides": {"load": "2.0", "pause": "0s"}, "strategy": sc.Grid()}
    with pytest.raises(UsageError, match="exclude all"):
        async with sc.start("main.osc", repeat=10, **impossible) as campaign:
            async for _ in campaign.runs():
                raise AssertionError("no run is possible")
    assert campaign.rate() == sc.Rate(0, 0, sc.Validity.ALWAYS) and campaign.tally.impossible >= 3


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"strategy": "sobol"}, "invalid `strategy`: expected a strategy, such as seoro.campaign.Sobol()"),
        ({"runs": 0}, "invalid `runs`: found 0, expected at least 1"),
        ({"runs": "12"}, "invalid `runs`: expected a whole number"),
        ({"keep": "some"}, 'invalid `keep`: expected "failed" or "all" or "none"'),
        ({"folder": 3}, "invalid `folder`: expected a path"),
        ({"stratgy": sc.Grid()}, "unknown option `stratgy`"),
        ({"observers": []}, "a campaign has no option `observers`"),
        ({"until": "first failure"}, "invalid `until`: expected a list of str"),
        ({"until": ["rate"]}, "invalid stopping rule `rate`"),
    ],
)
def test_invalid_arguments_are_rejected(arguments: Arguments, given: Arguments, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        sc.run("main.osc", **{"runs": 1, **arguments, **given})
    assert message in str(caught.value)
    assert not Path("out").exists()


async def test_scripts_do_not_run_a_campaign_in_an_event_loop(arguments: Arguments) -> None:
    with pytest.raises(UsageError, match="cannot be called from a running event loop"):
        sc.run("main.osc", **arguments)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> sc.Results:
    """Results of a script without an event loop."""
    folder = tmp_path_factory.mktemp("results")
    (folder / "main.osc").write_text(TEXT)
    scenario = seoro.load(folder / "main.osc")
    return sc.run(scenario, strategy=sc.Uniform(), runs=40, seed=1, clock="virtual", folder=folder / "out", jobs=1)


def test_runs_become_a_data_frame(results: sc.Results) -> None:
    pandas = pytest.importorskip("pandas")
    frame = results.frame()
    assert list(frame["run"]) == list(range(1, 41)) and frame["load"].between(0.0, 1.0).all()
    assert isinstance(frame, pandas.DataFrame) and set(frame["status"]) == {"passed", "failed"}


def test_a_frame_without_pandas_names_the_extra(results: sc.Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(UsageError, match="needs pandas") as caught:
        results.frame()
    assert "seoro[pandas]" in str(caught.value.help)


def test_notebooks_show_tables_with_escaped_texts(results: sc.Results) -> None:
    shown = results._repr_html_()
    assert shown.count("<tr>") == 11 and "30 more runs" in shown and "Pass rate" in shown
    assert shown.index("failed</td>") < shown.index("passed</td>")
    row = Row(1, "", 1, 1, 1, End.FAILED, {"<b>": "a & b"}, reason="<script>", measured={"m": 0.5, "n": None})
    html = row._repr_html_()
    assert "&lt;script&gt;" in html and "&lt;b&gt;" in html and "a &amp; b" in html and ">n</th>" not in html
    assert results.rate()._repr_html_().startswith("<p><b>pass rate")


async def test_a_slow_reader_gets_each_row_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.campaign.reader.MOST", 3)
    (tmp_path / RUNS).mkdir()
    reader, got = RowReader(tmp_path), []
    with (tmp_path / RUNS / "w.jsonl").open("a", buffering=1) as shard:
        for number in range(1, 21):
            row = Row(number, "", number, 1, 1, End.IMPOSSIBLE if number == 5 else End.PASSED)
            shard.write(row.to_line())
            reader.publish(row)
            if number in (2, 12):
                got += [(await anext(reader)).run for _ in range(2)]
    reader.finish()
    got += [row.run async for row in reader]
    assert sorted(got) == [number for number in range(1, 21) if number != 5]


def test_every_argument_is_documented() -> None:
    page = Path(__file__).parents[2] / "docs" / "how-to" / "campaign_python.md"
    table = "".join(line.partition(" | ")[0] for line in page.read_text().splitlines() if line.startswith("| `"))
    own = CampaignFields.__annotations__.keys() - OptionFields.__annotations__.keys()
    assert [name for name in own if f"`{name}`" not in table] == []


@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import seoro.campaign as sc; sc.Grid, sc.Uniform", "numpy zenoh"),
        (
            "import seoro.cli.campaign_command",
            "numpy zenoh seoro.runtime.run seoro.campaign.report.page",
        ),  # in workers
    ],
)
def test_what_begins_a_campaign_is_light(code: str, heavy: str) -> None:
    code = f"{code}; import sys; print(*set({heavy.split()}) & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
