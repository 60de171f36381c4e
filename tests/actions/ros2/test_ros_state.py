"""Runs publish their state."""

from dataclasses import replace
from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.state.publishing import BEHAVIORS, MARKERS
from seoro.bridges.ros2.state.stopping import STOP, TRIGGER
from seoro.bridges.ros2.wire import Durability, Qos, RmwZenoh
from seoro.embed import prepare
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import options
from tests.runtime.conftest import load_text

LATE = Qos(depth=1, durability=Durability.TRANSIENT_LOCAL)
SCENARIO = """
import osc.helpers

scenario main:
    event arrived
    do serial:
        emit arrived
        wait elapsed(60s)
"""


async def test_viewers_see_the_tree_and_the_events_of_a_run(router: str, tmp_path: Path) -> None:
    """Also viewers that come later."""
    scenario = load_text(tmp_path, SCENARIO, ())
    with anyio.fail_after(60.0):
        async with (
            prepare(scenario, options(router)) as run,
            run.running(),
            connect(router, types=TypeStore.bundled(), dialect=RmwZenoh()) as system,
            system.node("viewer") as viewer,
            viewer.subscribing(BEHAVIORS, "diagnostic_msgs/msg/DiagnosticArray", LATE) as behaviors,
            viewer.subscribing(MARKERS, "visualization_msgs/msg/MarkerArray", LATE) as markers,
        ):
            states = {each.name: each.message for each in (await behaviors.message()).status}
            while states.get("seoro/main/serial[0]/wait[1]") != "running":
                states = {each.name: each.message for each in (await behaviors.message()).status}
            assert states["seoro"] == states["seoro/main"] == "running"
            assert states["seoro/main/serial[0]/emit[0]"] == "succeeded"
            (events,) = (await markers.message()).markers
            assert events.text.endswith(" s  main.arrived")
            run.stop("seen")
            while states["seoro"] == "running":
                states = {each.name: each.message for each in (await behaviors.message()).status}
            assert states["seoro"] == "cancelled: seen"
            assert states["seoro/main/serial[0]/wait[1]"] == "cancelled"


@pytest.mark.parametrize("state", [True, False])
async def test_runs_may_keep_their_state(router: str, tmp_path: Path, state: bool) -> None:
    text = 'import osc.ros\nscenario main:\n    do wait_for_data("/later", "std_msgs/msg/Int64")\n'
    scenario = load_text(tmp_path, text, ())
    given = options(router)
    assert given.ros is not None
    ros = type(given.ros)(given.ros.endpoint, dialect=given.ros.dialect, state=state)
    async with (
        connect(router, types=TypeStore.bundled(), dialect=RmwZenoh()) as system,
        prepare(scenario, replace(given, ros=ros)) as run,
        run.running(),
    ):
        with anyio.fail_after(60.0):
            await system.graph.wait_for(lambda graph: graph.subscriptions("/later"))  # all others came before
        assert bool(system.graph.publishers(BEHAVIORS)) is bool(system.graph.servers(STOP)) is state
        run.stop("seen")


STOPPED = """
import osc.helpers

scenario main:
    do parallel:
        topic_publish("/velocity", "geometry_msgs/msg/Twist", "{linear: {x: 0.2}}")
        wait elapsed(600s)
"""


async def test_other_nodes_stop_a_run(router: str, tmp_path: Path) -> None:
    scenario = load_text(tmp_path, "import osc.ros\n" + STOPPED, ())
    with anyio.fail_after(60.0):
        async with (
            connect(router, types=TypeStore.bundled(), dialect=RmwZenoh()) as system,
            system.node("operator") as operator,
            operator.calling(STOP, TRIGGER) as stop,
            prepare(scenario, options(router)) as run,
        ):
            await stop.wait_for_server()
            early = await stop.call({})
            assert (early.success, early.message.partition(":")[0]) == (False, "no run is active")
            async with run.running():
                async for record in run.trace():
                    if record["kind"] == "behavior.start" and record["type"] == "wait":
                        break
                assert (await stop.call({})).success
                verdict = await run.result()
                kinds = [record["kind"] async for record in run.trace()]
            assert (verdict.status, verdict.reason) == (RunStatus.CANCELLED, "stopped by the service /seoro/stop")
            assert kinds[-1] == "run.end"
            assert kinds.count("behavior.end") == kinds.count("behavior.start") == 4
            assert not (await stop.call({})).success
