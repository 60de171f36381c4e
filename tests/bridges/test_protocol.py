"""The protocol from the outside: its schema, recorded bytes, and a node without code of seoro."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgpack
import pydantic
import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.session import open_session
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.wire.schema import FILE, schema_text
from seoro.cli.main import main
from seoro.errors import UsageError
from seoro.runtime.verdict import RunStatus
from tests.routers import process

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples/minimal_node"
RECORDED = ROOT / "seoro/bridges/wire/protocol.exchanges.jsonl"
IS_PINNED = f"pydantic=={pydantic.VERSION}" in (ROOT / "constraints.txt").read_text().splitlines()
UPDATES = bool(os.environ.get("SEORO_UPDATE_GOLDENS"))
Exchange = tuple[str, bytes, bytes]
"""Verb, request and reply."""


@pytest.fixture
def endpoint(tmp_path: Path) -> Iterator[str]:
    """Start the minimal node."""
    address = f"unixsock-stream/{tmp_path}/node"
    with process(str(EXAMPLE / "minimal_node.py"), address):
        yield address


def recorded() -> list[Exchange]:
    lines = [json.loads(line) for line in RECORDED.read_text().splitlines()]
    return [(each["verb"], bytes.fromhex(each["request"]), bytes.fromhex(each["reply"])) for each in lines]


def asked(exchange: Exchange) -> tuple[str, dict[str, Any]]:
    """Return the verb and the request, without ids that each run chooses."""
    verb, request, _ = exchange
    return verb, {name: value for name, value in msgpack.unpackb(request).items() if name != "id"}


@pytest.mark.skipif(not IS_PINNED, reason="the text depends on the version of pydantic")
def test_the_schema_file_has_all_messages() -> None:
    assert (ROOT / "seoro/bridges/wire" / FILE).read_text() == schema_text(), "run `make goldens`"


def test_a_node_without_code_of_seoro_conforms(endpoint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-node", endpoint]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "simulator 'minimal', level `drive`:"
    assert lines[-1] == "0 of 6 rules broken: conforms to level `drive`"


def test_missing_verbs_of_a_level_are_listed(endpoint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-node", endpoint, "--level", "entities", "--json"]) == 1
    result = json.loads(capsys.readouterr().out)
    assert not result["conforms"]
    broken = [each["rule"] for each in result["rules"] if not each["holds"]]
    assert "The node serves the verb `spawn_entity`." in broken


def test_a_scenario_runs_on_a_node_without_code_of_seoro(endpoint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    exchanges: list[Exchange] = []
    query = NodeAddress.query

    async def recording(self: NodeAddress, verb: wire.Verb[Any, Any], payload: bytes, *rest: Any) -> bytes:
        reply = await query(self, verb, payload, *rest)
        exchanges.append((verb.name, payload, reply))
        return reply

    monkeypatch.setattr(NodeAddress, "query", recording)
    scenario = seoro.load(EXAMPLE / "drive.osc")
    verdict = seoro.run(scenario, simulator=seoro.Simulator(endpoint=endpoint), seed=0)
    assert verdict.status is RunStatus.PASSED, verdict
    assert verdict.duration == pytest.approx(3.5, abs=0.02)
    if UPDATES:
        lines = [
            json.dumps({"verb": verb, "request": request.hex(), "reply": reply.hex()})
            for verb, request, reply in exchanges
        ]
        RECORDED.write_text("\n".join(lines) + "\n")
    assert list(map(asked, exchanges)) == list(map(asked, recorded()))


def test_actions_without_their_verbs_are_refused_before_the_run(endpoint: str, tmp_path: Path) -> None:
    scenario = tmp_path / "main.osc"
    scenario.write_text(
        "import osc.nav2\nimport osc.sensors\nscenario main:\n    robot: differential_drive_robot\n"
        "    do robot.wait_for_force('wrist', above: 20N)\n"
    )
    with pytest.raises(UsageError, match=r"`robot\.wait_for_force`: it does not serve `watch_force`"):
        seoro.run(seoro.load(scenario), simulator=seoro.Simulator(endpoint=endpoint))


def test_recorded_bytes_are_read_and_written_again() -> None:
    for name, request, reply in recorded():
        verb = wire.NODE_VERBS[name]
        assert wire.encode(verb.read(request)) == request
        verb.read_reply(reply)


async def test_a_node_answers_recorded_requests_as_recorded(endpoint: str) -> None:
    async with open_session(connect=endpoint) as session:
        for verb, request, reply in recorded():
            found = await session.query(wire.node_command(wire.NAMESPACE, "minimal", verb), request, 10.0)
            assert msgpack.unpackb(found) == approximately(msgpack.unpackb(reply)), verb


def approximately(value: Any) -> Any:
    """Return a value that equals others with numbers that differ by rounding."""
    match value:
        case dict():
            return {key: approximately(each) for key, each in value.items()}
        case list():
            return [approximately(each) for each in value]
        case float():
            return pytest.approx(value, abs=1e-12)
    return value
