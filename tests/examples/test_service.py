"""The example of a service, served by uvicorn on the loopback interface."""

import asyncio
import importlib.util
import json
import re
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import httpx
import pytest
import uvicorn

FOLDER = Path(__file__).parents[2] / "examples" / "service"
ENDLESS = "import osc.types\nscenario main:\n    do wait elapsed(1h)\n"

Serve = Callable[..., AbstractAsyncContextManager[httpx.AsyncClient]]


@pytest.fixture(scope="module")
def service() -> ModuleType:
    """Import the module of the example."""
    specification = importlib.util.spec_from_file_location("example_service", FOLDER / "service.py")
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # its dataclasses look themselves up there
    specification.loader.exec_module(module)
    return module


@pytest.fixture
def serve(service: ModuleType, tmp_path: Path) -> Serve:
    """Serve a folder of scenarios with an endless one and an invalid one."""
    (tmp_path / "patrol.osc").write_text((FOLDER / "scenarios" / "patrol.osc").read_text())
    (tmp_path / "endless.osc").write_text(ENDLESS)
    (tmp_path / "bad.osc").write_text("scenario main:\n    do serial:\n        one()\n        two()\n")

    @asynccontextmanager
    async def serving(**limits: Any) -> AsyncIterator[httpx.AsyncClient]:
        app = service.create_app(tmp_path, service.Limits(**limits))
        server = service.Server(uvicorn.Config(app, host="127.0.0.1", port=0, log_level="error"))
        task = asyncio.create_task(server.serve())
        while not server.started:
            await asyncio.sleep(0.01)
        port = server.servers[0].sockets[0].getsockname()[1]
        try:
            async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=10) as client:
                yield client
        finally:
            server.should_exit = True
            await asyncio.wait_for(task, 30.0)

    return serving


async def start(client: httpx.AsyncClient, **order: Any) -> dict[str, Any]:
    """Start a run."""
    answer = await client.post("/runs", json=order)
    assert answer.status_code == 201, answer.text
    found: dict[str, Any] = answer.json()
    return found


async def trace(client: httpx.AsyncClient, number: str, **headers: str) -> list[dict[str, Any]]:
    """Return the trace of a run, to its end."""
    async with client.stream("GET", f"/runs/{number}/trace", headers=headers) as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        lines = [line async for line in answer.aiter_lines()]
    return [json.loads(line.removeprefix("data: ")) for line in lines if line.startswith("data: ")]


async def wait_for_end(client: httpx.AsyncClient, number: str) -> dict[str, Any]:
    """Return the state of a run after its end."""
    await trace(client, number)
    found: dict[str, Any] = (await client.get(f"/runs/{number}")).json()
    return found


async def test_a_run_can_be_started_and_followed_to_its_verdict(serve: Serve) -> None:
    async with serve() as client:
        assert (await client.get("/scenarios")).json() == ["bad.osc", "endless.osc", "patrol.osc"]
        run = await start(client, scenario="patrol.osc", seed=7, parameters={"pause": "1500ms"})
        assert (run["seed"], run["parameters"]) == (7, {"rounds": 3, "pause": 1.5})
        records = await trace(client, run["id"])
        assert [record["seq"] for record in records] == list(range(len(records)))
        assert [record["t"] for record in records if record["kind"] == "log"] == [1.5, 3.0, 4.5]
        assert (await wait_for_end(client, run["id"]))["status"] == "passed"
        assert await trace(client, run["id"], **{"Last-Event-ID": "4"}) == records[5:]
        assert [found["id"] for found in (await client.get("/runs")).json()] == [run["id"]]


async def test_a_run_can_be_stopped(serve: Serve) -> None:
    async with serve() as client:
        run = await start(client, scenario="endless.osc", clock="real")
        assert run["status"] == "running"
        reading = asyncio.create_task(trace(client, run["id"]))
        stopped = (await client.delete(f"/runs/{run['id']}")).json()
        assert (stopped["status"], stopped["reason"]) == ("cancelled", "stopped by a client")
        assert (await reading)[-1]["kind"] == "run.end"


async def test_a_disconnected_client_does_not_stop_the_run(serve: Serve) -> None:
    async with serve() as client:
        run = await start(client, scenario="endless.osc", clock="real")
        async with client.stream("GET", f"/runs/{run['id']}/trace") as answer:
            await anext(answer.aiter_lines())
        assert (await client.get(f"/runs/{run['id']}")).json()["status"] == "running"


async def test_a_run_beyond_the_limit_is_refused(serve: Serve) -> None:
    async with serve(running=2) as client:
        for _ in range(2):
            await start(client, scenario="endless.osc", clock="real")
        refused = await client.post("/runs", json={"scenario": "patrol.osc"})
        assert (refused.status_code, "limit 2" in refused.text) == (429, True)


async def test_runs_beyond_the_limit_are_forgotten(serve: Serve) -> None:
    async with serve(kept=1, seconds=0.2) as client:
        first = await start(client, scenario="endless.osc", clock="real")
        ended = await wait_for_end(client, first["id"])
        assert (ended["status"], ended["reason"]) == ("cancelled", "it takes more than 0.2 s")
        for _ in range(3):
            last = await start(client, scenario="patrol.osc")
            await wait_for_end(client, last["id"])
        assert (await client.get(f"/runs/{first['id']}")).status_code == 404
        large = await client.post("/runs", json={"scenario": "x" * 70_000})
        assert large.status_code == 413


async def test_a_growing_trace_ends_the_run(serve: Serve, service: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "forever.osc").write_text(
        "import osc.types\nimport osc.helpers\nscenario main:\n    do serial:\n        wait elapsed(1ms)\n"
        "    with:\n        repeat()\n"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(service, "MAX_RECORDS", 500)
        async with serve() as client:
            run = await start(client, scenario="forever.osc")
            ended = await wait_for_end(client, run["id"])
    assert (ended["status"], ended["reason"]) == ("cancelled", "its trace has more than 500 records")


@pytest.mark.parametrize(
    ("order", "status", "message"),
    [
        ({"scenario": "../secret.osc"}, 404, "unknown scenario file"),
        ({"scenario": "/etc/hosts"}, 404, "unknown scenario file"),
        ({"scenario": "bad.osc"}, 422, "bad.osc:4:9"),
        ({"scenario": "patrol.osc", "name": "other"}, 422, "unknown scenario `other`"),
        ({"scenario": "patrol.osc", "parameters": {"pause": "3kg"}}, 422, "error"),
        ({"scenario": "patrol.osc", "sim": "mujoco"}, 422, "Extra inputs"),
        ({"scenario": "patrol.osc", "seed": -1}, 422, "greater than or equal to 0"),
        ({}, 422, "Field required"),
    ],
)
async def test_invalid_runs_are_refused(serve: Serve, order: dict[str, Any], status: int, message: str) -> None:
    async with serve() as client:
        answer = await client.post("/runs", json=order)
        assert answer.status_code == status
        assert message in answer.text
        assert (await client.get("/runs")).json() == []


async def test_requests_from_other_hosts_are_refused(serve: Serve) -> None:
    async with serve() as client:
        answer = await client.get("/runs", headers={"host": "evil.example"})
        assert answer.status_code == 400
        assert (await client.get("/runs/nonsense")).status_code == 404


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_stops_the_runs_and_ends_their_streams(tmp_path: Path, number: signal.Signals) -> None:
    (tmp_path / "endless.osc").write_text(ENDLESS)
    command = [sys.executable, str(FOLDER / "service.py"), "--folder", str(tmp_path), "--port", "0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            found = None
            while found is None:
                line = process.stderr.readline()
                assert line, "the service did not start"
                found = re.search(r"running on (http://127\.0\.0\.1:\d+)", line)
            with httpx.Client(base_url=found[1], timeout=10) as client:
                run = client.post("/runs", json={"scenario": "endless.osc", "clock": "real"}).json()
                with client.stream("GET", f"/runs/{run['id']}/trace") as answer:
                    lines = answer.iter_lines()
                    next(lines)
                    process.send_signal(number)
                    last = [line for line in lines if line.startswith("data: ")][-1]
            ended = json.loads(last.removeprefix("data: "))
            assert (ended["kind"], ended["status"]) == ("run.end", "cancelled")
            assert ended["reason"] == "the service is shut down"
            _, err = process.communicate(timeout=30)
            assert "Traceback" not in err or "KeyboardInterrupt" in err
        finally:
            process.kill()
