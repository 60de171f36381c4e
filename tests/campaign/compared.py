"""Campaigns with draw_ends differences, to compare."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from random import Random

from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import RUNS, read_campaign, write_campaign
from tests.campaign.generated import generate


def write(folder: Path, rows: Iterable[Row], **changes: object) -> Path:
    """Write a campaign; returns its folder.

    Args:
        folder: Its folder, which is made.
        rows: Its rows.
        changes: Other fields of `campaign.json`.
    """
    folder.mkdir()
    generate(folder, 0)
    campaign = read_campaign(folder)
    write_campaign(folder, campaign.model_copy(update=changes))
    (folder / RUNS / "worker.jsonl").write_text("".join(row.to_line() for row in rows))
    return folder


def rows(ends: Iterable[End], first_seed: int = 1) -> Iterator[Row]:
    """Yield rows of random runs; their loads and seeds follow from their numbers."""
    for number, end in enumerate(ends, start=1):
        yield Row(
            run=number,
            id="",
            variant=number,
            repeat=1,
            seed=first_seed + number,
            status=end,
            values={"load": number / 1000},
            duration=10.0 + number / 1000,
            reason="" if end is End.PASSED else "<too> slow",
            trace_sha=f"{number}",
        )


def draw_ends(
    random: Random, runs: int, broken: float = 0.0, unstable: float = 0.0
) -> tuple[list[End], list[End]]:
    """Draw the ends of two campaigns whose runs are of different difficulty.

    Args:
        random: Source of random numbers.
        runs: Number of runs.
        broken: Share of runs that fail in the second campaign, although they passed in the first.
        unstable: Share of runs that are drawn again in the second campaign, so that they change by chance.
    """

    def drawn(rate: float) -> End:
        return End.PASSED if random.random() < rate else End.FAILED

    first, second = [], []
    for _ in range(runs):
        rate = random.betavariate(9.5, 0.5)
        first.append(drawn(rate))
        end = drawn(rate) if random.random() < unstable else first[-1]
        second.append(End.FAILED if random.random() < broken else end)
    return first, second
