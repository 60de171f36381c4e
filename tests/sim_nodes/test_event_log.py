"""Streams of nodes over Zenoh, and events for waiting clients."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.session import Bound, Mailbox, Refused, Sample, open_session, subscribing
from seoro.bridges.wire import AwaitEvents, SensorName, SimulationState, decode
from sim_nodes.event_log import KEPT, EventLog
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.test_node import running

pytestmark = pytest.mark.engine("mujoco")


async def test_a_playing_node_publishes_samples_and_reports_events(tmp_path: Path) -> None:
    async with (
        running(tmp_path) as node,
        open_session(connect=f"unixsock-stream/{tmp_path}/hub") as viewer,
    ):
        reported: Mailbox[wire.StreamUpdate] = Mailbox(Bound(1000))

        def take(sample: Sample) -> None:
            reported.put(decode(wire.StreamUpdate, sample.payload, wire.ANSWER), 1)

        request = wire.OpenStream(id="view", sensors=(SensorName(robot=ROBOT, sensor="lidar"),))
        async with subscribing(viewer, wire.node_stream("default", "sim", "view"), take):
            await node.ask(wire.OPEN_STREAM, request)
            await node.ask(wire.DRIVE, wire.Drive(id="go", robot=ROBOT, linear=0.2, angular=0.0, duration=0.3))
            waiting = asyncio.create_task(node.ask(wire.AWAIT_EVENTS, AwaitEvents(wait=5.0)))
            await node.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=SimulationState.PLAYING))
            [event] = (await asyncio.wait_for(waiting, 30.0)).events
            assert event.occurrence is not None
            assert (event.number, event.occurrence.id) == (1, "go")
            assert event.occurrence.time == pytest.approx(0.3)
            first = [await reported.get() for _ in range(15)]
            assert [each.number for each in first] == list(range(1, 16))
            assert sum(len(each.samples) for each in first) == 3
        # Without subscribers, the stream ends, and its name is free.
        await node.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=SimulationState.PAUSED))
        for _ in range(100):
            await node.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=300))
            with suppress(Refused):
                await node.ask(wire.OPEN_STREAM, request)
                return
        raise AssertionError("the stream has not ended")


async def test_waiting_requests_do_not_block_others_and_are_answered_in_time(tmp_path: Path) -> None:
    async with running(tmp_path) as node:
        loop = asyncio.get_running_loop()
        begin = loop.time()
        waiting = asyncio.create_task(node.ask(wire.AWAIT_EVENTS, AwaitEvents(wait=1.0)))
        await node.ask(wire.ADVANCE, wire.Advance(until=0.1))
        assert not waiting.done()
        assert await waiting == wire.LoggedEvents(number=0)
        assert 0.95 < loop.time() - begin < 5.0
        for asked in (AwaitEvents(since=3, wait=0.1), AwaitEvents(wait=60.0)):
            with pytest.raises(Refused):
                await node.ask(wire.AWAIT_EVENTS, asked)


def test_grants_return_the_same_events_to_each_client(empty: Client) -> None:
    assert empty.ask(wire.AWAIT_EVENTS, AwaitEvents()).number == 0
    empty.ask(wire.DRIVE, wire.Drive(id="go", robot=ROBOT, linear=0.2, angular=0.0, duration=0.3))
    [occurrence] = empty.advance(1.0).occurrences
    reported = empty.ask(wire.AWAIT_EVENTS, AwaitEvents())
    assert [each.occurrence for each in reported.events] == [occurrence]
    assert empty.ask(wire.AWAIT_EVENTS, AwaitEvents(since=reported.number)).events == ()


def test_events_logged_while_playing_are_not_pending_for_grants(empty: Client) -> None:
    empty.ask(wire.AWAIT_EVENTS, AwaitEvents())
    empty.ask(wire.DRIVE, wire.Drive(id="go", robot=ROBOT, linear=0.2, angular=0.0, duration=0.3))
    empty.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=200))
    assert empty.advance(1.0).occurrences == ()
    assert len(empty.ask(wire.AWAIT_EVENTS, AwaitEvents()).events) == 1


def test_rewound_events_are_removed_from_the_log() -> None:
    client = Client("maze", 3)
    client.localise()
    client.navigate(pose(0.5, 0.0))
    advanced = client.ask(wire.ADVANCE, wire.Advance(until=0.02, horizon=4.0))
    assert advanced.time > 0.1
    before = client.simulator.log.number
    client.ask(wire.REWIND, wire.Rewind(time=0.02))
    assert client.simulator.log.number == before - len(advanced.occurrences + advanced.contacts) == 0


def test_a_log_drops_old_events() -> None:
    log = EventLog()
    for number in range(KEPT + 10):
        log.add(wire.Contact(time=float(number), first="a", second="b"))
    assert len(log.since(10).events) == KEPT
    assert [each.number for each in log.since(KEPT + 8).events] == [KEPT + 9, KEPT + 10]
    with pytest.raises(Exception, match="unknown event number 9"):
        log.since(9)


def test_world_changes_are_logged_with_their_numbers() -> None:
    client = Client("empty")

    def reported() -> list[wire.WorldChange | None]:
        return [each.world for each in client.ask(wire.AWAIT_EVENTS, AwaitEvents()).events]

    def number() -> int:
        return client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).world_number

    saved = client.simulator.save()
    client.ask(wire.LOAD_WORLD, wire.LoadWorld(world="empty", seed=5))  # the same, anew
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation())
    assert (reported(), number()) == ([], 1)
    client.ask(wire.LOAD_WORLD, wire.LoadWorld(world="maze"))
    with pytest.raises(Exception, match="moon"):
        client.ask(wire.LOAD_WORLD, wire.LoadWorld(world="moon"))
    client.ask(wire.UNLOAD_WORLD, wire.Empty())
    client.ask(wire.LOAD_WORLD, wire.LoadWorld(world="maze"))
    client.simulator.restore(saved, wire.Purpose.CONTINUE, None)
    worlds = [(each.number, each.world) for each in reported() if each is not None]
    assert worlds == [(2, "maze"), (3, ""), (4, "maze"), (5, "empty")]
    assert number() == 5


@pytest.mark.parametrize(
    "end",
    [
        (wire.RESET_SIMULATION, wire.ResetSimulation()),
        (wire.LOAD_WORLD, wire.LoadWorld(world="empty")),
        (wire.UNLOAD_WORLD, wire.Empty()),
        (wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE)),
    ],
)
def test_dropped_goals_are_logged(
    empty: Client, end: tuple[wire.Verb[wire.Message, wire.Message], wire.Message]
) -> None:
    empty.ask(wire.DRIVE, wire.Drive(id="go", robot=ROBOT, linear=0.2, angular=0.0, duration=9.0))
    empty.advance(0.1)
    empty.ask(*end)
    reported = empty.ask(wire.AWAIT_EVENTS, AwaitEvents()).events
    assert [each.occurrence.id for each in reported if each.occurrence is not None] == ["go"]
