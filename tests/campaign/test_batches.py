"""Rows in batches equal single rows, also those of unusual lines."""

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import seoro.campaign
from seoro.campaign import planner
from seoro.campaign.places import Places
from seoro.campaign.report.reservoir import Reservoir
from seoro.campaign.runs import End, Row
from seoro.campaign.starting import reopened
from seoro.campaign.state import State
from seoro.campaign.store import lines
from seoro.campaign.store.batches import Batch, read_batches
from seoro.campaign.store.folder import COORDINATOR, RUNS, read_campaign, read_rows
from seoro.errors import UsageError
from tests.campaign.generated import generate, row, rows, store

ITEM = {"item": "main.way", "kind": "cover", "buckets": {"coverage": 1}}
ODD = [
    row(1, values={"way": {"x": 1.0, "coverage": [1, 2]}, "coverage": ["}"]}, coverage=(ITEM,)),
    row(2, reason=', "coverage": [{', measured={"a": '"}\n', "coverage": [[]]}, coverage=(ITEM, ITEM)),
    row(3, End.IMPOSSIBLE, reason="\ud800", coverage=({"buckets": {"\ud800": 2}},)),
    row(4, End.ERROR, duration=float("inf"), margin=-1.5),
]


def of_batches(folder: Path) -> Iterator[Row]:
    """Yield rows as their batches have them."""
    for batch in read_batches(folder):
        ends = {position: end for end, positions in batch.ends.items() for position in positions}
        coverage = {at: tuple(items) for items, places in batch.coverage(range(len(batch))) for at in places}
        for position in range(len(batch)):
            fields: dict[str, Any] = {name: batch.column(name)[position] for name in Row.__match_args__[:-1]}
            made = Row(**fields | {"status": ends[position], "coverage": coverage[position]})
            assert made == batch.row(position)
            yield made


@pytest.mark.parametrize("block", [1, 1500, 1 << 20])
def test_batches_have_the_rows_of_a_campaign(block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "_READ", block)
    store(tmp_path, "w1", [*ODD, *rows(20), row(3)])
    store(tmp_path, "w2", [*rows(30)])
    store(tmp_path, COORDINATOR, [row(2, End.ERROR), row(40, End.ERROR)])
    with (tmp_path / RUNS / "w2.jsonl").open("a") as shard:
        shard.write(json.dumps(dict(reversed(json.loads(row(50).to_line()).items()))) + "\n")
        shard.write(row(51).to_line().replace(', "strategy": ""', ""))  # of an older version
        shard.write(row(52).to_line()[:-3])  # torn
    found = list(of_batches(tmp_path))
    assert found == list(read_rows(tmp_path))
    assert [each.run for each in found] == [*range(1, 31), 50, 51, 40]


@pytest.mark.parametrize(
    ("old", "new"), [("passed", "past"), ('"passed"', "[]"), ("values", "walues"), ("{", "[")]
)
def test_an_invalid_row_in_a_batch_is_named(old: str, new: str, tmp_path: Path) -> None:
    store(tmp_path, "w1", [row(1), row(2)])
    with (tmp_path / RUNS / "w1.jsonl").open("a") as shard:
        shard.write(row(3).to_line().replace(old, new))
    with pytest.raises(UsageError, match=r"w1\.jsonl:3: invalid row"):
        list(read_batches(tmp_path))


def test_equal_coverage_is_decoded_once() -> None:
    given = [row(number, coverage=(ITEM,) * (1 + number % 2)).to_line().encode() for number in range(100)]
    found = list(Batch(given, str).coverage(range(10, 20)))
    assert [(len(items), positions) for items, positions in found] == [
        (1, [10, 12, 14, 16, 18]),
        (2, [11, 13, 15, 17, 19]),
    ]


def test_each_item_is_in_a_sample_equally_often() -> None:
    counts: Counter[int] = Counter()
    for seed in range(2000):
        reservoir: Reservoir[int] = Reservoir(5, seed)
        for start in range(0, 40, 8):
            reservoir.extend(range(start, start + 8))
        assert len(set(reservoir.items)) == 5 and reservoir.count == 40
        counts.update(reservoir.items)
    assert len(counts) == 40
    assert all(abs(count - 250) < 5 * 15 for count in counts.values()), "five standard deviations"


@pytest.mark.parametrize("until", [(), ("coverage 25%",), ("rate >= 0.9", "10 failures")])
def test_a_state_from_batches_is_that_of_single_rows(until: tuple[str, ...], tmp_path: Path) -> None:
    generate(tmp_path, 0)
    campaign = read_campaign(tmp_path).model_copy(update={"until": until})
    given = [*rows(300), row(301, End.IMPOSSIBLE), row(303, End.ERROR)]
    store(tmp_path, "w1", given[150:])
    store(tmp_path, "w2", given[:150])
    single, found = State(campaign, ()), State(campaign, read_batches(tmp_path))
    for each in given:
        single.record(each)
    assert (found.tally.ends, found.tally.impossible) == (single.tally.ends, 1)
    assert found.watch.stop == single.watch.stop and (found.watch.stop is None) == (not until)
    assert (found.watch.passed, found.watch.failed) == (single.watch.passed, single.watch.failed)
    assert counts_of(found) == counts_of(single)


def counts_of(state: State) -> object:
    """Return the counts of all buckets, and how many have enough samples."""
    (item,) = state.watch.coverage.items.values()
    buckets = {name: (each.samples, each.passed, each.failed, each.first) for name, each in item.buckets.items()}
    return buckets, item.reached


async def test_the_rows_of_an_earlier_session_are_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, folder = tmp_path / "main.osc", tmp_path / "out"
    file.write_text("import osc.helpers\nscenario main:\n    do log('x')\n")
    async with seoro.campaign.start(file, clock="virtual", repeat=3, jobs=1, folder=folder) as first:
        await first.wait()
    read: list[Path] = []

    def reading(each: Path) -> Iterator[Batch]:
        read.append(each)
        return read_batches(each)

    monkeypatch.setattr(planner, "read_batches", reading)
    campaign, _ = reopened(folder, 5, Places(jobs=1))
    assert read == [folder] and campaign.tally.runs == 3
    campaign._opened.close()
