"""Planning: lazily, within the number of runs, and after an interruption as without one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from seoro.bridges.executor.messages import BundledOptions, BundleFile, Manifest
from seoro.campaign.planner import MOST_IMPOSSIBLE, Planner
from seoro.campaign.results.table import write_table
from seoro.campaign.runs import End, Planned, Point, Row
from seoro.campaign.space.space import Space
from seoro.campaign.store.folder import CampaignFile, CampaignFolder, StrategyText, create_folder, shard
from seoro.campaign.store.index import RowIndex
from seoro.campaign.store.lines import Appender
from seoro.campaign.strategies.contract import Batches, Sampling, Strategy
from seoro.errors import UsageError
from seoro.lang.frozen import Value


class Counting(Value):
    """Points with the numbers 0, 1, 2, ..."""

    number: int = 1_000_000_000
    name = "counting"
    is_learning = False
    is_endless = False
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {}

    def batches(self, space: Space, seed: int) -> Batches:
        """Yield them one by one."""
        for number in range(self.number):
            yield [Point({"a": str(number)})]


class Climbing(Value):
    """Points about the best one so far, which is the run with the largest number."""

    name = "climbing"
    is_learning = True
    is_endless = False
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {}

    def batches(self, space: Space, seed: int) -> Batches:
        """Yield batches of three."""
        best = 0
        while True:
            told = yield [Point({"a": str(best + step)}) for step in (1, 2, 3)]
            best = max(row.run for each in told for row in each.rows)


CAMPAIGN = CampaignFile(
    manifest=Manifest(
        files=(BundleFile(path="main.osc", hash="0" * 64, size=1),),
        entry="main.osc",
        shown="main.osc",
        options=BundledOptions(grace=5.0, overrides={}),
    ),
    strategy=StrategyText(name="grid", options={}),
    runs=None,
    repeat=1,
    seed=7,
    keep="failed",
    isolation="worker",
    digest="d",
    simulator="",
    version="1",
)


def campaign(folder: Path, **more: object) -> CampaignFolder:
    """Create the folder of a campaign."""
    return create_folder(folder / "out", CAMPAIGN.model_copy(update=more), overwrite=False)


def row_of(planned: Planned, status: End = End.PASSED) -> Row:
    """Return the row of a run."""
    return Row(planned.number, f"{planned.number:016}", planned.variant, planned.repeat, planned.seed, status)


def store(folder: CampaignFolder, rows: Sequence[Row]) -> None:
    """Append rows, as a worker does."""
    file = Appender(shard(folder.folder, "worker"))
    file.append("".join(row.to_line() for row in rows))
    file.close()


def again(folder: CampaignFolder, strategy: Strategy) -> tuple[CampaignFolder, Planner]:
    """Open a campaign once more."""
    folder.close()
    opened = CampaignFolder(folder.folder, folder.campaign)
    return opened, Planner(opened, strategy, Space())


def test_runs_are_planned_when_they_are_needed(tmp_path: Path) -> None:
    folder = campaign(tmp_path, repeat=2)
    planner = Planner(folder, Counting(), Space())
    first, second, third = planner.take(3)
    assert [each.number for each in (first, second, third)] == [1, 2, 3]
    assert [(each.variant, each.repeat, each.seed) for each in (first, second, third)] == [
        (1, 1, 7), (1, 2, 8), (2, 1, 7)
    ]  # fmt: skip
    assert first.values == second.values == {"a": "0"}
    folder.close()


def test_the_number_of_runs_does_not_count_impossible_ones(tmp_path: Path) -> None:
    folder = campaign(tmp_path, runs=3)
    planner = Planner(folder, Counting(), Space())
    assert len(planner.take(10)) == 3 and planner.is_over
    planner.record(row_of(Planned(1, 1, 1, 7, {}, ""), End.IMPOSSIBLE))
    assert not planner.is_over
    assert [each.number for each in planner.take(10)] == [4]
    folder.close()


def test_constraints_that_exclude_everything_end_the_campaign(tmp_path: Path) -> None:
    folder = campaign(tmp_path, runs=3)
    planner = Planner(folder, Counting(), Space())
    with pytest.raises(UsageError, match=f"exclude all of the first {MOST_IMPOSSIBLE:,} runs"):
        for _ in range(MOST_IMPOSSIBLE):
            [planned] = planner.take(1)
            planner.record(row_of(planned, End.IMPOSSIBLE))
    folder.close()


def test_what_has_not_ended_is_planned_again_after_an_interruption(tmp_path: Path) -> None:
    folder = campaign(tmp_path, repeat=2)
    planner = Planner(folder, Counting(4), Space())
    taken = planner.take(5)
    store(folder, [row_of(taken[0]), row_of(taken[3])])
    folder, planner = again(folder, Counting(4))
    left = planner.take(100)
    assert [each.number for each in left] == [2, 3, 5, 6, 7, 8]
    assert left[:3] == [taken[1], taken[2], taken[4]]
    assert planner.is_over
    folder.close()


def test_a_strategy_that_learns_continues_as_without_an_interruption(tmp_path: Path) -> None:
    def play(folder: CampaignFolder, planner: Planner, batches: int) -> list[Planned]:
        seen = []
        for _ in range(batches):
            taken = planner.take(10)
            assert len(taken) == 3 and not planner.take(10), "the next batch needs the results of this one"
            seen += taken
            rows = [row_of(planned) for planned in taken]
            store(folder, rows)
            for row in reversed(rows):
                planner.record(row)
        return seen

    whole = campaign(tmp_path / "whole")
    expected = play(whole, Planner(whole, Climbing(), Space()), 4)
    whole.close()
    parted = campaign(tmp_path / "parted")
    found = play(parted, Planner(parted, Climbing(), Space()), 2)
    parted, planner = again(parted, Climbing())
    found += play(parted, planner, 2)
    assert found == expected
    parted.close()


def test_a_campaign_whose_strategy_chooses_otherwise_is_refused(tmp_path: Path) -> None:
    folder = campaign(tmp_path)
    Planner(folder, Counting(), Space()).take(2)

    class Other(Counting):
        def batches(self, space: Space, seed: int) -> Batches:
            yield [Point({"a": "x"}), Point({"a": "y"})]

    with pytest.raises(UsageError, match="chooses other values than before"):
        again(folder, Other())


def test_torn_last_lines_are_cut_off(tmp_path: Path) -> None:
    folder = campaign(tmp_path)
    planner = Planner(folder, Counting(), Space())
    first, second = planner.take(2)
    store(folder, [row_of(first)])
    with shard(folder.folder, "worker").open("a") as file:
        file.write(row_of(second).to_line()[:-5])
    folder, planner = again(folder, Counting())
    assert planner.take(1) == [second]
    store(folder, [row_of(second)])
    folder, planner = again(folder, Counting())
    assert planner.take(1)[0].number == 3
    folder.close()


def test_invalid_lines_are_reported_with_their_place(tmp_path: Path) -> None:
    folder = campaign(tmp_path)
    store(folder, [])
    shard(folder.folder, "worker").write_text('{"run": 1}\n')
    with pytest.raises(UsageError, match=r"worker.jsonl:1: invalid row"):
        Planner(folder, Counting(), Space())
    folder.close()


def test_two_coordinators_on_one_folder_are_refused(tmp_path: Path) -> None:
    folder = campaign(tmp_path)
    with pytest.raises(UsageError, match="another process runs the campaign"):
        CampaignFolder(folder.folder, folder.campaign)
    folder.close()


def test_another_campaign_is_replaced_only_on_request(tmp_path: Path) -> None:
    folder = campaign(tmp_path)
    store(folder, [row_of(Planned(1, 1, 1, 7, {}, ""))])
    folder.close()
    with pytest.raises(UsageError, match="contains another campaign"):
        campaign(tmp_path)
    replaced = create_folder(tmp_path / "out", CAMPAIGN, overwrite=True)
    assert not list((tmp_path / "out" / "runs").iterdir())
    replaced.close()


def test_rows_and_plans_survive_their_text() -> None:
    planned = Planned(3, 2, 1, 5, {"a": "1m", "text": '"ä\n"'}, "grid", parent=1, attempt=2)
    assert Planned.from_line(planned.to_line()) == planned
    row = replace(row_of(planned, End.FAILED), values={"a": 1.0}, measured={"r.x": None}, margin=-0.5)
    assert Row.from_line(row.to_line()) == row


def test_characters_that_utf_8_cannot_encode_are_escaped_in_the_table(tmp_path: Path) -> None:
    folder = campaign(tmp_path)
    store(folder, [replace(row_of(Planned(1, 1, 1, 7, {}, "")), reason="no file \udc80.png")])
    assert r"no file \udc80.png" in write_table(RowIndex(folder.folder), folder.folder).read_text(encoding="utf-8")
    folder.close()
