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
from seoro.bridges.seals import node_seals
from seoro.bridges.secured import security_of
from seoro.bridges.session import (
    Answer,
    AsyncSession,
    NoServer,
    Refused,
    Request,
    Session,
    open_session,
    publishing,
)
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire.refusal import said_in
from seoro.cli.main import main
from seoro.errors import BackendLost, InvalidUse
from seoro.keys.audit import check_log
from seoro.keys.folder import VARIABLE, read_keys
from seoro.keys.roles import Role
from seoro.keys.sealing import prove, seal_urgently
from seoro.keys.signing import certificate_der
from seoro.lab.commanding import release_all, stop_all
from seoro.lab.seeing import look
from seoro.runtime.contracts import Report
from tests.bridges.robot.conftest import rails_at
from tests.labs import KeyedLab, command, free_port, make_lab
from tests.relays import Relay, Sent, honest, relaying, say, unchanged

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
    """Where a node is reached: its endpoint, its name, one of its robots, and its log."""

    endpoint: str
    node: str
    robot: str
    log: Path

    def entries(self) -> list[tuple[str, str | None, str]]:
        """What the node has written down, which holds: what, by whom if that is known, and whether it was done."""
        checked = check_log(self.log, read_keys(self.log.parents[3] / "keys" / "vera").authority)
        assert checked.writers == (self.node,)
        lines = [json.loads(line) for line in self.log.read_bytes().splitlines()]
        return [(line["what"], line["by"], line.get("outcome", "")) for line in lines]


@pytest.fixture(scope="module")
def places(lab: KeyedLab, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Place]]:
    """A simulator that listens, a bridge behind a router, and one behind a router that lets everything pass."""
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


def test_an_operator_sees_leases_releases_and_stops(
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


def test_a_viewer_sees_and_is_told_who_may_do_the_rest(
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
        assert f"the keys here are those of vera (viewer): `{verb}` is for one who is operator" in out
    assert "EMERGENCY" not in seoro(lab, "anna", capsys, "lab", "status", *at)[1]


async def test_a_viewer_without_seoro_is_refused_by_the_node(places: dict[str, Place], lab: KeyedLab) -> None:
    """Behind a router that somebody else runs, which lets everything pass."""
    place, keys = places["open"], read_keys(lab.keys("vera"))
    requests = {
        wire.TAKE_ROBOTS.name: wire.Holder(holder="run-vera"),
        wire.EMERGENCY_STOP.name: wire.EmergencyStop(by="vera"),
        wire.DRIVE.name: wire.Drive(id="x", robot="second", linear=0.2, angular=0.0, duration=1.0),
        wire.STEP_SIMULATION.name: wire.StepSimulation(steps=1),
    }
    async with somebody(lab, place.endpoint, "vera") as session:
        address = NodeAddress(session, wire.NAMESPACE, place.node, seals=node_seals(session, place.node, keys))
        await address.prove()
        assert address.seals is not None
        for verb, request in requests.items():
            key, payload = wire.node_command(wire.NAMESPACE, place.node, verb), wire.encode(request)
            sealed = seal_urgently(keys, key, payload)
            if verb != wire.EMERGENCY_STOP.name:
                assert address.seals._sealer is not None
                sealed = address.seals._sealer.seal(key, payload)
            for beside in (None, wire.sender("run-vera"), sealed):
                with pytest.raises(Refused) as caught:
                    await session.query(key, payload, 5.0, beside)
                assert said_in(caught.value.payload).code == wire.DENIED
        key, payload = wire.emergency_key(wire.NAMESPACE), wire.encode(wire.EmergencyStop(by="vera"))
        async with publishing(session, key) as publisher:
            await publisher.wait_for_subscriber()
            publisher.put(payload)
            publisher.put(payload, seal_urgently(keys, key, payload))
            with anyio.fail_after(DEADLINE):
                while ("emergency_stop", "vera", "refused") not in place.entries():
                    await anyio.sleep(0.01)
        found = await ask(address, wire.GET_LAB_STATE, wire.Empty())
        assert found.stopped is None
    assert not any(by == "vera" and outcome == "done" for _, by, outcome in place.entries())


async def test_what_was_said_is_not_taken_again(places: dict[str, Place], lab: KeyedLab) -> None:
    place, keys = places["open"], read_keys(lab.keys("anna"))
    async with somebody(lab, place.endpoint, "anna") as session:
        seals = node_seals(session, place.node, keys)
        assert seals is not None
        await seals.prove()
        lease = wire.LeaseRobots(lease="hand-1", robots=("second",))
        for verb, request in ((wire.LEASE_ROBOTS, lease), (wire.EMERGENCY_STOP, wire.EmergencyStop(by="anna"))):
            key, payload = wire.node_command(wire.NAMESPACE, place.node, verb.name), wire.encode(request)
            seal = await seals.seal(verb.name, key, payload)
            await session.query(key, payload, 5.0, seal)
            with pytest.raises(Refused) as caught:
                await session.query(key, payload, 5.0, seal)
            assert "said before" in said_in(caught.value.payload).message
        assert [each.error for each in await release_all([place.endpoint], "anna", "over")] == [""]
        address = NodeAddress(session, wire.NAMESPACE, place.node, seals=seals)
        await ask(address, wire.RELEASE_LEASE, wire.ReleaseLease(lease="hand-1"))


async def test_who_holds_robots_is_not_told_to_others(places: dict[str, Place], lab: KeyedLab) -> None:
    """By that name robots are moved."""
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


async def test_a_node_has_to_be_the_one_of_its_name(places: dict[str, Place], lab: KeyedLab) -> None:
    """Who has the keys of another node may take its name at a router, but not prove that it has it."""
    place = places["routed"]
    security = security_of(place.endpoint, read_keys(lab.keys("other")))
    forged, keys = Session(connect=place.endpoint, security=security), read_keys(lab.keys("other"))

    def answer(request: Request) -> None:
        if request.key.endswith(wire.GET_LAB_STATE.name):
            request.reply(wire.encode(wire.LabState(kind="bridge", version="0.1.0", robots=())))
            return
        if not request.key.endswith(wire.CHALLENGE.name):
            request.reply(wire.encode(wire.EmergencyStopped(stopped=(), took=0.0)))
            return
        nonce, exchange = wire.decode(wire.Challenge, request.payload).nonce, bytes(32)
        signature = prove(keys, "floor", nonce, "b00t", 0, exchange)
        certificate = certificate_der(keys.certificate)
        proof = wire.Proof(certificate=certificate, signature=signature, boot="b00t", now=0, exchange=exchange)
        request.reply(wire.encode(proof))

    words = "the node 'floor' is not to be trusted: who answers for the node 'floor' has the keys of other"
    try:
        forged.answer(wire.node_command(wire.NAMESPACE, "floor", "*"), answer)
        forged.declare_token(wire.node_token(wire.NAMESPACE, "floor", "b00t"))
        with pytest.raises(InvalidUse, match=words):
            async with connect_robots(place.endpoint, "a run", "floor"):
                pass
        outcomes = {each.called: each for each in await stop_all([place.endpoint], "anna", "smoke")}
        unsigned = "the answer of the node 'floor' to `emergency_stop` is not authentic: it is not signed"
        assert unsigned in outcomes["the node 'floor'"].error
        assert outcomes["the node 'rails'"].error == ""
        (floor,) = [each for each in await look([place.endpoint]) if each.node == "floor"]
        assert words in floor.why
    finally:
        forged.close()
        await release_all([place.endpoint], "anna", "it was a test")


async def test_an_emergency_stop_with_keys_is_as_fast(place: Place) -> None:
    times: list[float] = []
    while len(times) < ATTEMPTS and not (times and min(times) < WITHIN):  # each may be that of a busy machine
        try:
            async with connect_robots(place.endpoint, "a run", robots=("second",)) as node:
                await node.drive("second", 0.2, 0.0, 600.0, lambda report: None)
                (outcome,) = await stop_all([place.endpoint], "anna", "smoke")
                assert outcome.error == ""
                times.append(outcome.took)
        finally:
            await release_all([place.endpoint], "anna", "it is over")
    assert min(times) < WITHIN


async def test_whose_keys_are_revoked_is_out_of_a_simulator(places: dict[str, Place], lab: KeyedLab) -> None:
    lab.authority.add("rob", Role.OPERATOR, lab.keys("rob"))
    place = places["listens"]
    key = wire.node_command(wire.NAMESPACE, place.node, wire.GET_LAB_STATE.name)
    async with somebody(lab, place.endpoint, "rob") as rob, somebody(lab, place.endpoint, "anna") as anna:
        await rob.query(key, wire.encode(wire.Empty()), 5.0)
        lab.revoke("rob", "hall")
        with anyio.fail_after(DEADLINE), pytest.raises(NoServer):
            while True:
                await rob.query(key, wire.encode(wire.Empty()), 5.0)
        with anyio.fail_after(DEADLINE):
            while True:
                try:
                    await anna.query(key, wire.encode(wire.Empty()), 5.0)
                    break
                except NoServer:
                    await anyio.sleep(0.01)
        with pytest.raises(NoServer):
            await rob.query(key, wire.encode(wire.Empty()), 5.0)


def test_a_node_has_the_name_in_its_keys(lab: KeyedLab, capsys: pytest.CaptureFixture[str]) -> None:
    where = ("--listen", f"tls/127.0.0.1:{free_port()}", "--keys", str(lab.keys("hall")))
    assert main(["bridge", "ros2", "--robot", "turtlebot4", "--name", "floor", *where]) != 0
    assert "the node 'floor' cannot have the keys of hall (node)" in capsys.readouterr().err


@asynccontextmanager
async def between(lab: KeyedLab, place: Place) -> AsyncIterator[tuple[Relay, str]]:
    """A router that somebody else runs, and its endpoint."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    keys = [security_of(endpoint, read_keys(lab.keys(name))) for name in ("hub", "ada")]
    async with relaying(endpoint, place.endpoint, (keys[0], keys[1])) as relay:
        yield relay, endpoint


@pytest.mark.parametrize("name", ["open", "listens"])
async def test_answers_of_nodes_are_not_changed_on_the_way(
    places: dict[str, Place], lab: KeyedLab, name: str
) -> None:
    """By whoever runs the router, or is asked in the place of the node."""
    place = places[name]
    async with between(lab, place) as (relay, endpoint):
        (member,) = await look([endpoint])
        assert (member.why, member.state is None) == ("", False)
        relay.replace(b"second", b"nobody", "get_lab_state")
        (member,) = await look([endpoint])
        unsigned = (
            f"the answer of the node '{place.node}' to `get_lab_state` is not authentic: the signature is wrong"
        )
        assert unsigned in member.why
        relay.replace(b"stopped", b"stOpped", "emergency_stop")
        try:
            (outcome,) = await stop_all([endpoint], "anna", "smoke")
            assert "to `emergency_stop` is not authentic: the signature is wrong" in outcome.error
            relay.change = unchanged
            (member,) = await look([endpoint])
            assert member.state is not None
            assert member.state.stopped is not None  # all the same
        finally:
            relay.change = unchanged
            assert [each.error for each in await release_all([endpoint], "anna", "it was a test")] == [""]


async def test_what_happens_to_robots_is_not_changed_on_the_way(places: dict[str, Place], lab: KeyedLab) -> None:
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
        assert "to `hold_robots` is not authentic: the signature is wrong" in str(lost[0])
        assert len(reports) == 1


async def test_the_time_of_a_simulator_is_not_changed_on_the_way(places: dict[str, Place], lab: KeyedLab) -> None:
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
        with pytest.raises(BackendLost, match="to `advance` is not authentic: the signature is wrong"):
            await node.advance(0.3)


async def test_a_router_does_not_move_the_robots_of_a_run(places: dict[str, Place], lab: KeyedLab) -> None:
    """By requests in the name of the run, by those of the run that are changed, or said again."""
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
            name = wire.sender(node._holder.holder)
            driven = next(sent for sent in seen if sent.verb == wire.DRIVE.name)
            held = next(sent for sent in reversed(seen) if sent.verb == wire.HOLD_ROBOTS.name)
            ending = wire.encode(wire.Holder(holder=node._holder.holder))
            forged = (
                driven,
                held,
                replace(driven, payload=wire.encode(drive)),
                replace(driven, payload=wire.encode(drive), beside=name),
                replace(driven, key=driven.key.replace("drive", "release_robots"), payload=ending, beside=name),
            )
            for sent in forged:
                (answer,) = await say(router, sent)
                assert said_in(answer.payload).code == wire.DENIED
            relay.forge = lambda sent: replace(sent, payload=wire.encode(drive)) if sent.verb == "drive" else sent
            with pytest.raises(BackendLost, match="to `drive` is not authentic"):
                await node.drive("second", 0.1, 0.0, 600.0, lambda report: None)
            relay.forge = honest
            goal = await node.drive("second", 0.0, 0.0, 600.0, lambda report: None)  # it still holds the robot
            await node.cancel_goal(goal)
    assert any((what, by, outcome) == ("drive", None, "refused") for what, by, outcome in place.entries())


async def test_a_router_does_not_pass_the_time_of_a_simulator(places: dict[str, Place], lab: KeyedLab) -> None:
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
            replace(sent, beside=wire.sender(node._address.sender)),
        ):
            (answer,) = await say(router, forged)
            assert said_in(answer.payload).code == wire.DENIED
        assert await node.advance(0.2) == pytest.approx(0.2)
