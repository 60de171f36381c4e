"""`seoro replay`."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

import seoro
from seoro.cli.main import main

SCENARIO = """import osc.types
import osc.helpers

scenario other:
    do wait elapsed(1s)

scenario main:
    n: int
    event ask
    event go(name: string)
    do serial:
        wait elapsed([1s..9s])
        emit ask
        wait @go
        log("went")
"""


async def record(folder: Path) -> list[dict[str, Any]]:
    scenario = seoro.load(folder / "main.osc")
    async with (
        seoro.start(
            scenario, name="main", seed=5, clock="virtual", overrides={"n": 3}, external=["go"], keep_trace=True
        ) as run,
        run.subscribe("ask") as asks,
    ):
        await anext(asks)
        await run.emit("go", name="Ada")
        await run.result()
        return [record async for record in run.trace()]


@pytest.fixture
def recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """The trace of a run with an application, also as a file in the working directory."""
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(SCENARIO)
    records = asyncio.run(record(Path()))
    Path("trace.jsonl").write_text("".join(json.dumps(each) + "\n" for each in records))
    return records


def without_wall(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: value for name, value in record.items() if name != "wall"} for record in records]


def test_a_replay_gives_the_same_trace(recorded: list[dict[str, Any]]) -> None:
    assert main(["replay", "trace.jsonl", "main.osc", "--trace", "again.jsonl"]) == 0
    again = [json.loads(line) for line in Path("again.jsonl").read_text().splitlines()]
    assert without_wall(again) == without_wall(recorded)


def test_options_take_precedence_over_the_trace(recorded: list[dict[str, Any]]) -> None:
    arguments = ["--set", "n=4", "--seed", "6", "--trace", "again.jsonl"]
    main(["replay", "trace.jsonl", "main.osc", *arguments])
    first = json.loads(Path("again.jsonl").read_text().splitlines()[0])
    assert (first["seed"], first["overrides"], first["scenario"]) == (6, {"n": "4"}, "main")


def test_a_trace_that_cannot_be_replayed(
    recorded: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", "none.jsonl", "main.osc"]) == 2
    assert "cannot read the trace none.jsonl" in capsys.readouterr().err
    Path("main.osc").write_text(SCENARIO.replace("go", "start_now"))
    assert main(["replay", "trace.jsonl", "main.osc"]) == 2
    assert "unknown event `main.go`" in capsys.readouterr().err
