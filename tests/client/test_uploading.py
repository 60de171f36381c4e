"""Uploads of files to an executor: losses and interruptions only cost time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor, Unavailable
from seoro.bundle.pack import Bundle, pack
from seoro.client.sending import TIMES, upload
from seoro.embed.options import Options
from seoro.embed.scenarios import check_file
from seoro.errors import BackendRefused
from tests.executors import HELLO, NAME, RunningExecutor, executor


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x")) as running:
        yield running


@pytest.fixture
def bundle(tmp_path: Path) -> Bundle:
    """Return a bundle with a file of three parts, which no other test sends."""
    libraries = tmp_path / "seoro.libraries"
    libraries.mkdir()
    (libraries / "mine.osc").write_text("action nothing\n")
    (libraries / "mine.py").write_text(f"# {tmp_path} {'x' * (2 * wire.CHUNK)}\n")
    file = tmp_path / "hello.osc"
    file.write_text(f"import osc.mine\n{HELLO}")
    return pack(check_file(file, import_python=False).without_errors(), Options())


async def lacking(executor: Executor, bundle: Bundle) -> tuple[str, ...]:
    return (await executor.ask(wire.MISSING_BLOBS, wire.Hashes(hashes=tuple(bundle.blobs)))).hashes


async def test_parts_without_an_answer_are_sent_again(
    lab: RunningExecutor, bundle: Bundle, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, answered = Executor._ask_once, list[int]()

    async def lossy(self: Executor, verb: Any, request: Any, wait: float) -> Any:
        answer = await whole(self, verb, request, wait)
        if isinstance(request, wire.PutBlob) and request.offset not in answered:
            answered.append(request.offset)
            raise Unavailable("the answer is lost")
        return answer

    monkeypatch.setattr(Executor, "_ask_once", lossy)
    async with seoro.Client(lab.endpoint) as client:
        there = await client._named(NAME)
        await upload(there, bundle)
        assert len(answered) == 3
        assert await lacking(there, bundle) == ()


async def test_two_clients_upload_the_same_files_at_once(lab: RunningExecutor, bundle: Bundle) -> None:
    async with seoro.Client(lab.endpoint) as one, seoro.Client(lab.endpoint) as other:
        there = await one._named(NAME)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(upload, there, bundle)
            tasks.start_soon(upload, await other._named(NAME), bundle)
        assert await lacking(there, bundle) == ()


@pytest.mark.parametrize("times", [1, TIMES])
async def test_an_upload_restarts_when_its_earlier_parts_are_lost(
    lab: RunningExecutor, bundle: Bundle, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    whole, disturbed = Executor._ask_once, list[int]()

    async def disturbing(self: Executor, verb: Any, request: Any, wait: float) -> Any:
        if isinstance(request, wire.PutBlob) and request.offset == wire.CHUNK and len(disturbed) < times:
            disturbed.append(request.offset)
            lie = request.model_copy(update={"offset": 0, "size": 2, "data": b"x"})
            await whole(self, verb, lie, wait)
        return await whole(self, verb, request, wait)

    monkeypatch.setattr(Executor, "_ask_once", disturbing)
    async with seoro.Client(lab.endpoint) as client:
        there = await client._named(NAME)
        if times < TIMES:
            await upload(there, bundle)
            assert await lacking(there, bundle) == ()
        else:
            with pytest.raises(BackendRefused, match="part of a blob at byte"):
                await upload(there, bundle)
