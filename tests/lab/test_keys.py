"""`seoro lab`, `seoro estop` and runs with keys: at nodes that listen, and behind routers."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.session import (
    Answer,
    AsyncSession,
    NoAnswer,
    NoServer,
    Refused,
    Request,
    Session,
    open_session,
    publishing,
)
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire.refusal import read_refusal
from seoro.cli.main import main
from seoro.errors import BackendLost, UsageError
from seoro.lab.commands import LabCommands
from seoro.lab.status import read_states
from seoro.runtime.contracts.backends import Report
from seoro.security.keys import VARIABLE
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.endpoint_keys import security_of
from seoro.security.network.peers import node_signer
from seoro.security.signing.audit_log import check_log
from seoro.security.signing.commands import prove, sign_emergency_stop
from seoro.security.signing.statements import certificate_der
from tests.bridges.robot.conftest import rails_at
from tests.labs import KeyedLab, command, free_port, make_lab
from tests.relays import Relay, Sent, forward, honest, relaying, unchanged

pytestmark = pytest.mark.anyio

DEADLINE = 30.0  # [s]
WITHIN = 0.3  # [s]
ATTEMPTS = 3
HALL = ("sim", "mujoco", "--world", "hall", "--rate", "1")


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    made = make_lab(tmp_path_factory.mktemp("lab") / "keys")
    for name in ("hall", "rails", "other"):
        made.authority.add(name, Role.NODE, made.keys(name))
    return made


@dataclass(frozen=True)
class Place:
    """A node: its endpoint, its name, one of its robots, and its log."""

    endpoint: str
    node: str
    robot: str
    log: Path

    def entries(self) -> list[tuple[str, str | None, str]]:
        """Return the entries of the valid audit log: request, sender if known, and outcome."""
        checked = check_log(self.log, read_keys(self.log.parents[3] / "keys" / "vera").authority)
        assert checked.writers == (self.node,)
        lines = [json.loads(line) for line in self.log.read_bytes().splitlines()]
        return [(line["what"], line["by"], line.get("outcome", "")) for line in lines]


@pytest.fixture(scope="module")
def places(lab: KeyedLab, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Place]]:
    """Yield a listening simulator, and bridges behind routers with and without access control."""
    ends = {name: f"tls/127.0.0.1:{free_port()}" for name in ("listens", "routed", "open")}
    folders = {name: lab.path.parent / name / "seoro" / "simulators" for name in ends}
    open_hub = Session(listen=ends["open"], security=security_of(ends["open"], read_keys(lab.keys("hub"))))
    router = ("router", "--listen", ends["routed"], "--keys", str(lab.keys("hub")))
    found: dict[str, Place] = {}
    with ExitStack() as stack:
        stack.callback(open_hub.close)
        stack.enter_context(command(lab.path.parent / "router", ends["routed"], *router))
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("XDG_STATE_HOME", str(folders["listens"].parents[1]))
            hall = (*HALL, "--listen", ends["listens"], "--keys", str(lab.keys("hall")))
            stack.enter_context(command(lab.path.parent / "hall", ends["listens"], *hall))
        for name in ("routed", "open"):
            folders[name].mkdir(parents=True)
            rails = rails_at(folders[name], "--connect", ends[name], "line", "second", keys=lab.keys("rails"))
            stack.enter_context(rails)
        for name, endpoint in ends.items():
            (log,) = folders[name].glob("*.jsonl")
            found[name] = Place(endpoint, "hall" if name == "listens" else "rails", "second", log)
        yield found


@pytest.fixture(params=["listens", "routed", "open"])
def place(places: dict[str, Place], request: pytest.FixtureRequest) -> Place:
    return places[request.param]


@pytest.fixture(autouse=True)
def _anna(lab: KeyedLab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, str(lab.keys("anna")))


@asynccontextmanager
async def somebody(lab: KeyedLab, endpoint: str, name: str) -> AsyncIterator[AsyncSession]:
    security = security_of(endpoint, read_keys(lab.keys(name)))
    async with open_session(connect=endpoint, security=security) as session:
        yield session


def seoro(lab: KeyedLab, name: str, capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    status = main([*arguments, "--keys", str(lab.keys(name))])
    found = capsys.readouterr()
    return status, found.out + found.err


def test_an_operator_may_list_lease_release_and_stop(
    place: Place, lab: KeyedLab, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ("--connect", place.endpoint)
    status, out = seoro(lab, "anna", capsys, "lab", "status", *at)
    assert (status, "second" in out) == (0, True)
    for arguments in (
        ("lab", "lease", "second", "--for", "2min"),
        ("lab", "release", "second"),
        ("lab", "stop", "second"),
        ("estop", "--reason", "smoke"),
        ("lab", "release", "--all", "--yes", "--reason", "toast"),
    ):
        status, out = seoro(lab, "anna", capsys, *arguments, *at)
        assert status == 0, out
    verbs = ("lease_robots", "release_lease", "emergency_stop", "release_stop")
    entries = place.entries()
    assert all((verb, "anna", "done") in entries for verb in verbs)


def test_a_viewer_may_list_only_and_refusals_name_the_required_role(
    place: Place, lab: KeyedLab, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ("--connect", place.endpoint)
    status, out = seoro(lab, "vera", capsys, "lab", "status", *at)
    assert (status, "free" in out) == (0, True)
    for arguments, verb in (
        (("lab", "lease", "second"), "lease_robots"),
        (("lab", "stop", "second"), "stop_robot"),
        (("estop", "--reason", "fun"), "emergency_stop"),
        (("lab", "release", "--all", "--yes", "--reason", "fun"), "release_stop"),
    ):
        status, out = seoro(lab, "vera", capsys, *arguments, *at)
        assert status == 3
        assert f"vera (viewer) may not send `{verb}` (required role: operator)" in out
    assert "EMERGENCY" not in seoro(lab, "anna", capsys, "lab", "status", *at)[1]


async def test_raw_requests_of_a_viewer_are_refused_by_the_node(places: dict[str, Place], lab: KeyedLab) -> None:
    """A foreign router passes all requests."""
    place, keys = places["open"], read_keys(lab.keys("vera"))
    requests = {
        wire.TAKE_ROBOTS.name: wire.Holder(holder="run-vera"),
        wire.EMERGENCY_STOP.name: wire.EmergencyStop(by="vera"),
        wire.DRIVE.name: wire.Drive(id="x", robot="second", linear=0.2, angular=0.0, duration=1.0),
        wire.STEP_SIMULATION.name: wire.StepSimulation(steps=1),
    }
    async with somebody(lab, place.endpoint, "vera") as session:
        address = NodeAddress(session, wire.NAMESPACE, place.node, signer=node_signer(session, place.node, keys))
        await address.prove()
        assert address.signer is not None
        for verb, request in requests.items():
            key, payload = wire.node_command(wire.NAMESPACE, place.node, verb), wire.encode(request)
            sealed = sign_emergency_stop(keys, key, payload)
            if verb != wire.EMERGENCY_STOP.name:
                assert address.signer._signer is not None
                sealed = address.signer._signer.sign(key, payload)
            for attachment in (None, wire.encode_sender("run-vera"), sealed):
                with pytest.raises(Refused) as caught:
                    await session.query(key, payload, 5.0, attachment)
                assert read_refusal(caught.value.payload).code == wire.DENIED
        key, payload = wire.emergency_key(wire.NAMESPACE), wire.encode(wire.EmergencyStop(by="vera"))
        async with publishing(session, key) as publisher:
            await publisher.wait_for_subscriber()
            publisher.put(payload)
            publisher.put(payload, sign_emergency_stop(keys, key, payload))
            with anyio.fail_after(DEADLINE):
                while ("emergency_stop", "vera", "refused") not in place.entries():
                    await anyio.sleep(0.01)
        found = await ask(address, wire.GET_LAB_STATE, wire.Empty())
        assert found.stopped is None
    assert not any(by == "vera" and outcome == "done" for _, by, outcome in place.entries())


async def test_replayed_requests_are_refused(places: dict[str, Place], lab: KeyedLab) -> None:
    place, keys = places["open"], read_keys(lab.keys("anna"))
    async with somebody(lab, place.endpoint, "anna") as session:
        signer = node_signer(session, place.node, keys)
        assert signer is not None
        await signer.verify_peer()
        lease = wire.LeaseRobots(lease="hand-1", robots=("second",))
        for verb, request in ((wire.LEASE_ROBOTS, lease), (wire.EMERGENCY_STOP, wire.EmergencyStop(by="anna"))):
            key, payload = wire.node_command(wire.NAMESPACE, place.node, verb.name), wire.encode(request)
            seal = await signer.sign(verb, key, payload)
            await session.query(key, payload, 5.0, seal)
            with pytest.raises(Refused) as caught:
                await session.query(key, payload, 5.0, seal)
            assert "received before" in read_refusal(caught.value.payload).message
        assert [each.error for each in await LabCommands([place.endpoint]).release_all("anna", "over")] == [""]
        address = NodeAddress(session, wire.NAMESPACE, place.node, signer=signer)
        await ask(address, wire.RELEASE_LEASE, wire.ReleaseLease(lease="hand-1"))


async def test_names_of_holders_are_not_disclosed_to_others(places: dict[str, Place], lab: KeyedLab) -> None:
    """Robots accept requests with that name."""
    place = places["open"]
    async with (
        connect_robots(place.endpoint, "", robots=("second",)) as node,
        somebody(lab, place.endpoint, "vera") as vera,
    ):
        name = node._holder.holder
        tokens = await vera.list_tokens("seoro/**", 2.0)
        assert wire.holder_token(wire.NAMESPACE, name) in tokens
        state = await ask(NodeAddress(vera, wire.NAMESPACE, place.node), wire.GET_LAB_STATE, wire.Empty())
        assert any(robot.holder for robot in state.robots)
        assert not any(name in text for text in (*tokens, state.model_dump_json()))


async def test_a_node_with_keys_of_another_node_is_refused(places: dict[str, Place], lab: KeyedLab) -> None:
    """A client with keys of another node can claim a name at a router, but not prove it."""
    place = places["routed"]
    security = security_of(place.endpoint, read_keys(lab.keys("other")))
    forged, keys = Session(connect=place.endpoint, security=security), read_keys(lab.keys("other"))

    def answer(request: Request) -> None:
        if request.key.endswith(wire.GET_LAB_STATE.name):
            request.reply(wire.encode(wire.LabState(kind="bridge", version="0.1.0", robots=())))
            return
        if not request.key.endswith(wire.CHALLENGE.name):
            request.reply(wire.encode(wire.StopAcknowledgement(stopped=(), took=0.0)))
            return
        nonce, exchange = wire.decode(wire.Challenge, request.payload).nonce, bytes(32)
        signature = prove(keys, "floor", nonce, "b00t", 0, exchange)
        certificate = certificate_der(keys.certificate)
        proof = wire.Proof(certificate=certificate, signature=signature, boot="b00t", now=0, exchange=exchange)
        request.reply(wire.encode(proof))

    words = "untrusted: the node 'floor': it answers with the keys of other"
    try:
        forged.answer(wire.node_command(wire.NAMESPACE, "floor", "*"), answer)
        forged.declare_token(wire.node_token(wire.NAMESPACE, "floor", "b00t"))
        with pytest.raises(UsageError, match=words):
            async with connect_robots(place.endpoint, "a run", "floor"):
                pass
        asked = await LabCommands([place.endpoint]).emergency_stop_all("anna", "smoke")
        outcomes = {each.display_name: each for each in asked}
        unsigned = "the answer of the node 'floor' to `emergency_stop` is not authentic: it is not signed"
        assert unsigned in outcomes["the node 'floor'"].error
        assert outcomes["the node 'rails'"].error == ""
        (floor,) = [each for each in await read_states([place.endpoint]) if each.node == "floor"]
        assert words in floor.problem
    finally:
        forged.close()
        await LabCommands([place.endpoint]).release_all("anna", "it was a test")


async def test_an_emergency_stop_with_keys_is_in_time(place: Place) -> None:
    times: list[float] = []
    while len(times) < ATTEMPTS and not (times and min(times) < WITHIN):  # each may be that of a busy machine
        try:
            async with connect_robots(place.endpoint, "a run", robots=("second",)) as node:
                await node.drive("second", 0.2, 0.0, 600.0, lambda report: None)
                (outcome,) = await LabCommands([place.endpoint]).emergency_stop_all("anna", "smoke")
                assert outcome.error == ""
                times.append(outcome.elapsed)
        finally:
            await LabCommands([place.endpoint]).release_all("anna", "it is over")
    assert min(times) < WITHIN


async def test_revoked_keys_are_disconnected_from_a_simulator(places: dict[str, Place], lab: KeyedLab) -> None:
    lab.authority.add("rob", Role.OPERATOR, lab.keys("rob"))
    place = places["listens"]
    key = wire.node_command(wire.NAMESPACE, place.node, wire.GET_LAB_STATE.name)
    async with somebody(lab, place.endpoint, "rob") as rob, somebody(lab, place.endpoint, "anna") as anna:
        await rob.query(key, wire.encode(wire.Empty()), 5.0)
        lab.revoke("rob", "hall")
        with anyio.fail_after(DEADLINE), pytest.raises((NoServer, NoAnswer)):
            while True:
                await rob.query(key, wire.encode(wire.Empty()), 5.0)
        with anyio.fail_after(DEADLINE):
            while True:
                try:
                    await anna.query(key, wire.encode(wire.Empty()), 5.0)
                    break
                except (NoServer, NoAnswer):
                    await anyio.sleep(0.01)
        with pytest.raises((NoServer, NoAnswer)):
            await rob.query(key, wire.encode(wire.Empty()), 5.0)


def test_a_node_name_must_equal_that_of_its_keys(lab: KeyedLab, capsys: pytest.CaptureFixture[str]) -> None:
    where = ("--listen", f"tls/127.0.0.1:{free_port()}", "--keys", str(lab.keys("hall")))
    assert main(["bridge", "ros2", "--robot", "turtlebot4", "--name", "floor", *where]) != 0
    assert "the keys of hall (node) do not fit the node 'floor'" in capsys.readouterr().err


@asynccontextmanager
async def between(lab: KeyedLab, place: Place) -> AsyncIterator[tuple[Relay, str]]:
    """Run a foreign router; yield its endpoint."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    keys = [security_of(endpoint, read_keys(lab.keys(name))) for name in ("hub", "ada")]
    async with relaying(endpoint, place.endpoint, (keys[0], keys[1])) as relay:
        yield relay, endpoint


@pytest.mark.parametrize("name", ["open", "listens"])
async def test_changed_answers_of_nodes_are_detected(places: dict[str, Place], lab: KeyedLab, name: str) -> None:
    """The router, or another server in place of the node, replays requests."""
    place = places[name]
    async with between(lab, place) as (relay, endpoint):
        (member,) = await read_states([endpoint])
        assert (member.problem, member.state is None) == ("", False)
        relay.replace(b"second", b"nobody", "get_lab_state")
        (member,) = await read_states([endpoint])
        unsigned = f"the answer of the node '{place.node}' to `get_lab_state` is not authentic: invalid signature"
        assert unsigned in member.problem
        relay.replace(b"stopped", b"stOpped", "emergency_stop")
        try:
            (outcome,) = await LabCommands([endpoint]).emergency_stop_all("anna", "smoke")
            assert "to `emergency_stop` is not authentic: invalid signature" in outcome.error
            relay.change = unchanged
            (member,) = await read_states([endpoint])
            assert member.state is not None
            assert member.state.stopped is not None  # all the same
        finally:
            relay.change = unchanged
            assert [each.error for each in await LabCommands([endpoint]).release_all("anna", "it was a test")] == [
                ""
            ]


async def test_changed_events_of_robots_are_detected(places: dict[str, Place], lab: KeyedLab) -> None:
    async with between(lab, places["open"]) as (relay, endpoint):
        lost: list[Exception] = []
        reports: list[Report] = []
        async with connect_robots(endpoint, "a run", robots=("second",)) as node:
            await node.start_run(lambda _name, _arguments: None, lost.append)
            await node.drive("second", 0.0, 0.0, 0.05, reports.append)
            with anyio.fail_after(DEADLINE):
                while not reports:
                    await anyio.sleep(0.01)
            relay.replace(b"succeeded", b"SUCCEEDED", "hold_robots")
            await node.drive("second", 0.0, 0.0, 0.05, reports.append)
            with anyio.fail_after(DEADLINE):
                while not lost:
                    await anyio.sleep(0.01)
        assert "to `hold_robots` is not authentic: invalid signature" in str(lost[0])
        assert len(reports) == 1


async def test_a_changed_time_of_a_simulator_is_detected(places: dict[str, Place], lab: KeyedLab) -> None:
    options = SimulatorOptions(None, 1, ModelPath())
    async with (
        between(lab, places["listens"]) as (relay, endpoint),
        connect_simulator(endpoint, options) as node,
    ):
        assert await node.advance(0.1) == pytest.approx(0.1)
        kept: list[Answer] = []

        def keep(verb: str, answers: list[Answer]) -> list[Answer]:
            kept.extend(answers if verb == wire.ADVANCE.name else ())
            return answers

        relay.change = keep
        await node.advance(0.2)
        relay.change = lambda verb, answers: kept if verb == wire.ADVANCE.name else answers
        with pytest.raises(BackendLost, match="to `advance` is not authentic: invalid signature"):
            await node.advance(0.3)


async def test_requests_of_a_router_move_no_robot_of_a_run(places: dict[str, Place], lab: KeyedLab) -> None:
    """Forged, changed and repeated requests of the run are refused."""
    place = places["open"]
    drive = wire.Drive(id="run.x", robot="second", linear=0.2, angular=0.0, duration=600.0)
    async with between(lab, place) as (relay, endpoint), somebody(lab, place.endpoint, "ada") as router:
        seen: list[Sent] = []

        def keep(sent: Sent) -> Sent:
            seen.append(sent)
            return sent

        relay.forge = keep
        async with connect_robots(endpoint, "a run", robots=("second",)) as node:
            goal = await node.drive("second", 0.2, 0.0, 600.0, lambda report: None)
            await node.cancel_goal(goal)
            name = wire.encode_sender(node._holder.holder)
            driven = next(sent for sent in seen if sent.verb == wire.DRIVE.name)
            held = next(sent for sent in reversed(seen) if sent.verb == wire.HOLD_ROBOTS.name)
            ending = wire.encode(wire.Holder(holder=node._holder.holder))
            forged = (
                driven,
                held,
                replace(driven, payload=wire.encode(drive)),
                replace(driven, payload=wire.encode(drive), attachment=name),
                replace(
                    driven, key=driven.key.replace("drive", "release_robots"), payload=ending, attachment=name
                ),
            )
            for sent in forged:
                (answer,) = await forward(router, sent)
                assert read_refusal(answer.payload).code == wire.DENIED
            relay.forge = lambda sent: replace(sent, payload=wire.encode(drive)) if sent.verb == "drive" else sent
            with pytest.raises(BackendLost, match="to `drive` is not authentic"):
                await node.drive("second", 0.1, 0.0, 600.0, lambda report: None)
            relay.forge = honest
            goal = await node.drive("second", 0.0, 0.0, 600.0, lambda report: None)  # it still holds the robot
            await node.cancel_goal(goal)
    assert any((what, by, outcome) == ("drive", None, "refused") for what, by, outcome in place.entries())


async def test_requests_of_a_router_do_not_advance_a_simulator(places: dict[str, Place], lab: KeyedLab) -> None:
    place = places["listens"]
    async with (
        between(lab, place) as (relay, endpoint),
        somebody(lab, place.endpoint, "ada") as router,
        connect_simulator(endpoint, SimulatorOptions(None, 1, ModelPath())) as node,
    ):
        seen: list[Sent] = []

        def keep(sent: Sent) -> Sent:
            seen.append(sent)
            return sent

        relay.forge = keep
        assert await node.advance(0.1) == pytest.approx(0.1)
        (sent,) = [sent for sent in seen if sent.verb == wire.ADVANCE.name]
        later = wire.encode(wire.Advance(until=9.0))
        for forged in (
            sent,
            replace(sent, payload=later),
            replace(sent, attachment=wire.encode_sender(node._address.sender)),
        ):
            (answer,) = await forward(router, forged)
            assert read_refusal(answer.payload).code == wire.DENIED
        assert await node.advance(0.2) == pytest.approx(0.2)
