"""Conditions that hold under all faults."""

from __future__ import annotations

import sys
from typing import Any

import anyio

from seoro.client.runs import RemoteRun

DEADLINE = 60.0  # [s]


def check_once(records: list[dict[str, Any]]) -> None:
    """All that was recorded of a run that has ended is there, and once."""
    check_sequence(records)
    assert [record["kind"] for record in records].count("run.start") == 1
    assert records[-1]["kind"] == "run.end"


def check_sequence(records: list[dict[str, Any]]) -> None:
    """None is lost, and none doubled."""
    assert [record["seq"] for record in records] == list(range(len(records)))


async def follow(run: RemoteRun) -> list[dict[str, Any]]:
    """Follow a run to its end, which it passes."""
    with anyio.fail_after(DEADLINE):
        records = [record async for record in run.records()]
        verdict = await run.result()
    assert verdict.passed, verdict.reason
    check_once(records)
    return records


def measured(text: str) -> None:
    """Print measured values for the documentation; `pytest -s` shows them."""
    sys.stdout.write(f"\n{text}\n")
