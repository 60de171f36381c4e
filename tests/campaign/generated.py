"""Campaigns with generated rows, for reports."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from seoro.bridges.executor.messages import BundledOptions, BundleFile, Manifest
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.store.folder import ASKED, RUNS, CampaignFile, StrategyText, write_campaign

VARIED = """import osc.types
import osc.helpers

scenario main:
    noise: float with:
        keep(it in [0.0..0.2])
    record(noise)
    do serial:
        wait elapsed(1h)
        compare(noise, "<", 0.19)
"""


def campaign_of(runs: int) -> CampaignFile:
    """Return the `campaign.json` of a sample."""
    file = BundleFile(path="maze.osc", hash="0" * 64, size=1)
    manifest = Manifest(
        files=(file,), entry="maze.osc", shown="maze.osc", options=BundledOptions(overrides={}, grace=5.0)
    )
    return CampaignFile(
        manifest=manifest,
        strategy=StrategyText(name="random", options={}),
        runs=runs,
        repeat=1,
        seed=1,
        keep="failed",
        isolation="worker",
        digest="0" * 64,
        simulator="mujoco",
        version="0",
        is_sample=True,
    )


def generate(folder: Path, runs: int) -> None:
    """Write a campaign whose runs fail for large loads, and more often on slippery ground.

    Args:
        folder: Empty folder for the campaign.
        runs: Number of rows.
    """
    (folder / RUNS).mkdir()
    write_campaign(folder, campaign_of(runs))
    with (folder / RUNS / "worker.jsonl").open("w") as shard, (folder / ASKED).open("w") as asked:
        for row in rows(runs):
            shard.write(row.to_line())
            texts = {path: str(value) for path, value in row.values.items()}
            asked.write(Planned(row.run, row.variant, row.repeat, row.seed, texts, "random").to_line())


def store(folder: Path, name: str, rows: Iterable[Row]) -> None:
    """Write a shard."""
    (folder / RUNS).mkdir(exist_ok=True)
    text = "".join(each.to_line() for each in rows)
    (folder / RUNS / f"{name}.jsonl").write_text(text, "utf-8", "backslashreplace")


def row(number: int, status: End = End.PASSED, **more: Any) -> Row:
    """Return a row without variation."""
    return Row(run=number, id=str(number), variant=number, repeat=1, seed=-1, status=status, **more)


def rows(runs: int) -> Iterator[Row]:
    """Yield generated rows, always the same."""
    draw = random.Random(1)
    for number in range(1, runs + 1):
        load, friction, lights = draw.random(), draw.choice((0.3, 0.5, 0.7, 0.9)), draw.random() < 0.5
        margin = 1.1 - load - 0.2 * (0.9 - friction) + draw.gauss(0.0, 0.03)
        has_passed = margin > 0.0
        closest = max(0.4 * margin + draw.gauss(0.05, 0.02), 0.0)
        yield Row(
            run=number,
            id=f"{number:016x}",
            variant=number,
            repeat=1,
            seed=1,
            status=End.PASSED if has_passed else End.FAILED,
            values={"load": load, "friction": friction, "lights": lights, "floor": draw.choice(("wood", "tile"))},
            duration=20.0 + 10.0 * load,
            wall_duration=0.6,
            cpu=0.1,
            sim_cpu=0.4,
            reason="" if has_passed else f"the robot is {0.1 + closest:.2f} m from the goal",
            reason_key="" if has_passed else "the robot is # m from the goal",
            where="" if has_passed else f"maze.osc:{15 + (number % 7 == 0)}:9",
            margin=margin,
            strategy="random",
            host="lab-a" if number % 3 else "lab-b",
            worker="worker",
            started="2026-01-01T00:00:00.000+00:00",
            version="0",
            folder="" if has_passed else f"kept/{number:06}",
            trace_sha="0" * 64,
            measured={"turtlebot4.closest_approach": closest, "turtlebot4.path_length": 8.0 + 4.0 * draw.random()},
            coverage=(
                {
                    "item": "maze.load", "kind": "cover", "event": "end", "unit": "", "text": "", "target": 1,
                    "buckets": {f"{int(load * 10) / 10:g}..{(int(load * 10) + 1) / 10:g}": 1}, "total": 12,
                    "grade": 0.1, "outside": 0, "ignored": 0, "illegal": 0,
                },
            ),
        )  # fmt: skip
