"""Records in parts of replies: any lost part is requested again."""

from collections.abc import AsyncGenerator, Iterator
from pathlib import Path
from typing import Any

import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor, Unavailable
from tests.executors import MANY, NAME, RunningExecutor, executor


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x")) as running:
        yield running


async def watched(lab: RunningExecutor, folder: Path) -> list[int]:
    """Run a scenario on the real clock, and return the record numbers that its watcher received."""
    file = folder / "many.osc"
    file.write_text(MANY)
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file)
        numbers = [record["seq"] async for record in run.records()]
        assert (await run.result()).passed
    return numbers


async def test_lost_parts_of_an_answer_are_requested_again(
    lab: RunningExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, lost = Executor.ask_in_parts, []

    async def lossy(self: Executor, *arguments: Any) -> AsyncGenerator[Any, None]:
        async for number, found in _numbered(whole(self, *arguments)):
            if isinstance(found, wire.NewRecords) and number % 7 == 6:
                lost.append(found)
            else:
                yield found

    monkeypatch.setattr(Executor, "ask_in_parts", lossy)
    numbers = await watched(lab, tmp_path)
    assert lost
    assert numbers == list(range(len(numbers)))


async def test_an_interrupted_answer_is_requested_again(
    lab: RunningExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, broken = Executor.ask_in_parts, []

    async def breaking(self: Executor, *arguments: Any) -> AsyncGenerator[Any, None]:
        async for number, found in _numbered(whole(self, *arguments)):
            if number == 20:
                broken.append(found)
                raise Unavailable("the connection is lost")
            yield found

    monkeypatch.setattr(Executor, "ask_in_parts", breaking)
    numbers = await watched(lab, tmp_path)
    assert broken
    assert numbers == list(range(len(numbers)))


async def _numbered(parts: AsyncGenerator[Any, None]) -> AsyncGenerator[tuple[int, Any], None]:
    number = 0
    async for part in parts:
        yield number, part
        number += 1
